//! The catalogue of the model's library in the form that screening uses.
//!
//! A magnitude moves each parameter from the value that it has, so that a `--set` of the user stays what effects
//! start from. Plausible scales are those of the paper's tests, made larger or smaller as the data's forces and lengths are.

use super::size::Size;
use crate::fmi::VariableKind;
use crate::inference::effect::{Effect, Place, Scope, Sign};
use crate::pool::Wiring;
use poropunch::effect::{self, CATALOGUE, Course, Setting, Variant};
use poropunch::variables;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Effects whose magnitude differs from test to test: all tests together, the parameters would absorb them.
const BETWEEN_TESTS: [&str; 1] = ["amplitude"];
/// Variants whose change of the force [`crate::inference::refinement`] counts as error of the simulation.
const REFINEMENTS: [&str; 2] = ["discretisation.mesh", "discretisation.time"];
/// Effects that are a position or a factor: nature has no other form of them.
const NUMBERS: [&str; 2] = ["offset", "amplitude"];
/// Largest magnitude that is tried, in plausible scales, where the parameter's range allows it: two decades.
const LARGEST: f64 = 100.0;

/// An effect that is not screened, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: &'static str,
}

/// Why an effect cannot be screened.
fn obstacle(name: &str, variant: &Variant, wiring: &Wiring) -> Option<&'static str> {
    if !variant.settings.iter().all(|s| wiring.parameters.contains_key(s.parameter)) {
        Some("the FMU does not have it")
    } else if REFINEMENTS.contains(&name) {
        Some("what a refinement changes is part of the noise, so it cannot be a gap too")
    } else {
        None
    }
}

/// All variants of all effects that can be screened with an FMU, for tests of a size, and those that cannot.
pub fn effects(wiring: &Wiring, size: Size) -> (Vec<Effect>, Vec<LeftOut>) {
    let (mut known, mut left_out) = (Vec::new(), Vec::new());
    for effect in CATALOGUE {
        for variant in effect.variants {
            let name = variant_name(effect, variant);
            match obstacle(&name, variant, wiring) {
                None => known.push(of_variant(effect, variant, wiring, size)),
                Some(reason) => left_out.push(LeftOut { name, reason }),
            }
        }
    }
    (known, left_out)
}

fn variant_name(effect: &effect::Effect, variant: &Variant) -> String {
    let several = effect.variants.len() > 1;
    if several { format!("{}.{}", effect.name, variant.name) } else { effect.name.to_owned() }
}

fn of_variant(effect: &effect::Effect, variant: &'static Variant, wiring: &Wiring, size: Size) -> Effect {
    let several = effect.variants.len() > 1;
    let (scale, unit) = variant.settings.iter().find_map(|s| scale(s, size)).unwrap_or((1.0, String::new()));
    Effect {
        name: variant_name(effect, variant),
        family: effect.name.to_owned(),
        title: if several { format!("{}: {}", effect.title, variant.name) } else { effect.title.to_owned() },
        place: match effect.place {
            effect::Place::Specimen => Place::Specimen,
            effect::Place::Contact => Place::Contact,
            effect::Place::Machine => Place::Machine,
            effect::Place::Sensor => Place::Sensor,
            effect::Place::Numerics => Place::Numerics,
        },
        sign: sign(variant),
        scope: if BETWEEN_TESTS.contains(&effect.name) { Scope::BetweenTests } else { Scope::Shared },
        scale,
        unit,
        largest: largest(variant, wiring, size),
        reveals: effect.revealed_by.to_owned(),
        differentiable: variant.differentiable,
        is_a_number: NUMBERS.contains(&effect.name),
        parameters: variant.settings.iter().map(|s| s.parameter.to_owned()).collect(),
        action: Arc::new(move |values: &mut BTreeMap<String, f64>, magnitude| {
            for setting in variant.settings {
                let before = values.get(setting.parameter).copied().unwrap_or(setting.null);
                values.insert(setting.parameter.to_owned(), moved(setting, before, magnitude, size));
            }
        }),
    }
}

/// How many times the catalogue's plausible scale of a parameter is that of the data.
fn enlarged(setting: &Setting, size: Size) -> f64 {
    variables::by_name(setting.parameter).and_then(|(_, v)| v.unit()).map_or(1.0, |unit| size.factor(unit))
}

/// Where a parameter goes from `before`.
fn moved(setting: &Setting, before: f64, magnitude: f64, size: Size) -> f64 {
    match setting.course {
        Course::Linear => before + magnitude * enlarged(setting, size) * (setting.probe - setting.null),
        Course::Geometric => before * (setting.probe / setting.null).powf(magnitude),
        Course::Proportional => magnitude * enlarged(setting, size) * setting.probe,
        Course::Switch => enlarged(setting, size) * setting.probe,
    }
}

/// Size of magnitude 1 as people read it.
fn scale(setting: &Setting, size: Size) -> Option<(f64, String)> {
    let unit =
        || variables::by_name(setting.parameter).and_then(|(_, v)| v.unit()).filter(|u| u.symbol != "1");
    match setting.course {
        Course::Linear => {
            let change = enlarged(setting, size) * (setting.probe - setting.null);
            let shown = unit().map(|u| (change * u.factor, u.display.to_owned()));
            Some(shown.unwrap_or((change, String::new())))
        }
        // Powers of the ratio: told as magnitudes.
        Course::Geometric | Course::Proportional | Course::Switch => None,
    }
}

fn sign(variant: &Variant) -> Sign {
    match variant.sign {
        _ if variant.is_switch() => Sign::Switch,
        effect::Sign::OneSided => Sign::Positive,
        effect::Sign::TwoSided => Sign::Either,
    }
}

/// The largest magnitude that keeps all parameters within the FMU's ranges, in both directions where both mean something.
fn largest(variant: &Variant, wiring: &Wiring, size: Size) -> f64 {
    let inside = |m: f64| {
        variant.settings.iter().all(|setting| {
            let Some(v) = wiring.parameters.get(setting.parameter) else { return false };
            let value = moved(setting, setting.null, m, size);
            v.kind != VariableKind::Real || v.range.contains(value)
        })
    };
    largest_within(|m| inside(m) && (sign(variant) != Sign::Either || inside(-m)))
}

/// The largest admissible magnitude of [`LARGEST`] and its halves.
pub(super) fn largest_within(admissible: impl Fn(f64) -> bool) -> f64 {
    const HALVINGS: i32 = 12;
    (0..HALVINGS).map(|k| LARGEST * 0.5f64.powi(k)).find(|m| admissible(*m)).unwrap_or(1.0)
}
