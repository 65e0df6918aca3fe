//! What stands on the terminal before and after any result: geometry that was not given, what was given as it was understood,
//! and what else was assumed.

use crate::assumption::{self, Assumption, assumptions};
use crate::engine::Engine;
use std::collections::BTreeMap;

/// Parameters of a run with the `given` values, the `fitted` ones left out.
pub fn of(engine: &Engine, given: &BTreeMap<String, f64>, fitted: &[&str]) -> Vec<Assumption> {
    // Somebody else's FMU echoes what was given; what its defaults mean is its own matter.
    let all = assumptions(engine.wiring(), given, fitted);
    all.into_iter().filter(|a| engine.is_own() || a.given).collect()
}

/// Says on the terminal what stands before the result; what stands after it is returned.
pub fn say_before(assumptions: &[Assumption]) -> Option<String> {
    assumption::before(assumptions).iter().for_each(|line| say!("{line}"));
    assumption::after(assumptions)
}
