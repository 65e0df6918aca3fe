//! `runner identify`: measurements in, parameters and what they are worth out.

use super::assumed;
use super::assumed::wrapped_line;
use super::engine_args::{EngineArguments, show_notes};
use super::exit::{RefusedData, UsageError};
use super::idle;
use super::progress::Progress;
use super::report::{RESULT, write_views};
use super::{CliResult, Ending};
use crate::data::{Measurement, Reading, Wanted, read_tests};
use crate::engine::Engine;
use crate::identification::profiles;
use crate::identification::report::{Context, report};
use crate::identification::{FitSettings, JacobianSource, Settings, identify};
use crate::inference::posterior::SamplePlan;
use crate::inference::start::{Known, MOST_BRANCHES, Mentioned, Start};
use crate::inference::{Requests, Setup, Unknowns};
use crate::noise::{Observation, Uncertainty, Weights, check};
use crate::output::{Folder, json};
use crate::report::Setting;
use crate::setting::settings_from;
use clap::Args;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Identify material parameters from measurements.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Measurements to fit: CSV files with time_s,displacement_mm,force_mN; or a directory with one file per
    /// specimen of a test; or NAME=FILE,FILE,... (see the README)
    #[arg(value_name = "MEASUREMENT", required_unless_present = "resume")]
    measurements: Vec<PathBuf>,
    /// Measurements to predict with the fitted parameters, not to fit
    #[arg(long, value_name = "MEASUREMENT", num_args = 1..)]
    validate: Vec<PathBuf>,
    /// Directory for result.json, parameters.csv, curves.csv and report.html
    #[arg(long, short, value_name = "DIR", default_value = "identification")]
    out: PathBuf,
    /// Where runs are kept [default: DIR/cache]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Continue an identification in --out that was stopped or killed; same settings, same result
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    fit: FitSettings,
    #[command(flatten)]
    engine: EngineArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments, stop: &Arc<AtomicBool>) -> CliResult {
    let started = std::time::Instant::now();
    let settings = settings(arguments)?;
    let engine_arguments = EngineArguments { jobs: arguments.engine.jobs, ..settings.engine.clone() };
    let cache = arguments.cache.clone().unwrap_or_else(|| arguments.out.join("cache"));
    let derivatives = settings.fit.jacobian != JacobianSource::Fd;
    let engine = engine_arguments.engine(&RECORDED.map(str::to_owned), derivatives, Some(cache), stop)?;
    let (weights, plan) = (settings.fit.weights()?, settings.fit.plan()?);
    let height = sample_height(&engine, &settings.engine)?;
    let sources = settings.measurements.iter().chain(&settings.validation);
    let files: Vec<PathBuf> = sources.map(|s| s.file.clone()).collect();
    let mut fitted = observations(&files, height, &settings.reading)?;
    let validation = fitted.split_off(settings.measurements.len());
    let doubts: Vec<String> = fitted.iter().flat_map(|o| o.measurement.doubts()).collect();
    let mut requests = settings.requests();
    let start = start(&engine, &fitted, &requests, 0..=MOST_BRANCHES)?;
    if let Some((start, mentioned)) = &start {
        requests.defaults = start.defaults(*mentioned);
    }
    let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
    idle::check(&settings.fit, &unknowns, &fitted)?;
    check(&fitted, &weights)?;
    check(&validation, &weights)?;
    if let Some(name) = profiles::unknown(&unknowns, &settings.fit.profile) {
        let known = profiles::names(&unknowns).join(", ");
        return Err(UsageError(format!(
            "--profile {name}: no such value; there are {known}, or the parameters' full names"
        ))
        .into());
    }
    check_points(&fitted, &weights, &unknowns)?;
    if settings.fit.jacobian == JacobianSource::Sensitivity {
        check_derivatives(&engine, &unknowns)?;
    }
    let names: Vec<&str> = unknowns.free().iter().map(|p| p.name.as_str()).collect();
    for line in assumed::lines(&engine, unknowns.fixed(), &names) {
        say!("{line}");
    }
    for doubt in &doubts {
        say!("warning: {doubt}");
    }
    match &start {
        Some((start, _)) => say!("{}", wrapped_line("start from the data: ", &start.in_words())),
        None if engine.is_own() => {
            say!("warning: the data do not tell where to start: Table 1's values and bounds are taken");
        }
        None => {}
    }
    let take = if arguments.resume { Folder::resume } else { Folder::begin };
    let folder = take(&arguments.out, "identify")?;
    settings.save(&folder)?;

    let progress = Progress::of_fit((plan.evaluations * plan.starts) as u64);
    let mut observe = |start: usize, record: &crate::fit::IterationRecord| {
        let done = start * plan.evaluations + record.evaluations;
        let runs = engine.cache().statistics().runs;
        let chi = record.chi_square;
        progress.show(
            done as u64,
            format!(
                "start {}/{}, iteration {}: chi^2 = {chi:.4}, {runs} runs",
                start + 1,
                plan.starts,
                record.iteration
            ),
        );
    };
    let setup = Setup { step: settings.fit.fd_step, ..Setup::new(&engine, &fitted, &unknowns) };
    let found = identify(setup, &weights, &plan, settings.fit.robust, &mut observe);
    progress.finish();
    let found = found?;
    let context = Context {
        setup,
        validation: &validation,
        weights: &weights,
        profile: &settings.fit.profile,
        posterior: settings
            .fit
            .posterior
            .then(|| SamplePlan { seed: settings.fit.seed, ..SamplePlan::default() }),
        evaluations: plan.evaluations,
        command: std::env::args().collect::<Vec<_>>().join(" "),
        settings: kept_settings(&settings, start.as_ref().map(|s| &s.0)),
        seconds: started.elapsed().as_secs_f64(),
    };
    let (mut report, missing) = report(&context, &found)?;
    report.verdict.warnings.splice(0..0, doubts);
    write_views(&report, &folder)?;
    folder.write(RESULT, &json(&folder.path().join(RESULT), &report)?)?;
    for reason in missing {
        eprintln!("warning: {reason}");
    }
    if let Some(trouble) = engine.cache().trouble() {
        eprintln!(
            "warning: runs could not be kept in the cache ({trouble}); results are complete, but --resume would repeat them"
        );
    }
    Ok(match (engine.is_stopped(), report.fit.stop.converged()) {
        (true, _) => Ending::Interrupted,
        (false, true) => Ending::Complete,
        (false, false) => Ending::NotConverged,
    })
}

