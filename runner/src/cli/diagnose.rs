//! `runner diagnose`: measurements in, what the model lacks out.

use super::assumed;
use super::engine_args::{EngineArguments, cache_directory, show_notes};
use super::identify::sample_height;
use super::idle;
use super::idle::nothing_fitted;
use super::job::{Invocation, JobArguments};
use super::progress::Progress;
use super::terminal;
use super::{CliResult, Ending};
use crate::assumption;
use crate::data::measurement::DOUBT;
use crate::data::{DataError, Measurement, Reading, Synchronised, Wanted, read_tests};
use crate::diagnosis::declared::declared;
use crate::diagnosis::diagnose::{DiagnosisError, Effort, Given, diagnose};
use crate::diagnosis::page::page;
use crate::diagnosis::plain_start::PlainStarts;
use crate::diagnosis::published;
use crate::diagnosis::result::Diagnosis;
use crate::diagnosis::summary::{About, summary};
use crate::diagnosis::thresholds::Thresholds;
use crate::diagnosis::wording::table;
use crate::fit::{EvaluationFailure, FitError};
use crate::inference::Requests;
use crate::inference::Setup;
use crate::inference::effect::Effect;
use crate::inference::fit::FitFailure;
use crate::inspection::{Options, examine};
use crate::noise::observation::observe;
use crate::output::{Folder, json, protect};
use crate::pool::{Job, Priority, RunFailure};
use crate::setting::{settings_from, written};
use clap::{Args, ValueHint};
use poropunch::motion::protocol::{ProtocolError, Trapezoid};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Tell which unmodelled effect explains the gap between the best fit and the measurements.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Measurements, all explained together: CSV files with time_s,displacement_mm,force_mN; or a directory with
    /// one file per specimen of a test; or NAME=FILE,FILE,...
    #[arg(value_name = "MEASUREMENT", required_unless_present_any = ["published", "resume", "job"])]
    pub(super) measurements: Vec<PathBuf>,
    /// Instead of curves, published peaks and relaxations of two protocols (a CSV file): what their ratios say
    #[arg(long, value_name = "FILE", conflicts_with = "measurements", value_hint = ValueHint::FilePath)]
    pub(super) published: Option<PathBuf>,
    /// Go on with the diagnosis of the --out directory as it was begun: finished runs are not repeated
    #[arg(long, conflicts_with = "published")]
    pub(super) resume: bool,
    /// Screening, and refits of the effects that promise most only
    #[arg(long)]
    pub(super) quick: bool,
    /// Tell every step on stderr, with the time since the start
    #[arg(long)]
    pub(super) verbose: bool,
    /// Directory for diagnosis.json and diagnosis.html
    #[arg(long, short, value_name = "DIR", default_value = "diagnosis")]
    pub(super) out: PathBuf,
    /// Where runs are kept [default: what POROPUNCH_CACHE names in the environment, or DIR/cache]
    #[arg(long, value_name = "DIR")]
    pub(super) cache: Option<PathBuf>,
    /// Parameter not to fit, at this value or its default (repeatable)
    #[arg(long, value_name = "NAME[=VALUE[UNIT]]")]
    pub(super) fix: Vec<String>,
    /// Start of a fitted parameter, and centre of what is believed of it [default: what the data say] (repeatable)
    #[arg(long, value_name = "NAME=VALUE[UNIT]")]
    pub(super) start: Vec<String>,
    /// Exactly these are fitted [default: the material's] (repeatable, or a,b,c)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) free: Vec<String>,
    /// Bounds of a fitted parameter [default: what the data say] (repeatable)
    #[arg(long, value_name = "NAME=LOWER:UPPER")]
    pub(super) bounds: Vec<String>,
    /// An effect of your own beside the catalogue's: a parameter of the FMU, its value without the effect, and
    /// the change that a plausible effect makes, e.g. thinner=geometry.sample_height:10mm:-0.5mm (repeatable)
    #[arg(long, value_name = "NAME=PARAMETER:NULL:SCALE")]
    pub(super) effect: Vec<String>,
    /// A gap of a smaller part of the peak does not matter, e.g. 0.5%
    #[arg(long, value_name = "PERCENT", default_value = "1%", value_parser = percent)]
    pub(super) matters: f64,
    /// Another value of a constant that decides the answer, for studies of the method (repeatable)
    #[arg(long, value_name = "NAME=VALUE", hide_short_help = true)]
    pub(super) threshold: Vec<String>,
    /// Largest number of evaluations of each fit (those inside a Jacobian are not counted)
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = super::count::evaluations)]
    pub(super) max_evaluations: usize,
    #[command(flatten)]
    pub(super) reading: Reading,
    #[command(flatten)]
    pub(super) engine: EngineArguments,
    #[command(flatten)]
    pub(super) job: JobArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments, call: &Invocation) -> CliResult {
    nothing_fitted(&arguments.reading, "diagnose")?;
    if let Some(file) = &arguments.published {
        return ratios_of(file, arguments, &call.stop);
    }
    let tests = tests_of(arguments)?;
    let take = if arguments.resume { Folder::resume } else { Folder::begin };
    let folder = take(&arguments.out, "diagnose")?;
    call.keep(&folder)?;
    let found = diagnosis_of(arguments, tests, call.command(), &call.stop)?;
    let Some(diagnosis) = found else { return Ok(Ending::Interrupted) };
    let assumed = assumed::say_before(&diagnosis.assumptions);
    for doubt in diagnosis.warnings.iter().filter(|w| w.contains(DOUBT)) {
        say!("warning: {doubt}");
    }
    say!("{}", table(&diagnosis));
    if let Some(assumed) = assumed {
        say!("\n{assumed}");
    }
    folder.write("diagnosis.json", &json(&folder.path().join("diagnosis.json"), &diagnosis)?)?;
    folder.write("diagnosis.html", page(&diagnosis).as_bytes())?;
    say!("wrote diagnosis.json and diagnosis.html to {}", folder.path().display());
    terminal::result(&diagnosis)?;
    Ok(Ending::Complete)
}

