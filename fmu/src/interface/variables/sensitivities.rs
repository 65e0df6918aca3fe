//! Entries of the sensitivities: three outputs for every parameter of the material and every magnitude of an effect.

use super::row::variable;
use super::settings::SENSITIVITIES;
use super::{Binding, Kind, Variable};
use crate::ForceSensitivity;
use crate::law::Magnitude;
use crate::unit::{
    NEWTON, NEWTON_PASCAL, NEWTON_PASCAL_PER_METRE, NEWTON_PER_METRE, NEWTON_PER_PASCAL,
    NEWTON_PER_PASCAL_SECOND, NEWTON_PER_SECOND, NEWTON_PER_SQUARE_METRE, NEWTON_SECOND, SECOND,
    SQUARE_NEWTON_PER_METRE,
};

/// Boolean parameter that switches the sensitivities on.
pub const SWITCH: &str = "solver.sensitivities";
/// Boolean parameter that switches on those by the magnitudes of effects, beside the others.
pub const EFFECT_SWITCH: &str = "solver.effect_sensitivities";

/// What the names of all derivatives begin with.
pub const PREFIX: &str = "sensitivity.";

/// Name of the derivative of an output by a parameter.
pub fn name(output: &str, parameter: &str) -> String {
    format!("{PREFIX}{output}.{parameter}")
}

/// The parameter by which the derivative called `name` is one.
pub fn parameter_of(name: &str) -> Option<&str> {
    name.strip_prefix(PREFIX)?.split_once('.').map(|(_, parameter)| parameter)
}

/// Whether it is a parameter of an effect, whose derivatives [`EFFECT_SWITCH`] switches on.
pub fn is_of_effect(parameter: &str) -> bool {
    parameter.starts_with("effect.")
}

/// The switches that the derivatives among these outputs need.
pub fn switches<'a>(outputs: impl IntoIterator<Item = &'a str>) -> Vec<&'static str> {
    let mut switches = Vec::new();
    for output in outputs.into_iter().filter(|output| output.starts_with(PREFIX)) {
        let of_effect = parameter_of(output).is_some_and(is_of_effect);
        let needed = [Some(SWITCH), of_effect.then_some(EFFECT_SWITCH)];
        switches.extend(needed.into_iter().flatten());
    }
    switches.sort_unstable();
    switches.dedup();
    switches
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

/// `sensitivity.<output>.effect.<effect>.<parameter>` for all magnitudes, in the order of their indices.
macro_rules! by_effect {
    ($output:literal, $what:literal, $get:expr) => {
        [
            magnitude!($output, $what, "eyring.inverse_stress", &NEWTON_PASCAL, $get, InverseStress),
            magnitude!($output, $what, "permeability.exponent", &NEWTON, $get, PermeabilityExponent),
            magnitude!($output, $what, "softening.loss", &NEWTON, $get, Loss),
            magnitude!($output, $what, "softening.strain", &NEWTON, $get, LossStrain),
            magnitude!($output, $what, "modulus_drift.rate", &NEWTON_SECOND, $get, GrowthRate),
            magnitude!($output, $what, "amplitude.log_factor", &NEWTON, $get, Amplitude),
            magnitude!(
                $output,
                $what,
                "slip.compliance",
                &NEWTON_PASCAL_PER_METRE,
                $get,
                ShearCompliance,
                ", and at 0, where the bonded edge has no finite one"
            ),
            magnitude!($output, $what, "adhesion.strength", &NEWTON_PER_PASCAL, $get, AdhesiveStrength),
            magnitude!($output, $what, "offset.height", &NEWTON_PER_METRE, $get, SurfaceHeight),
            magnitude!(
                $output,
                $what,
                "compliance.per_newton",
                &SQUARE_NEWTON_PER_METRE,
                $get,
                MachineCompliance
            ),
            magnitude!($output, $what, "load_cell_drift.rate", &SECOND, $get, DriftRate),
            magnitude!($output, $what, "load_cell_lag.time", &NEWTON_PER_SECOND, $get, Lag),
        ]
    };
}

macro_rules! magnitude {
    ($output:literal, $what:literal, $name:literal, $unit:expr, $get:expr, $magnitude:ident $(, $but:literal)?) => {
        variable(
            concat!("sensitivity.", $output, ".effect.", $name),
            concat!(
                "Derivative of ",
                $what,
                " by effect.",
                $name,
                "; 0 unless solver.effect_sensitivities is set",
                $($but)?
            ),
            Kind::Real { unit: $unit, range: None },
            Binding::Sensitivity($get, SENSITIVITIES + Magnitude::$magnitude.index()),
        )
    };
}

/// Number of the magnitudes.
const MAGNITUDES: usize = Magnitude::ALL.len();
/// Of what is read, by the magnitudes of effects.
pub(super) const FORCE_BY_EFFECT: [Variable; MAGNITUDES] = by_effect!("force", "the force", |s| s.force);
/// Of the reaction force's solid part.
pub(super) const FORCE_SOLID_BY_EFFECT: [Variable; MAGNITUDES] =
    by_effect!("force_solid", "the solid part of the force", ForceSensitivity::solid);
/// Of its fluid part.
pub(super) const FORCE_FLUID_BY_EFFECT: [Variable; MAGNITUDES] =
    by_effect!("force_fluid", "the fluid part of the force", |s| s.fluid);

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
            has_its_sensitivities(parameter, index);
        }
    }

    /// Rows in the order of the magnitudes, each the derivative by a parameter of an effect.
    #[test]
    fn every_magnitude_has_its_sensitivities() {
        assert!(by_name(EFFECT_SWITCH).is_some());
        let rows = table().iter().filter(|v| v.name.starts_with("sensitivity.force.effect."));
        let parameters: Vec<_> = rows.filter_map(|v| by_name(parameter_of(v.name)?)).collect();
        assert_eq!(parameters.len(), Magnitude::ALL.len());
        for (index, (_, parameter)) in parameters.iter().enumerate() {
            has_its_sensitivities(parameter, SENSITIVITIES + index);
        }
    }

    #[test]
    fn derivatives_by_effects_need_both_switches() {
        assert!(switches(["force", "stored_energy"]).is_empty());
        assert_eq!(switches(["force", "sensitivity.force.material.n0s"]), [SWITCH]);
        let both = ["sensitivity.force.effect.offset.height", "sensitivity.force.material.n0s"];
        assert_eq!(switches(both), [EFFECT_SWITCH, SWITCH]);
    }

    fn has_its_sensitivities(parameter: &Variable, index: usize) {
        for output in ["force", "force_solid", "force_fluid"] {
            let name = name(output, parameter.name);
            assert_eq!(parameter_of(&name), Some(parameter.name));
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
            assert!((unit.factor / (NEWTON.factor / per.factor) - 1.0).abs() < 1e-12, "display of {name}");
        }
    }
}