/// Outputs wanted beside the force.
const RECORDED: [&str; 2] = ["force_solid", "force_fluid"];

/// New settings, or those that the work began with.
fn settings(arguments: &Arguments) -> Result<Settings, Box<dyn std::error::Error>> {
    let asked = || {
        Settings::new(
            &arguments.measurements,
            &arguments.validate,
            &arguments.engine,
            &arguments.fit,
            &arguments.reading,
        )
    };
    if !arguments.resume {
        return Ok(asked()?);
    }
    let begun = Settings::load(&arguments.out)?;
    // `--resume --out DIR` alone means: as before.
    if !arguments.measurements.is_empty() {
        begun.check_same(&asked()?)?;
    }
    Ok(begun)
}

/// Where the data say that the fit starts, with so many branches, and what the user said of it; poropunch's own FMU only.
pub(super) fn start(
    engine: &Engine,
    fitted: &[Observation],
    requests: &Requests,
    branches: RangeInclusive<usize>,
) -> Result<Option<(Start, Mentioned)>, Box<dyn std::error::Error>> {
    if !engine.is_own() {
        return Ok(None);
    }
    let set = settings_from(engine.wiring(), &requests.set)?;
    let default = |name: &str| engine.wiring().parameters.get(name)?.start_number();
    let known = Known::of(&|name| set.get(name).copied().or_else(|| default(name)));
    let mentioned = Mentioned::of(requests);
    let measurements: Vec<&Measurement> = fitted.iter().map(|o| &o.measurement).collect();
    let branches = mentioned.branch.max(*branches.start())..=*branches.end();
    let start = known.and_then(|known| Start::of(&measurements, &known, branches));
    Ok(start.map(|start| (start, mentioned)))
}

