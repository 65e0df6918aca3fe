//! `runner batch`: many parameter sets, one protocol, all cores.

use super::engine_args::EngineArguments;
use super::progress::Progress;
use super::protocols::motion;
use super::{CliResult, Ending};
use crate::engine::Engine;
use crate::output::{curve_csv, write_file};
use crate::pool::{Job, Priority, Run, RunFailure};
use crate::score::Shape;
use crate::setting::{number_in, settings_from, variable_named};
use clap::Args;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Run many parameter sets in parallel.
#[derive(Debug, Args)]
pub struct Arguments {
    /// CSV file: one column per parameter (`NAME` or `NAME [unit]`), one row per run, optional column `name`
    #[arg(value_name = "SETS")]
    sets: PathBuf,
    /// P1 or P2, or a CSV file with time_s,displacement_mm
    #[arg(long, short, value_name = "PROTOCOL|FILE", default_value = "P2")]
    protocol: String,
    /// Directory for summary.csv and one curve per run
    #[arg(long, short, value_name = "DIR", default_value = "batch")]
    out: PathBuf,
    /// Outputs to record beside the force
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "force_solid,force_fluid")]
    record: Vec<String>,
    /// Number of output times for P1 and P2
    #[arg(long, value_name = "N", default_value_t = 300)]
    points: usize,
    #[command(flatten)]
    engine: EngineArguments,
}

/// One row of the file.
struct Set {
    name: String,
    parameters: BTreeMap<String, f64>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, stop: &Arc<AtomicBool>) -> CliResult {
    let motion = motion(&arguments.protocol, None, arguments.points)?;
    let cache = arguments.out.join("cache");
    let engine = arguments.engine.engine(&arguments.record, false, Some(cache), stop)?;
    let common = settings_from(engine.wiring(), &arguments.engine.settings())?;
    let sets = read_sets(&arguments.sets, &engine, &common)?;
    let submit = |set: &Set| {
        let (protocol, time_s) = (Arc::clone(&motion.protocol), Arc::clone(&motion.time_s));
        engine.submit(&Job { parameters: set.parameters.clone(), protocol, time_s }, Priority::Urgent)
    };
    let runs: Vec<Run> = sets.iter().map(submit).collect();

    let progress = Progress::of_runs(sets.len() as u64);
    let mut summary =
        "name,status,peak_force_mN,peak_time_s,last_force_mN,relaxation_percent,reason\n".to_owned();
    let mut failed = 0;
    for (set, run) in sets.iter().zip(&runs) {
        match run.wait() {
            Ok(curve) => {
                let comment = format!("run {} of {}", set.name, arguments.sets.display());
                let file = arguments.out.join(format!("{}.csv", set.name));
                write_file(&file, curve_csv(&curve, &[comment]).as_bytes())?;
                let shape = Shape::of(&curve.time_s, curve.force_n());
                let (peak, last) =
                    (shape.peak_n * 1e3, curve.force_n().last().copied().unwrap_or_default() * 1e3);
                let relaxation = shape.relaxation * 100.0;
                let _ =
                    writeln!(summary, "{},ok,{peak},{},{last},{relaxation},", set.name, shape.peak_time_s);
            }
            Err(RunFailure::Cancelled) => {
                let _ = writeln!(summary, "{},cancelled,,,,,", set.name);
            }
            Err(failure) => {
                failed += 1;
                let reason = failure.to_string().replace('"', "'");
                let _ = writeln!(summary, "{},failed,,,,,\"{reason}\"", set.name);
            }
        }
        progress.advance();
    }
    progress.finish();
    let file = arguments.out.join("summary.csv");
    write_file(&file, summary.as_bytes())?;
    say!("{} runs, {failed} failed; wrote {}", sets.len(), file.display());
    if let Some(trouble) = engine.cache().trouble() {
        eprintln!("warning: runs could not be kept in the cache: {trouble}");
    }
    Ok(if engine.is_stopped() { Ending::Interrupted } else { Ending::Complete })
}

fn read_sets(
    file: &Path,
    engine: &Engine,
    common: &BTreeMap<String, f64>,
) -> Result<Vec<Set>, Box<dyn std::error::Error>> {
    let at = |line: u64, what: String| format!("{}, line {line}: {what}", file.display());
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_path(file)?;
    let header = reader.headers()?.clone();
    let header_line = header.position().map_or(1, csv::Position::line);
    let mut columns = Vec::new();
    for text in header.iter().map(|h| h.trim_start_matches('\u{feff}')) {
        // Parameter names hold brackets themselves: a unit is what follows a space.
        let (name, unit) = text.split_once([' ', '\t']).map_or((text, ""), |(n, u)| (n, u.trim()));
        let unit = unit.trim_matches(['[', ']', '(', ')']).to_owned();
        if name != "name" {
            variable_named(engine.wiring(), name).map_err(|e| at(header_line, e.to_string()))?;
        }
        columns.push((name.to_owned(), unit));
    }
    let mut sets = Vec::new();
    for record in reader.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut set = Set { name: format!("{:04}", sets.len() + 1), parameters: common.clone() };
        for ((name, unit), field) in columns.iter().zip(&record) {
            if name == "name" {
                set.name = file_name(field);
                continue;
            }
            let variable = variable_named(engine.wiring(), name)?;
            let value =
                number_in(variable, &format!("{field}{unit}")).map_err(|e| at(line, e.to_string()))?;
            set.parameters.insert(name.clone(), value);
        }
        if sets.iter().any(|s: &Set| s.name == set.name) {
            return Err(at(line, format!("a second run is called `{}`", set.name)).into());
        }
        sets.push(set);
    }
    if sets.is_empty() {
        return Err(format!("{}: there is no parameter set in the file", file.display()).into());
    }
    Ok(sets)
}

/// A name that is safe as a file name.
fn file_name(text: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-_.+".contains(c) { c } else { '_' };
    text.chars().map(safe).collect::<String>().trim_start_matches('.').to_owned()
}
