//! What a result rests on: every parameter of the model that was not fitted, with its unit, and whether the user gave it.

use crate::pool::Wiring;
use crate::setting::shown;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A parameter that was not fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Assumption {
    /// Its name.
    pub name: String,
    /// Its value in `unit`; an item's name or true or false where it is no number.
    pub value: String,
    /// Unit, empty where there is none.
    pub unit: String,
    /// Whether the user gave it; otherwise it is the default.
    pub given: bool,
    /// What it is.
    pub meaning: String,
}

/// Parameters that steer the program and say nothing about the test.
const TECHNICAL: [&str; 4] = ["fields.", "protocol.", "solver.", "mesh."];
/// Without these nobody can read a modulus from a force.
const GEOMETRY: [&str; 3] = ["geometry.punch_radius", "geometry.sample_radius", "geometry.sample_height"];

/// All parameters but the `fitted` ones, with the values that were `given` (in the FMU's units).
pub fn assumptions(wiring: &Wiring, given: &BTreeMap<String, f64>, fitted: &[&str]) -> Vec<Assumption> {
    let open = wiring.parameters.values().filter(|v| !fitted.contains(&v.name.as_str()));
    let one = |v: &crate::fmi::ScalarVariable| {
        let (value, unit) = shown(v, given.get(&v.name).copied().or_else(|| v.start_number())?);
        let (name, meaning) = (v.name.clone(), v.description.clone());
        Some(Assumption { given: given.contains_key(&name), name, value, unit, meaning })
    };
    open.filter_map(one).collect()
}

impl Assumption {
    /// `geometry.punch_radius = 2 mm`.
    fn assignment(&self) -> String {
        format!("{} = {}", self.name, self.quantity())
    }

    fn quantity(&self) -> String {
        format!("{} {}", self.value, self.unit).trim_end().to_owned()
    }
}

/// `punch radius 2 mm, ...: the default`, where geometry was not given: the first line of every output.
pub fn geometry_warning(assumptions: &[Assumption]) -> Option<String> {
    let open: Vec<&Assumption> =
        assumptions.iter().filter(|a| GEOMETRY.contains(&a.name.as_str()) && !a.given).collect();
    let words = |a: &&Assumption| {
        let leaf = a.name.rsplit('.').next().unwrap_or(&a.name).replace('_', " ");
        format!("{leaf} {}", a.quantity())
    };
    let first = open.first()?;
    let all = open.iter().map(words).collect::<Vec<_>>().join(", ");
    let defaults = if open.len() == 1 { "the default" } else { "the defaults" };
    Some(format!(
        "warning: {all}: {defaults}; give yours with --set {}={}{}",
        first.name, first.value, first.unit
    ))
}

/// What stands before any result: the warning, and what was given as it was understood.
pub fn before(assumptions: &[Assumption]) -> Vec<String> {
    let given = assumptions.iter().filter(|a| a.given && acts(a, assumptions)).map(Assumption::assignment);
    let given = given.collect::<Vec<_>>().join(", ");
    let echo = (!given.is_empty()).then(|| format!("given: {given}"));
    geometry_warning(assumptions).into_iter().chain(echo).collect()
}

/// What stands after it: everything that was assumed, by the last part of its name.
pub fn after(assumptions: &[Assumption]) -> Option<String> {
    let is_technical = |a: &&Assumption| TECHNICAL.iter().any(|t| a.name.starts_with(t));
    // An effect at its default is switched off, whatever its other parameters say.
    let is_assumed = |a: &&Assumption| {
        !a.given && !is_technical(a) && !a.name.starts_with("effect.") && acts(a, assumptions)
    };
    let words = |a: &Assumption| {
        let leaf = a.name.split_once('.').map_or(a.name.as_str(), |(_, leaf)| leaf).replace('_', " ");
        match a.value.as_str() {
            "true" => leaf,
            "false" => format!("not {leaf}"),
            _ => format!("{leaf} {}", a.quantity()),
        }
    };
    let assumed: Vec<String> = assumptions.iter().filter(is_assumed).map(words).collect();
    (!assumed.is_empty()).then(|| format!("assumed: {}", assumed.join(", ")))
}

/// Whether a parameter belongs to the shape, or to a branch, that is there.
fn acts(a: &Assumption, all: &[Assumption]) -> bool {
    let branch = a.name.strip_prefix("material.branch[").and_then(|rest| rest.split_once(']'));
    if let Some((branch, _)) = branch {
        let mu = format!("material.branch[{branch}].mu");
        return !all.iter().any(|m| m.name == mu && m.value.parse() == Ok(0.0));
    }
    let profile = all.iter().find(|p| p.name == "indenter.profile").map_or("flat", |p| p.value.as_str());
    match a.name.as_str() {
        // The same as the profile, as a number.
        "indenter.profile_number" => false,
        "indenter.edge_radius" => profile == "flat",
        "indenter.sphere_radius" => profile == "sphere",
        "indenter.cone_half_angle" => profile == "cone",
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assumption(name: &str, value: &str, unit: &str, given: bool) -> Assumption {
        let text = str::to_owned;
        Assumption { name: text(name), value: text(value), unit: text(unit), given, meaning: String::new() }
    }

    #[test]
    fn geometry_that_was_not_given_is_the_first_line() {
        let mut all = vec![
            assumption("geometry.punch_radius", "2", "mm", false),
            assumption("geometry.sample_radius", "10", "mm", true),
            assumption("indenter.cone_half_angle", "60", "deg", false),
            assumption("material.n0s", "0.032", "", false),
            assumption("solver.tolerance", "0.0003", "", false),
            assumption("boundary.drained_punch", "false", "", false),
            assumption("material.branch[3].mu", "0", "Pa", true),
            assumption("material.branch[3].eta", "1000", "Pa s", false),
        ];
        let found = before(&all);
        assert!(found[0].starts_with("warning: punch radius 2 mm: the default; give"), "{found:?}");
        assert_eq!(found[1..], ["given: geometry.sample_radius = 10 mm".to_owned()]);
        assert_eq!(after(&all).unwrap(), "assumed: punch radius 2 mm, n0s 0.032, not drained punch");
        all[0].given = true;
        assert!(geometry_warning(&all).is_none());
    }
}
