//! Entries of the sensitivities: three outputs for every parameter of the material.

use super::settings::SENSITIVITIES;
use super::table::variable;
use super::units::{NEWTON, NEWTON_PER_PASCAL, NEWTON_PER_PASCAL_SECOND, NEWTON_PER_SQUARE_METRE, Unit};
use super::{Binding, Kind, Variable};
use crate::ForceSensitivity;

/// Boolean parameter that switches the sensitivities on.
pub const SWITCH: &str = "solver.sensitivities";

/// What the names of all derivatives begin with.
pub const PREFIX: &str = "sensitivity.";

/// Name of the derivative of an output by a parameter.
pub fn name(output: &str, parameter: &str) -> String {
    format!("{PREFIX}{output}.{parameter}")
}

/// `sensitivity.<output>.<parameter>` for all parameters, in the order of their indices.
macro_rules! sensitivities {
    ($output:literal, $get:expr) => {
        [
            sensitivity(concat!("sensitivity.", $output, ".material.n0s"), &NEWTON, $get, 0),
            sensitivity(
                concat!("sensitivity.", $output, ".material.lambda_star"),
                &NEWTON_PER_PASCAL,
                $get,
                1,
            ),
            sensitivity(
                concat!("sensitivity.", $output, ".material.fluid_viscosity"),
                &NEWTON_PER_PASCAL_SECOND,
                $get,
                2,
            ),
            sensitivity(
                concat!("sensitivity.", $output, ".material.permeability"),
                &NEWTON_PER_SQUARE_METRE,
                $get,
                3,
            ),
            sensitivity(
                concat!("sensitivity.", $output, ".material.equilibrium.mu"),
                &NEWTON_PER_PASCAL,
                $get,
                4,
            ),
            sensitivity(concat!("sensitivity.", $output, ".material.equilibrium.alpha"), &NEWTON, $get, 5),
            branch!($output, "1", mu, &NEWTON_PER_PASCAL, $get, 6),
            branch!($output, "1", alpha, &NEWTON, $get, 7),
            branch!($output, "1", eta, &NEWTON_PER_PASCAL_SECOND, $get, 8),
            branch!($output, "2", mu, &NEWTON_PER_PASCAL, $get, 9),
            branch!($output, "2", alpha, &NEWTON, $get, 10),
            branch!($output, "2", eta, &NEWTON_PER_PASCAL_SECOND, $get, 11),
            branch!($output, "3", mu, &NEWTON_PER_PASCAL, $get, 12),
            branch!($output, "3", alpha, &NEWTON, $get, 13),
            branch!($output, "3", eta, &NEWTON_PER_PASCAL_SECOND, $get, 14),
            branch!($output, "4", mu, &NEWTON_PER_PASCAL, $get, 15),
            branch!($output, "4", alpha, &NEWTON, $get, 16),
            branch!($output, "4", eta, &NEWTON_PER_PASCAL_SECOND, $get, 17),
        ]
    };
}

macro_rules! branch {
    ($output:literal, $number:literal, $field:ident, $unit:expr, $get:expr, $index:literal) => {
        sensitivity(
            concat!("sensitivity.", $output, ".material.branch[", $number, "].", stringify!($field)),
            $unit,
            $get,
            $index,
        )
    };
}

const fn sensitivity(
    name: &'static str,
    unit: &'static Unit,
    get: fn(&ForceSensitivity) -> f64,
    index: usize,
) -> Variable {
    let description =
        "Derivative of the output by the parameter in the name; 0 unless solver.sensitivities is set";
    variable(name, description, Kind::Real { unit, range: None }, Binding::Sensitivity(get, index))
}

/// Of the reaction force.
pub(super) const FORCE: [Variable; SENSITIVITIES] = sensitivities!("force", |s| s.force);
/// Of its solid part.
pub(super) const FORCE_SOLID: [Variable; SENSITIVITIES] =
    sensitivities!("force_solid", ForceSensitivity::solid);
/// Of its fluid part.
pub(super) const FORCE_FLUID: [Variable; SENSITIVITIES] = sensitivities!("force_fluid", |s| s.fluid);

#[cfg(test)]
mod tests {
    use super::super::{Kind, by_name, table};
    use super::*;
    use crate::law::MaterialParameter;
    use crate::variables::BRANCHES;

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
