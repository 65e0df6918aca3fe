//! `runner batch`: many parameter sets, one protocol, all cores.

use super::assumed;
use super::engine_args::{EngineArguments, cache_directory};
use super::job::{Invocation, JobArguments};
use super::parameter_sets::{ParameterSets, Set};
use super::progress::Progress;
use super::protocols::motion;
use super::terminal;
use super::{CliResult, Ending};
use crate::data::Reading;
use crate::engine::Engine;
use crate::output::{Folder, curve_csv};
use crate::pool::{Job, Outcome, Priority, RunFailure};
use crate::score::Shape;
use crate::setting::{settings_from, shown, variable_named};
use clap::{Args, ValueHint};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

/// Run many parameter sets in parallel.
#[derive(Debug, Args)]
pub struct Arguments {
    /// CSV file: one column per parameter (`NAME` or `NAME [unit]`), one row per run, optional column `name`
    #[arg(value_name = "SETS", value_hint = ValueHint::FilePath)]
    sets: PathBuf,
    /// P1 or P2, or a CSV file with time_s,displacement_mm
    #[arg(long, short, value_name = "PROTOCOL|FILE", default_value = "P2", value_hint = ValueHint::FilePath)]
    protocol: String,
    /// Directory for summary.csv and one curve per run
    #[arg(long, short, value_name = "DIR", default_value = "batch")]
    out: PathBuf,
    /// Outputs to record beside the force
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "force_solid,force_fluid")]
    record: Vec<String>,
    /// Number of output times for P1 and P2, a file has its own [default: 300]
    #[arg(long, value_name = "N", value_parser = super::count::points)]
    points: Option<usize>,
    #[command(flatten)]
    engine: EngineArguments,
    #[command(flatten)]
    job: JobArguments,
}

/// What `--json` prints: the runs themselves are files, as there may be any number of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Batch {
    /// `poropunch.batch/1`.
    pub schema: String,
    /// Command that was given.
    pub command: String,
    /// Number of runs.
    pub runs: usize,
    /// Number of those that failed.
    pub failed: usize,
    /// Table of all runs, with the names of their curves' files.
    pub summary: String,
}

/// Runs that wait or are under way for each instance: enough that none is idle, few enough for any length of table.
const AHEAD: usize = 4;

/// Runs the command.
pub fn run(arguments: &Arguments, call: &Invocation) -> CliResult {
    let motion = motion(&arguments.protocol, None, arguments.points, &Reading::default())?;
    let cache = cache_directory(None, &arguments.out);
    let engine = arguments.engine.engine(&arguments.record, false, Some(&cache), &call.stop)?;
    let common = settings_from(engine.wiring(), &arguments.engine.settings(engine.wiring())?)?;
    let sets = ParameterSets::open(&arguments.sets, &engine)?;
    let assumed = assumed::say_before(&assumed::of(&engine, &common, &sets.parameters()));
    let folder = Folder::begin(&arguments.out, "batch")?;
    call.keep(&folder)?;
    let mut summary = Summary::begin(&folder, &engine, &sets)?;
    let submit = |set: &Set| {
        let (protocol, time_s) = (Arc::clone(&motion.protocol), Arc::clone(&motion.time_s));
        engine.submit(&Job { parameters: set.over(&common), protocol, time_s }, Priority::Urgent)
    };

    let progress = Progress::of_runs(sets.count as u64);
    let (mut failed, mut under_way) = (0, VecDeque::new());
    let mut rows = sets.rows()?;
    loop {
        while under_way.len() < AHEAD * engine.pool().size()
            && let Some(set) = rows.next().transpose()?
        {
            under_way.push_back((submit(&set), set));
        }
        let Some((run, set)) = under_way.pop_front() else { break };
        let outcome = run.wait();
        if let Ok(curve) = &outcome {
            let values = summary.values(&set);
            let assignments =
                summary.columns.iter().zip(&values).map(|(name, value)| format!("{name} = {value}"));
            let comments = [
                format!("run {} of {}", set.name, arguments.sets.display()),
                assignments.collect::<Vec<_>>().join(", "),
            ];
            folder.write(&format!("{}.csv", set.name), curve_csv(curve, &comments).as_bytes())?;
        }
        failed += usize::from(matches!(&outcome, Err(f) if *f != RunFailure::Cancelled));
        summary.add(&set, &outcome)?;
        progress.advance();
    }
    progress.finish();
    say!("{} runs, {failed} failed; wrote {}", sets.count, arguments.out.join(SUMMARY).display());
    if let Some(assumed) = assumed {
        say!("{assumed}");
    }
    if let Some(trouble) = engine.cache().trouble() {
        terminal::warning(&format!("runs could not be kept in the cache: {trouble}"));
    }
    terminal::result(&Batch {
        schema: "poropunch.batch/1".to_owned(),
        command: call.command(),
        runs: sets.count,
        failed,
        summary: folder.path().join(SUMMARY).display().to_string(),
    })?;
    Ok(if engine.is_stopped() { Ending::Interrupted } else { Ending::Complete })
}

