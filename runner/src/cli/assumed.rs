//! What stands on the terminal before any result: geometry that was not given, what was given as it was understood, and
//! what else was assumed.

use crate::assumption::{Assumption, assumptions};
use crate::engine::Engine;
use std::collections::BTreeMap;

/// Width of the terminal's text.
const WIDTH: usize = 80;

/// Parameters of a run with the `given` values, the `fitted` ones left out.
pub fn of(engine: &Engine, given: &BTreeMap<String, f64>, fitted: &[&str]) -> Vec<Assumption> {
    // Somebody else's FMU echoes what was given; what its defaults mean is its own matter.
    let all = assumptions(engine.wiring(), given, fitted);
    all.into_iter().filter(|a| engine.is_own() || a.given).collect()
}

/// The lines that say so.
pub fn lines(engine: &Engine, given: &BTreeMap<String, f64>, fitted: &[&str]) -> Vec<String> {
    crate::assumption::lines(&of(engine, given, fitted), WIDTH)
}

/// A text in lines of the terminal's width, broken between words.
pub fn wrapped_line(head: &str, text: &str) -> String {
    crate::assumption::wrapped(head, &[text.to_owned()], "", WIDTH)
}
