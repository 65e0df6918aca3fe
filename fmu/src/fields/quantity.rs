//! The one table of quantities: names, units, components, meanings, and how each follows from a [`Local`] state.

use std::fmt::Write as _;

/// Where a quantity is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// At the points only.
    Points,
    /// In the cells only.
    Cells,
    /// At the points, and as means over the cells.
    Both,
}

/// One quantity.
#[derive(Debug)]
pub struct Quantity {
    /// Name of the array, with its unit.
    pub name: &'static str,
    /// Unit; 1 where there is none.
    pub unit: &'static str,
    /// Names of the components.
    pub components: &'static [&'static str],
    /// What it is, for a person.
    pub description: &'static str,
    /// Where it is given.
    pub place: Support,
    pub(super) of: fn(&Local) -> [f64; 4],
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// What is known at a point, or in the mean of a cell.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Local {
    /// Initial solid fraction.
    pub n0s: f64,
    /// `u_r`, `u_z` (m).
    pub displacement: [f64; 2],
    /// Pore pressure (Pa).
    pub pressure: f64,
    /// J.
    pub jacobian: f64,
    /// Length of `F e_z`.
    pub stretch: f64,
    /// Effective Cauchy stress rr, zz, tt, rz (Pa).
    pub effective: [f64; 4],
    /// Seepage velocity r, z (m/s).
    pub seepage: [f64; 2],
    /// Viscous dissipation per undeformed volume (W/m^3).
    pub viscous: f64,
    /// Porous dissipation per undeformed volume (W/m^3).
    pub porous: f64,
    /// Whether the punch touches.
    pub contact: bool,
    /// Undeformed volume of the ring (m^3).
    pub volume: f64,
}

impl Local {
    fn solid_fraction(&self) -> f64 {
        self.n0s / self.jacobian
    }

    fn total(&self) -> [f64; 4] {
        let [rr, zz, tt, rz] = self.effective;
        [rr - self.pressure, zz - self.pressure, tt - self.pressure, rz]
    }
}

const SCALAR: &[&str] = &["value"];
const VECTOR: &[&str] = &["r", "t", "z"];
const STRESS: &[&str] = &["rr", "zz", "tt", "rz"];

const fn scalar(value: f64) -> [f64; 4] {
    [value, 0.0, 0.0, 0.0]
}

const fn vector([r, z]: [f64; 2]) -> [f64; 4] {
    [r, 0.0, z, 0.0]
}

const fn quantity(
    name: &'static str,
    unit: &'static str,
    components: &'static [&'static str],
    place: Support,
    description: &'static str,
    of: fn(&Local) -> [f64; 4],
) -> Quantity {
    Quantity { name, unit, components, description, place, of }
}

/// All of them.
pub static QUANTITIES: [Quantity; 13] = [
    quantity("displacement_m", "m", VECTOR, Support::Points, "Displacement of the solid", |l| {
        vector(l.displacement)
    }),
    quantity("pore_pressure_Pa", "Pa", SCALAR, Support::Both, "Pore pressure p", |l| scalar(l.pressure)),
    quantity("jacobian", "1", SCALAR, Support::Both, "J = det F, present over undeformed volume", |l| {
        scalar(l.jacobian)
    }),
    quantity("solid_fraction", "1", SCALAR, Support::Both, "Solid volume fraction n0S / J", |l| {
        scalar(l.solid_fraction())
    }),
    quantity("porosity", "1", SCALAR, Support::Both, "Fluid volume fraction 1 - n0S / J", |l| {
        scalar(1.0 - l.solid_fraction())
    }),
    quantity(
        "vertical_stretch",
        "1",
        SCALAR,
        Support::Both,
        "Stretch of a line that was vertical: the length of F e_z (Fig. 1C), below 1 where it is shortened",
        |l| scalar(l.stretch),
    ),
    quantity(
        "stress_total_Pa",
        "Pa",
        STRESS,
        Support::Both,
        "Total Cauchy stress: effective less pore pressure (Eq. 7)",
        Local::total,
    ),
    quantity(
        "stress_effective_Pa",
        "Pa",
        STRESS,
        Support::Both,
        "Cauchy stress of the skeleton: equilibrium, branches and volumetric part (Eqs. 8-10)",
        |l| l.effective,
    ),
    quantity(
        "seepage_velocity_m_per_s",
        "m/s",
        VECTOR,
        Support::Both,
        "Velocity of the fluid relative to the solid times porosity, in the deformed sample (Eq. 11)",
        |l| vector(l.seepage),
    ),
    quantity(
        "viscous_dissipation_W_per_m3",
        "W/m3",
        SCALAR,
        Support::Both,
        "Viscous dissipation rate per undeformed volume (Eq. 13)",
        |l| scalar(l.viscous),
    ),
    quantity(
        "porous_dissipation_W_per_m3",
        "W/m3",
        SCALAR,
        Support::Both,
        "Porous dissipation rate per undeformed volume (Eq. 14)",
        |l| scalar(l.porous),
    ),
    quantity(
        "contact",
        "1",
        SCALAR,
        Support::Points,
        "1 where the punch touches the surface, 0 elsewhere",
        |l| scalar(if l.contact { 1.0 } else { 0.0 }),
    ),
    quantity(
        "undeformed_volume_m3",
        "m3",
        SCALAR,
        Support::Cells,
        "Undeformed volume of the whole ring: a mean times this is the integral over the ring",
        |l| scalar(l.volume),
    ),
];

/// The table of the documentation, `fmu/src/fields/README.md`.
pub fn markdown() -> String {
    let mut text = String::from(
        "# Fields\n\n\
         What stands in the VTU files. Written from the table in `quantity.rs` by `cargo run --release -q -p \
         poropunch --example field_table > fmu/src/fields/README.md`.\n\n\
         | array | components | unit | where | what |\n|---|---|---|---|---|\n",
    );
    for q in &QUANTITIES {
        let components = if q.components.len() == 1 { String::new() } else { q.components.join(", ") };
        let place = match q.place {
            Support::Points => "points",
            Support::Cells => "cells",
            Support::Both => "points, cells",
        };
        // Writing to a String cannot fail.
        let _ = writeln!(text, "| `{}` | {components} | {} | {place} | {} |", q.name, q.unit, q.description);
    }
    text += "\n\
        Displacement and pore pressure at the points are the unknowns themselves; at mid-side points the pressure is\n\
        that of the linear interpolation. Everything else is known at quadrature points: in every cell the linear\n\
        function closest to their values is taken to the points, where the cells around a point are averaged. J, and\n\
        with it the fractions, and the volumetric stress come from the 2 x 2 points of the volumetric law, the rest\n\
        from the 3 x 3 points. Cell data are means over the undeformed volume, unsmoothed. Next to the punch's edge,\n\
        where the exact stress is singular, point data are a picture, not a measurement: the force is an output.\n";
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_carry_their_units() {
        for q in &QUANTITIES {
            let unit = q.unit.replace('/', "_per_");
            assert!(q.unit == "1" || q.name.ends_with(&format!("_{unit}")), "{}", q.name);
            assert!(q.components.len() <= 4 && !q.description.is_empty(), "{}", q.name);
            assert_eq!(QUANTITIES.iter().filter(|other| other.name == q.name).count(), 1);
        }
    }

    #[test]
    fn documentation_is_fresh() {
        let committed = include_str!("README.md");
        assert!(
            committed == markdown(),
            "fmu/src/fields/README.md is stale: run `cargo run --release -q -p poropunch --example field_table \
             > fmu/src/fields/README.md`"
        );
    }
}