/// Height of the sample, where the FMU knows it.
pub(super) fn sample_height(
    engine: &Engine,
    arguments: &EngineArguments,
) -> Result<Option<f64>, Box<dyn std::error::Error>> {
    const NAME: &str = "geometry.sample_height";
    let set = settings_from(engine.wiring(), &arguments.settings())?;
    let start = || engine.wiring().parameters.get(NAME).and_then(crate::fmi::ScalarVariable::start_number);
    Ok(set.get(NAME).copied().or_else(start))
}

/// Reads and prepares measurements; what they leave open is asked at once.
pub(super) fn observations(
    files: &[PathBuf],
    height: Option<f64>,
    reading: &Reading,
) -> Result<Vec<Observation>, Box<dyn std::error::Error>> {
    let tests = read_tests(files, Wanted::MotionAndForce, reading)?;
    let mut observations = Vec::with_capacity(tests.len());
    for test in tests {
        show_notes(&test.measurement);
        observations.push(Observation::new(&test.measurement, height)?);
    }
    Ok(observations)
}

fn check_points(
    observations: &[Observation],
    weights: &Weights,
    unknowns: &Unknowns,
) -> Result<(), RefusedData> {
    for o in observations {
        // A weight that overflows, or a spread of zero, would decide the fit alone.
        let spread = (weights.uncertainty != Uncertainty::None).then_some(o.measurement.spread_n.as_ref());
        let least = spread.flatten().map_or(1.0, |s| s.iter().copied().fold(f64::INFINITY, f64::min));
        let heaviest = o.phases.iter().map(|p| weights.of(*p)).fold(0.0, f64::max);
        let overflows = !(least * least / heaviest.max(1.0) > 0.0 && (heaviest / least).is_finite());
        if overflows && o.factors.is_empty() {
            return Err(RefusedData(format!(
                "{}: a point has the deviation {least:e} N and the weight {heaviest:e}, which overflow; check force_std and \
                 --weight, or use --noise none",
                o.measurement.file.display()
            )));
        }
    }
    let counts = |o: &Observation| o.phases.iter().filter(|p| weights.of(**p) > 0.0).count();
    let points: usize = observations.iter().map(counts).sum();
    let free = unknowns.len();
    if points > free {
        return Ok(());
    }
    Err(RefusedData(format!(
        "{points} points cannot determine {free} parameters: fix some with --fix, or measure more points"
    )))
}

fn check_derivatives(engine: &Engine, unknowns: &Unknowns) -> Result<(), String> {
    let recorded = &engine.wiring().sensitivities;
    let slopes = |j| unknowns.slopes(unknowns.start(), j);
    let mut names = (0..unknowns.len()).flat_map(slopes).map(|(name, _)| name);
    match names.find(|name| !recorded.contains_key(name)) {
        None => Ok(()),
        Some(name) => Err(format!(
            "--jacobian sensitivity: with these settings the FMU has no derivative of the force by {name}; use --jacobian auto"
        )),
    }
}

/// What a reader of the report needs to repeat the fit.
fn kept_settings(settings: &Settings, start: Option<&Start>) -> Vec<Setting> {
    let fit = &settings.fit;
    let mut kept = vec![
        ("starts", fit.starts.to_string()),
        ("seed", fit.seed.to_string()),
        ("derivatives", format!("{:?}", fit.jacobian).to_lowercase()),
        ("finite-difference step", fit.fd_step.to_string()),
    ];
    kept.extend(start.map(|s| ("start from the data", s.in_words())));
    kept.extend(settings.engine.settings().into_iter().map(|s| ("set", s)));
    kept.extend(fit.weight.iter().map(|w| ("weight", w.clone())));
    kept.into_iter().map(|(name, value)| Setting { name: name.to_owned(), value }).collect()
}