/// What published ratios say beside the model's own effect of the rate.
fn ratios_of(file: &Path, arguments: &Arguments, stop: &Arc<AtomicBool>) -> CliResult {
    protect(file);
    let lines = published::read(file)?;
    let engine = arguments.engine.engine(&[], false, None, stop)?;
    let parameters = settings_from(engine.wiring(), &arguments.engine.settings(engine.wiring())?)?;
    let run = |trapezoid: Trapezoid| -> Result<_, ProtocolError> {
        let protocol = trapezoid.first_hold()?;
        let time_s = vec![protocol.points()[1].0, protocol.end_time()].into();
        let job = Job { parameters: parameters.clone(), protocol: Arc::new(protocol), time_s };
        Ok(engine.submit(&job, Priority::Urgent))
    };
    let runs = [run(Trapezoid::p1())?, run(Trapezoid::p2())?];
    // The peak of a ramp-and-hold is at the end of its ramp.
    let mut kept = Vec::new();
    for run in &runs {
        let curve = match run.wait() {
            Ok(curve) => curve,
            Err(RunFailure::Cancelled) => return Ok(Ending::Interrupted),
            Err(failure) => return Err(format!("the simulation failed: {failure}").into()),
        };
        kept.push(curve.force_n()[0] / curve.force_n()[1]);
    }
    let model = kept[1] / kept[0];
    for ratios in published::ratios(&lines) {
        say!("{}", ratios.words(model));
    }
    say!("{}", published::UNDECIDED);
    Ok(Ending::Complete)
}

/// The measurements that are asked about.
///
/// # Errors
/// When a file cannot be used.
pub fn tests_of(arguments: &Arguments) -> Result<Vec<Synchronised>, DataError> {
    read_tests(&arguments.measurements, Wanted::MotionAndForce, &arguments.reading)
}

