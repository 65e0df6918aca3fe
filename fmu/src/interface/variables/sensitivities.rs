//! Entries of the sensitivities: three outputs for every parameter of the material.

use super::row::variable;
use super::settings::SENSITIVITIES;
use super::{Binding, Kind, Variable};
use crate::ForceSensitivity;
use crate::unit::{NEWTON, NEWTON_PER_PASCAL, NEWTON_PER_PASCAL_SECOND, NEWTON_PER_SQUARE_METRE};

/// Boolean parameter that switches the sensitivities on.
pub const SWITCH: &str = "solver.sensitivities";

/// What the names of all derivatives begin with.
pub const PREFIX: &str = "sensitivity.";

/// Name of the derivative of an output by a parameter.
pub fn name(output: &str, parameter: &str) -> String {
    format!("{PREFIX}{output}.{parameter}")
}

/// `sensitivity.<output>.<parameter>` for all parameters, in the order of their indices; `$what` names the output.
macro_rules! sensitivities {
    ($output:literal, $what:literal, $get:expr) => {
        [
            one!($output, $what, "n0s", "the initial solid volume fraction", &NEWTON, $get, 0),
            one!($output, $what, "lambda_star", "the volumetric stiffness", &NEWTON_PER_PASCAL, $get, 1),
            one!(
                $output,
                $what,
                "fluid_viscosity",
                "the pore fluid's viscosity",
                &NEWTON_PER_PASCAL_SECOND,
                $get,
                2
            ),
            one!($output, $what, "permeability", "the permeability", &NEWTON_PER_SQUARE_METRE, $get, 3),
            one!(
                $output,
                $what,
                "equilibrium.mu",
                "mu of the equilibrium response",
                &NEWTON_PER_PASCAL,
                $get,
                4
            ),
            one!($output, $what, "equilibrium.alpha", "alpha of the equilibrium response", &NEWTON, $get, 5),
            branch!($output, $what, "1", "mu", &NEWTON_PER_PASCAL, $get, 6),
            branch!($output, $what, "1", "alpha", &NEWTON, $get, 7),
            branch!($output, $what, "1", "eta", &NEWTON_PER_PASCAL_SECOND, $get, 8),
            branch!($output, $what, "2", "mu", &NEWTON_PER_PASCAL, $get, 9),
            branch!($output, $what, "2", "alpha", &NEWTON, $get, 10),
            branch!($output, $what, "2", "eta", &NEWTON_PER_PASCAL_SECOND, $get, 11),
            branch!($output, $what, "3", "mu", &NEWTON_PER_PASCAL, $get, 12),
            branch!($output, $what, "3", "alpha", &NEWTON, $get, 13),
            branch!($output, $what, "3", "eta", &NEWTON_PER_PASCAL_SECOND, $get, 14),
            branch!($output, $what, "4", "mu", &NEWTON_PER_PASCAL, $get, 15),
            branch!($output, $what, "4", "alpha", &NEWTON, $get, 16),
            branch!($output, $what, "4", "eta", &NEWTON_PER_PASCAL_SECOND, $get, 17),
        ]
    };
}

macro_rules! branch {
    ($output:literal, $what:literal, $number:literal, $field:literal, $unit:expr, $get:expr, $index:literal) => {
        one!(
            $output,
            $what,
            concat!("branch[", $number, "].", $field),
            concat!($field, " of viscous branch ", $number),
            $unit,
            $get,
            $index
        )
    };
}

macro_rules! one {
    ($output:literal, $what:literal, $parameter:expr, $by:expr, $unit:expr, $get:expr, $index:literal) => {
        variable(
            concat!("sensitivity.", $output, ".material.", $parameter),
            concat!("Derivative of ", $what, " by ", $by, "; 0 unless solver.sensitivities is set"),
            Kind::Real { unit: $unit, range: None },
            Binding::Sensitivity($get, $index),
        )
    };
}

/// Of the reaction force.
pub(super) const FORCE: [Variable; SENSITIVITIES] = sensitivities!("force", "the force", |s| s.force);
/// Of its solid part.
pub(super) const FORCE_SOLID: [Variable; SENSITIVITIES] =
    sensitivities!("force_solid", "the solid part of the force", ForceSensitivity::solid);
/// Of its fluid part.
pub(super) const FORCE_FLUID: [Variable; SENSITIVITIES] =
    sensitivities!("force_fluid", "the fluid part of the force", |s| s.fluid);

#[cfg(test)]
mod tests {
    use super::super::{Kind, by_name, table};
    use super::*;
    use crate::interface::variables::BRANCHES;
    use crate::law::MaterialParameter;

    /// The order of the names is that of the indices, which is that of the parameters in the table.
    #[test]
    fn every_parameter_of_the_material_has_its_sensitivities() {
        assert!(by_name(SWITCH).is_some());
        let parameters: Vec<_> = table().iter().filter(|v| v.name.starts_with("material.")).collect();
        assert_eq!(parameters.len(), MaterialParameter::count(BRANCHES));
        for (index, parameter) in parameters.iter().enumerate() {
            for output in ["force", "force_solid", "force_fluid"] {
                let name = name(output, parameter.name);
                let (_, variable) = by_name(&name).unwrap_or_else(|| panic!("{name} is missing"));
                let Binding::Sensitivity(_, at) = variable.binding else { panic!("{name}") };
                assert_eq!(at, index, "{name}");
                let (Kind::Real { unit, .. }, Kind::Real { unit: per, .. }) = (variable.kind, parameter.kind)
                else {
                    panic!("{name}")
                };
                let (n, d, u) = (NEWTON.exponents, per.exponents, unit.exponents);
                assert_eq!(u, (n.0 - d.0, n.1 - d.1, n.2 - d.2), "unit of {name}");
                // Names of units repeat the factors of their display units.
                assert!(
                    (unit.factor / (NEWTON.factor / per.factor) - 1.0).abs() < 1e-12,
                    "display of {name}"
                );
            }
        }
    }
}