const SUMMARY: &str = "summary.csv";

/// One line per run, written as soon as the run and those before it have ended.
struct Summary<'a> {
    engine: &'a Engine,
    /// Parameters with their units.
    columns: Vec<String>,
    out: csv::Writer<File>,
}

impl<'a> Summary<'a> {
    fn begin(
        folder: &Folder,
        engine: &'a Engine,
        sets: &ParameterSets,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let column = |name: &&str| {
            let unit = variable_named(engine.wiring(), name).map(|v| shown(v, 0.0).1).unwrap_or_default();
            if unit.is_empty() { (*name).to_owned() } else { format!("{name} [{unit}]") }
        };
        let columns: Vec<String> = sets.parameters().iter().map(column).collect();
        let mut out = csv::Writer::from_writer(folder.stream(SUMMARY)?);
        let shape = ["peak_force_mN", "peak_time_s", "last_force_mN", "relaxation_percent", "reason"];
        out.write_record(
            ["name", "status"].into_iter().chain(columns.iter().map(String::as_str)).chain(shape),
        )?;
        out.flush()?;
        Ok(Self { engine, columns, out })
    }

    /// Values of a row in the units of the columns.
    fn values(&self, set: &Set) -> Vec<String> {
        let value = |(name, value): &(String, f64)| {
            variable_named(self.engine.wiring(), name).map(|v| shown(v, *value).0).unwrap_or_default()
        };
        set.values.iter().map(value).collect()
    }

    fn add(&mut self, set: &Set, outcome: &Outcome) -> Result<(), Box<dyn std::error::Error>> {
        let mut fields = vec![set.name.clone()];
        fields.push(match outcome {
            Ok(_) => "ok".to_owned(),
            Err(RunFailure::Cancelled) => "cancelled".to_owned(),
            Err(_) => "failed".to_owned(),
        });
        fields.extend(self.values(set));
        match outcome {
            Ok(curve) => {
                let shape = Shape::of(&curve.time_s, curve.force_n());
                let last = curve.force_n().last().copied().unwrap_or_default();
                let numbers = [shape.peak_n * 1e3, shape.peak_time_s, last * 1e3, shape.relaxation * 100.0];
                // A relaxation without a peak is no number, and a table has no word for it.
                fields.extend(numbers.map(|v| if v.is_finite() { v.to_string() } else { String::new() }));
                fields.push(String::new());
            }
            Err(failure) => {
                fields.extend(std::iter::repeat_n(String::new(), 4));
                let stopped = *failure == RunFailure::Cancelled;
                fields.push(if stopped { String::new() } else { failure.to_string() });
            }
        }
        self.out.write_record(&fields)?;
        Ok(self.out.flush()?)
    }
}
