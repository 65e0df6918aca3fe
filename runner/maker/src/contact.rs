//! Contact with the flat face: penalty in the normal direction, elastic stick and Coulomb slip along the face.
//!
//! Written at the Gauss points of the sides under the face; a point is free, sticks where it touched, or slides.

use crate::time::Formula;

/// Resistance to sliding along the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Friction {
    /// Coulomb's coefficient [-]; a large one sticks.
    Coulomb(f64),
    /// The same once a part of the face has opened; a face that is pressed everywhere sticks, whatever its shear.
    Bond(f64),
    /// No slip.
    Held,
    /// A viscous film: shear traction over sliding velocity (Pa s/m).
    Film(f64),
}

/// Traction that holds a touched point across a gap g: `strength exp(-g/opening)`; lost for good beyond `6 opening`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cohesion {
    /// Largest traction (Pa).
    pub strength: f64,
    /// Decay length (m).
    pub opening: f64,
}

/// The law of the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Along the face.
    pub friction: Friction,
    /// Across the face.
    pub cohesion: Option<Cohesion>,
    /// Viscous film of sliding points (Pa s/m): small, so that small steps know no jump between stick and slip.
    pub slip_film: f64,
}

/// What a point of the surface remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Touch {
    /// It is pressed on the face.
    pub closed: bool,
    /// It has been since the bond last broke.
    pub bonded: bool,
    /// Resistance of the face against its radial displacement (Pa).
    pub shear: f64,
    /// Height above the face (m).
    pub gap: f64,
    /// Radial displacement (m).
    pub radial: f64,
    /// Pressure of the face (Pa).
    pub pressure: f64,
}

/// Tractions (Pa) and their slopes (Pa/m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Traction {
    /// Which branch of the law it is on: the slopes jump from one to the next.
    pub branch: u8,
    /// Pressure on the surface.
    pub normal: f64,
    /// Its derivative by the penetration.
    pub normal_slope: f64,
    /// Resistance, against positive radial displacement.
    pub radial: f64,
    /// Its derivative by the radial displacement.
    pub radial_slope: f64,
}

/// Stiffness of stick over the normal penalty: a stiffer one makes Newton's method jump between stick and slip.
const STICK: f64 = 0.003;
/// The same of what cannot slip. A softer one yields where a gel stiffens: 0.4 % of the force at alpha = -13.
const HELD: f64 = 0.3;

/// Lag of the cohesive traction behind a changing gap (s): bonds that break all at once would have no equilibrium.
const COHESION_LAG_S: f64 = 0.01;

impl Face {
    /// The law of a step that begins with these points.
    #[must_use]
    pub fn at(self, points: &[Touch]) -> Self {
        match self.friction {
            Friction::Bond(_) if points.iter().all(|t| t.closed) => Self { friction: Friction::Held, ..self },
            _ => self,
        }
    }