/// The diagnosis of some tests, asked for by `command`; `None` when the user stopped it.
///
/// # Errors
/// When a measurement cannot be used, or the model fails.
pub fn diagnosis_of(
    arguments: &Arguments,
    tests: Vec<Synchronised>,
    command: String,
    stop: &Arc<AtomicBool>,
) -> Result<Option<Diagnosis>, Box<dyn std::error::Error>> {
    let started = std::time::Instant::now();
    let options = Options { contact_threshold_n: CONTACT_N, water: None, command: command.clone() };
    let inspection = examine(&tests, &options)?;
    let cache = cache_directory(arguments.cache.as_deref(), &arguments.out);
    let engine = arguments.engine.engine(&[], true, Some(&cache), stop)?;
    let declared = declared(engine.wiring(), &arguments.effect)?;
    let mut requests = Requests {
        set: arguments.engine.settings(engine.wiring())?,
        free: arguments.free.clone(),
        bounds: arguments.bounds.clone(),
        fix: arguments.fix.clone(),
        start: arguments.start.clone(),
        ..Requests::default()
    };
    let height = sample_height(&engine, &arguments.engine)?;
    let measurements: Vec<_> = tests.into_iter().map(|t| t.measurement).collect();
    measurements.iter().for_each(show_notes);
    let doubts: Vec<String> = measurements.iter().flat_map(Measurement::doubts).collect();
    let observations = observe(&measurements, height)?;
    // Without the effect its parameter has the value that was declared.
    requests.set.extend(declared.iter().map(|d| written(engine.wiring(), &d.parameter, d.null)));
    let starts = PlainStarts::of(&engine, &observations, &requests)?;
    let unknowns = &starts.unknowns;
    idle::bounds_and_starts(&arguments.bounds, &arguments.start, unknowns)?;
    let effects: Vec<Effect> = declared.into_iter().map(|d| d.effect).collect();

    let progress = Progress::of_fit(0);
    let effort = Effort {
        quick: arguments.quick,
        evaluations: arguments.max_evaluations,
        matters_percent: arguments.matters,
        thresholds: Thresholds::default().with(&arguments.threshold)?,
    };
    let given = Given { sample_height_m: height, declared: &effects };
    let mut say = |what: String| {
        if arguments.verbose {
            terminal::aside("text", &format!("{:.1} s: {what}", started.elapsed().as_secs_f64()));
        }
        progress.show(0, what);
    };
    let found = diagnose(&engine, observations, &starts, given, effort, &mut say);
    progress.finish();
    let found = match found {
        Err(error) if is_interruption(&error) => return Ok(None),
        other => other?,
    };
    let about = About {
        setup: Setup::new(&engine, &found.observations, unknowns),
        inspection: &inspection,
        command,
        quick: arguments.quick,
        matters_percent: arguments.matters,
        seconds: started.elapsed().as_secs_f64(),
    };
    let mut diagnosis = summary(&found, &about);
    let fitted: Vec<&str> = unknowns.free().iter().map(|p| p.name.as_str()).collect();
    diagnosis.assumptions = assumed::of(&engine, unknowns.fixed(), &fitted);
    diagnosis.warnings.splice(0..0, doubts);
    diagnosis.warnings.splice(0..0, assumption::geometry_warning(&diagnosis.assumptions));
    Ok(Some(diagnosis))
}

/// A positive number of per cent, with or without its sign.
fn percent(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('%').trim_end().parse::<f64>().ok();
    number
        .filter(|n| *n > 0.0 && n.is_finite())
        .ok_or_else(|| "write a part of the peak in per cent, e.g. 0.5%".to_owned())
}

/// Force that means contact (N): that of the paper.
const CONTACT_N: f64 = 1e-3;

fn is_interruption(error: &DiagnosisError) -> bool {
    matches!(
        error,
        DiagnosisError::Model(EvaluationFailure::Interrupted)
            | DiagnosisError::Baseline(
                FitFailure::Evaluation(EvaluationFailure::Interrupted)
                    | FitFailure::Fit(FitError::Interrupted)
            )
    )
}
