//! How far a study is.

use super::results::Kind;
use super::{Failure, Plan, Results, StudyError, Unit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::time::SystemTime;

/// Version of the layout.
pub const SCHEMA: &str = "poropunch.study-status/1";
/// Results whose times tell the pace.
const RECENT: usize = 50;

/// State of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// It has its result.
    Done,
    /// It failed; the reason is kept.
    Failed,
    /// A process works on it, as far as is known.
    Running,
    /// Nobody has it.
    Waiting,
}

/// Number of units in each state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Status {
    /// [`SCHEMA`].
    pub schema: String,
    /// All units.
    pub units: usize,
    /// How many of them are in each state.
    #[serde(flatten)]
    pub counts: Counts,
    /// Time until the last one at the present pace (s); none where nothing runs or the pace is not known.
    pub seconds_left: Option<f64>,
    /// Reasons of failures, each with the numbers of its units.
    pub reasons: Vec<Reason>,
}

/// Numbers of units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Counts {
    /// With a result.
    pub done: usize,
    /// Failed.
    pub failed: usize,
    /// Under way.
    pub running: usize,
    /// Not begun.
    pub waiting: usize,
}

impl Counts {
    fn count(&mut self, state: State) {
        *match state {
            State::Done => &mut self.done,
            State::Failed => &mut self.failed,
            State::Running => &mut self.running,
            State::Waiting => &mut self.waiting,
        } += 1;
    }
}

/// Why units failed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reason {
    /// What the command said.
    pub reason: String,
    /// Numbers of the units, as `1-3,7`.
    pub units: String,
}

/// One unit's line of `status --lines`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UnitStatus {
    /// Its number.
    pub unit: usize,
    /// Specimen.
    pub specimen: String,
    /// State.
    pub state: State,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// What the store knows, read once.
#[derive(Debug)]
pub struct States {
    done: HashSet<String>,
    failed: HashSet<String>,
    running: HashSet<String>,
}

impl States {
    /// Reads the names in the store: no more operations with many units than with few.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub fn read(results: &Results) -> Result<Self, StudyError> {
        Ok(Self {
            // Last what a unit becomes last: one that ends meanwhile is not lost between two.
            running: results.running()?,
            failed: results.keys(Kind::Failure)?,
            done: results.keys(Kind::Result)?,
        })
    }

    /// State of a unit.
    pub fn of(&self, unit: &Unit) -> State {
        match &unit.key {
            key if self.done.contains(key) => State::Done,
            key if self.running.contains(key) => State::Running,
            key if self.failed.contains(key) => State::Failed,
            _ => State::Waiting,
        }
    }
}

/// Numbers of the units that have no result; those that failed only if they are to be tried again.
///
/// # Errors
/// When plan or store cannot be read.
pub fn missing(plan: &Plan, again: bool) -> Result<Vec<usize>, StudyError> {
    let states = States::read(&Results::new(&plan.results()))?;
    let mut numbers = Vec::new();
    for unit in plan.units()? {
        let unit = unit?;
        let is_wanted = match states.of(&unit) {
            State::Done => false,
            State::Failed => again,
            State::Running | State::Waiting => true,
        };
        numbers.extend(is_wanted.then_some(unit.unit));
    }
    Ok(numbers)
}

/// How far the study is; each unit's state is told, too.
///
/// # Errors
/// When plan or store cannot be read.
pub fn status(plan: &Plan, told: &mut dyn FnMut(&UnitStatus)) -> Result<Status, StudyError> {
    let results = Results::new(&plan.results());
    let states = States::read(&results)?;
    let mut counts = Counts::default();
    let mut reasons: Vec<(String, Vec<usize>)> = Vec::new();
    let mut done = Vec::new();
    for unit in plan.units()? {
        let unit = unit?;
        let state = states.of(&unit);
        counts.count(state);
        let mut reason = None;
        if state == State::Failed {
            let failure: Option<Failure> = results.get(Kind::Failure, &unit.key)?;
            let why = failure.map_or_else(|| "its reason is gone".to_owned(), |f| f.reason);
            match reasons.iter_mut().find(|(r, _)| *r == why) {
                Some((_, units)) => units.push(unit.unit),
                None => reasons.push((why.clone(), vec![unit.unit])),
            }
            reason = Some(why);
        }
        if state == State::Done {
            done.push(unit.key.clone());
        }
        told(&UnitStatus { unit: unit.unit, specimen: unit.specimen, state, reason });
    }
    let seconds_left = if counts.running > 0 { pace(&results.times(done.iter())) } else { None };
    let written =
        |(reason, units): (String, Vec<usize>)| Reason { reason, units: super::ranges::written(&units) };
    Ok(Status {
        schema: SCHEMA.to_owned(),
        units: plan.header.units,
        counts,
        seconds_left: seconds_left.map(|s| s * (counts.running + counts.waiting) as f64),
        reasons: reasons.into_iter().map(written).collect(),
    })
}

/// Time from one result to the next (s), from the last ones.
fn pace(times: &[SystemTime]) -> Option<f64> {
    let recent = &times[times.len().saturating_sub(RECENT)..];
    let (first, last) = (recent.first()?, recent.last()?);
    let span = last.duration_since(*first).ok()?.as_secs_f64();
    (recent.len() > 1).then(|| span / (recent.len() - 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_pace_is_that_of_the_last_results() {
        let at = |s: u64| SystemTime::UNIX_EPOCH + Duration::from_secs(s);
        assert_eq!(pace(&[at(0)]), None);
        assert_eq!(pace(&[at(0), at(10), at(20)]), Some(10.0));
        // A break long ago does not count.
        let times: Vec<_> = [0].into_iter().chain((0..60).map(|k| 100_000 + 2 * k)).map(at).collect();
        assert_eq!(pace(&times), Some(2.0));
    }
}