    /// Tractions of a point with penetration and radial displacement (m) at the end of a step, from what it remembers of the two ends
    /// before, and its new memory.
    pub fn respond(
        &self,
        penalty: f64,
        (last, before): (&Touch, &Touch),
        penetration: f64,
        radial: f64,
        formula: &Formula,
    ) -> (Traction, Touch) {
        let step = formula.step;
        let gap = -penetration;
        let mut t = Traction::default();
        let mut now = Touch { closed: penetration > 0.0, gap, radial, ..*last };
        let hold = self.cohesion.filter(|_| last.bonded || now.closed).map(|c| (c, c.strength / penalty));
        match hold {
            Some((c, begin)) if gap > begin => {
                let traction = c.strength * (-(gap - begin) / c.opening).exp();
                let rate = COHESION_LAG_S / (c.opening * step);
                let moved = 1.0 + rate * (gap - last.gap.max(0.0));
                if moved > 0.0 {
                    t.normal = -traction * moved;
                    t.normal_slope = traction * (rate - moved / c.opening);
                    t.branch = 1;
                }
                now.bonded = gap < 6.0 * c.opening;
            }
            Some(_) => {
                (t.normal, t.normal_slope, t.branch, now.bonded) = (penalty * penetration, penalty, 2, true)
            }
            None if now.closed => (t.normal, t.normal_slope, t.branch) = (penalty * penetration, penalty, 2),
            None => {}
        }
        now.pressure = t.normal.max(0.0);
        if hold.is_none() {
            now.bonded = now.closed;
        }
        now.shear = 0.0;
        if !last.closed {
            return (t, now);
        }
        // Friction is that of the beginning of the step: the tangent stays symmetric, and a point that flickers between
        // open and closed has no shear to let go.
        match self.friction {
            Friction::Film(resistance) => {
                // A velocity by backward Euler would err by a part of the step; a point that has just touched has no other.
                let formula = if before.closed { *formula } else { Formula::first_order(step) };
                let [start] = formula.start(&[last.radial], &[before.radial]);
                t.radial_slope = resistance / formula.gamma;
                t.radial = t.radial_slope * (radial - start);
            }
            Friction::Coulomb(coefficient) | Friction::Bond(coefficient) => {
                let stiffness = STICK * penalty;
                let stick = last.shear + stiffness * (radial - last.radial);
                let limit = coefficient * last.pressure;
                let beyond = stick.abs() - limit;
                if beyond <= 0.0 {
                    (t.radial, t.radial_slope) = (stick, stiffness);
                } else {
                    t.branch += if stick > 0.0 { 4 } else { 8 };
                    let film = self.slip_film / step;
                    let share = film / (stiffness + film);
                    t.radial = (limit + share * beyond).copysign(stick);
                    t.radial_slope = share * stiffness;
                }
            }
            Friction::Held => {
                t.radial_slope = HELD * penalty;
                t.radial = last.shear + t.radial_slope * (radial - last.radial);
            }
        }
        if now.closed {
            now.shear = t.radial;
        }
        (t, now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_derivatives() {
        let cohesion = Some(Cohesion { strength: 100.0, opening: 1e-4 });
        let last =
            Touch { closed: true, bonded: true, shear: 30.0, gap: 1e-5, radial: 2e-6, pressure: 300.0 };
        let before = Touch { radial: 1e-6, ..last };
        let formula = Formula::second_order(0.01, 0.008);
        for friction in [Friction::Coulomb(0.2), Friction::Held, Friction::Film(1e7)] {
            let face = Face { friction, cohesion, slip_film: 1e5 };
            for (penetration, radial) in [(1e-5, 1.5e-6), (1e-6, 9e-6), (-5e-5, 0.0), (-2e-4, 0.0)] {
                let at = |dp: f64, dr: f64| {
                    face.respond(1e8, (&last, &before), penetration + dp, radial + dr, &formula).0
                };
                let (t, h) = (at(0.0, 0.0), 1e-10);
                let by = |f: fn(&Traction) -> f64, dp, dr| (f(&at(dp, dr)) - f(&at(-dp, -dr))) / (2.0 * h);
                assert!((by(|t| t.normal, h, 0.0) - t.normal_slope).abs() < 1e-4 * 1e8);
                assert!((by(|t| t.radial, 0.0, h) - t.radial_slope).abs() < 1e-4 * 1e8);
            }
        }
    }

    #[test]
    fn a_sliding_point_sticks_where_it_stopped() {
        let face = Face { friction: Friction::Coulomb(0.5), cohesion: None, slip_film: 0.0 };
        let respond = |last: &Touch, radial: f64| {
            face.respond(1e8, (last, last), 1e-6, radial, &Formula::first_order(1.0))
        };
        let touch = respond(&Touch::default(), 0.0).1;
        let (t, touch) = respond(&touch, 3e-3);
        assert!((t.radial - 50.0).abs() < 1e-9);
        let (t, _) = respond(&touch, 3e-3 - 50.0 / (STICK * 1e8));
        assert!(t.radial.abs() < 1e-9 && t.radial_slope > 0.0);
    }

    /// A point that is drawn by a spring through a film: its error falls by four for half the steps.
    #[test]
    fn a_film_is_of_second_order_in_time() {
        let (resistance, spring, end) = (1e7, 1e8, 0.1);
        let face = Face { friction: Friction::Film(resistance), cohesion: None, slip_film: 0.0 };
        // The spring's other end moves by 1 mm/s: exact by its relaxation.
        let relaxation = resistance / spring;
        let exact = |t: f64| 1e-3 * (t + relaxation * (-t / relaxation).exp_m1());
        let error = |steps: usize| {
            let step = end / steps as f64;
            let touch = |radial| Touch { closed: true, radial, ..Touch::default() };
            let (mut before, mut last) = (touch(0.0), touch(exact(step)));
            for k in 2..=steps {
                let formula = Formula::second_order(step, step);
                let at_rest = face.respond(1e9, (&last, &before), 1e-6, 0.0, &formula).0;
                let radial =
                    (spring * 1e-3 * (k as f64 * step) - at_rest.radial) / (spring + at_rest.radial_slope);
                before = last;
                last = face.respond(1e9, (&last, &before), 1e-6, radial, &formula).1;
            }
            (last.radial / exact(end) - 1.0).abs()
        };
        let (coarse, fine) = (error(20), error(40));
        assert!(coarse < 2e-3 && (3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine}");
    }
}
