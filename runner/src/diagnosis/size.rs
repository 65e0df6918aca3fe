//! How large forces and lengths of the tests are beside those of the paper's, for which the catalogue's plausible scales were written.
//!
//! A drift of 0.2 mN matters to a peak of 11 mN, not to one of 100 mN, and a branch of 40 Pa to a gel of 500 Pa: a plausible effect
//! is a part of what is measured. Two quantities are enough for all scales: the largest force, and a length L with
//! L^2 = contact radius times depth, so that F / L^2 goes with the modulus. Times are the machine's and nature's own.

use crate::inference::Setup;
use crate::inference::start::Known;
use poropunch::unit::Unit;

/// Largest force (N), radius (m) and depth (m) of the paper's faster test.
const FORCE_N: f64 = 11.9e-3;
const RADIUS_M: f64 = 2e-3;
const DEPTH_M: f64 = 1e-3;

/// Forces and lengths of tests over the paper's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    force: f64,
    length: f64,
}

impl Size {
    /// Of the tests of a fit, from their largest force and depth.
    pub fn of(setup: Setup<'_>) -> Self {
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let force_n = 1e-3 * largest(&mut setup.measured_mn().into_iter());
        let depths = setup.observations.iter().flat_map(|o| &o.measurement.displacement_m);
        let depth_m = largest(&mut depths.copied());
        let at_start = setup.unknowns.settings(setup.unknowns.start());
        let known = Known::of(&|name| setup.value(&at_start, name));
        let radius_m = known.map_or(RADIUS_M, |known| known.rig.contact_radius(depth_m));
        Self::new(force_n, radius_m, depth_m)
    }

    /// Of a largest force (N), a contact radius (m) and a depth (m); that of the paper's tests where one of them is none.
    fn new(force_n: f64, radius_m: f64, depth_m: f64) -> Self {
        let size =
            Self { force: force_n / FORCE_N, length: (radius_m * depth_m / (RADIUS_M * DEPTH_M)).sqrt() };
        let usable = |x: f64| x.is_finite() && x > 0.0;
        if usable(size.force) && usable(size.length) { size } else { Self { force: 1.0, length: 1.0 } }
    }

    /// How many times larger a quantity of this unit is: kg^a m^b is N^a m^(b - a) but for times.
    pub fn factor(self, unit: &Unit) -> f64 {
        let (mass, length, _) = unit.exponents;
        self.force.powi(i32::from(mass)) * self.length.powi(i32::from(length) - i32::from(mass))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use poropunch::unit::*;

    #[test]
    fn quantities_grow_as_their_units_say() {
        assert_eq!(Size::new(FORCE_N, RADIUS_M, DEPTH_M).factor(&PASCAL), 1.0);
        assert_eq!(Size::new(f64::NAN, RADIUS_M, DEPTH_M), Size::new(FORCE_N, RADIUS_M, DEPTH_M));
        // Three times the force, twice the length.
        let size = Size::new(3.0 * FORCE_N, 2.0 * RADIUS_M, 2.0 * DEPTH_M);
        for (unit, factor) in [
            (&NEWTON, 3.0),
            (&METRE, 2.0),
            (&PASCAL, 0.75),
            (&PASCAL_SECOND, 0.75),
            (&PER_PASCAL, 4.0 / 3.0),
            (&METRE_PER_PASCAL, 8.0 / 3.0),
            (&METRE_PER_NEWTON, 2.0 / 3.0),
            (&NEWTON_PER_SECOND, 3.0),
            (&SECOND, 1.0),
            (&PER_SECOND, 1.0),
            (&ONE, 1.0),
        ] {
            approx::assert_relative_eq!(size.factor(unit), factor, max_relative = 1e-14);
        }
    }
}
