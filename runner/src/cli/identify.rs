//! `runner identify`: measurements in, parameters and what they are worth out.

use super::assumed;
use super::engine_args::{EngineArguments, cache_directory, show_notes};
use super::exit::{RefusedData, UsageError};
use super::idle;
use super::job::{Invocation, JobArguments};
use super::progress::Progress;
use super::report::{RESULT, write_views};
use super::terminal;
use super::{CliResult, Ending};
use crate::data::reading::{Tare, Zero};
use crate::data::{Reading, Synchronised, Wanted, read_tests};
use crate::engine::Engine;
use crate::identification::profiles;
use crate::identification::report::{Context, report};
use crate::identification::{
    Corrected, FitSettings, JacobianSource, Nuisances, identify, identify_with_zeros,
};
use crate::inference::posterior::SamplePlan;
use crate::inference::start::{MOST_BRANCHES, Start};
use crate::inference::{Setup, Unknowns};
use crate::noise::observation::left_out;
use crate::noise::{Observation, ObservationError, Uncertainty, Weights, check};
use crate::output::{Folder, json};
use crate::parameter_set::ssv;
use crate::report::Setting;
use crate::setting::settings_from;
use clap::Args;
use std::path::PathBuf;

/// Identify material parameters from measurements.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Measurements to fit: CSV files with time_s,displacement_mm,force_mN; or a directory with one file per
    /// specimen of a test; or NAME=FILE,FILE,... (see the documentation)
    #[arg(value_name = "MEASUREMENT", required_unless_present_any = ["resume", "job"])]
    measurements: Vec<PathBuf>,
    /// Measurements to predict with the fitted parameters, not to fit
    #[arg(long, value_name = "MEASUREMENT", num_args = 1..)]
    validate: Vec<PathBuf>,
    /// Directory for result.json, parameters.csv, parameters.ssv, curves.csv and report.html
    #[arg(long, short, value_name = "DIR", default_value = "identification")]
    out: PathBuf,
    /// Where runs are kept [default: what POROPUNCH_CACHE names in the environment, or DIR/cache]
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
    #[command(flatten)]
    job: JobArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments, call: &Invocation) -> CliResult {
    let started = std::time::Instant::now();
    let fit = &arguments.fit;
    let (weights, mut plan) = (fit.weights()?, fit.plan()?);
    let nuisances = Nuisances {
        zero: arguments.reading.zero == Some(Zero::Fit),
        tare: arguments.reading.tare == Some(Tare::Fit),
    };
    if let (Some(option), Uncertainty::None) = (arguments.reading.fitted(), weights.uncertainty) {
        let why = format!("{option} needs to know the noise, and --noise none says that nothing is known");
        return Err(UsageError(format!("{why}; leave one of the two out")).into());
    }
    let files = [arguments.measurements.as_slice(), &arguments.validate].concat();
    let tests = read_tests(&files, Wanted::MotionAndForce, &arguments.reading)?;
    let cache = cache_directory(arguments.cache.as_deref(), &arguments.out);
    let derivatives = fit.jacobian != JacobianSource::Fd;
    let recorded = RECORDED.map(str::to_owned);
    let engine = arguments.engine.engine(&recorded, derivatives, Some(&cache), &call.stop)?;
    let height = sample_height(&engine, &arguments.engine)?;
    let mut fitted = observations(tests, height)?;
    let validation = fitted.split_off(arguments.measurements.len());
    let doubts: Vec<String> = fitted.iter().flat_map(|o| o.measurement.doubts()).collect();
    let mut requests = fit.requests(arguments.engine.settings(engine.wiring())?);
    let start = Start::told_by(&engine, &fitted, &requests, 0..=MOST_BRANCHES)?;
    if let Some((start, mentioned)) = &start {
        requests.defaults = start.defaults(*mentioned);
    }
    let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
    if let Some((start, mentioned)) = &start {
        plan.others = start.elsewhere(*mentioned, &engine, &requests, &unknowns)?;
    }
    idle::check(fit, &unknowns, &fitted)?;
    check(&fitted, &weights)?;
    check(&validation, &weights)?;
    if let Some(name) = profiles::unknown(&unknowns, &fit.profile) {
        let known = profiles::names(&unknowns).join(", ");
        return Err(UsageError(format!(
            "--profile {name}: no such value; there are {known}, or the parameters' full names"
        ))
        .into());
    }
    check_points(&fitted, &weights, &unknowns)?;
    if fit.jacobian == JacobianSource::Sensitivity {
        check_derivatives(&engine, &unknowns)?;
    }
    let is_differenced = fit.jacobian == JacobianSource::Fd || check_derivatives(&engine, &unknowns).is_err();
    if fit.fd_step != FitSettings::STEP && !is_differenced {
        let why =
            format!("--fd-step {}: all derivatives are the FMU's own, so this acts on nothing", fit.fd_step);
        return Err(UsageError(format!("{why}; leave it out, or add --jacobian fd")).into());
    }
    let names: Vec<&str> = unknowns.free().iter().map(|p| p.name.as_str()).collect();
    let assumed = assumed::say_before(&assumed::of(&engine, unknowns.fixed(), &names));
    for doubt in &doubts {
        say!("warning: {doubt}");
    }
    match &start {
        Some((start, _)) => {
            say!("start from the data: {}", start.in_words());
            if !plan.others.is_empty() {
                say!("{}", Start::elsewhere_in_words());
            }
        }
        None if engine.is_own() => {
            say!("warning: the data do not tell where to start: Table 1's values and bounds are taken");
        }
        None => {}
    }
    let take = if arguments.resume { Folder::resume } else { Folder::begin };
    let folder = take(&arguments.out, "identify")?;
    call.keep(&folder)?;

    let starts = plan.all_starts();
    let progress = Progress::of_fit((plan.evaluations * starts) as u64);
    let mut evaluations = vec![0; starts];
    let mut observe = |start: usize, record: &crate::fit::IterationRecord| {
        evaluations[start] = record.evaluations;
        let done: usize = evaluations.iter().sum();
        let runs = engine.cache().statistics().runs;
        let chi = record.chi_square;
        let (start, iteration) = (start + 1, record.iteration);
        let text = format!("start {start}/{starts}, iteration {iteration}: chi^2 = {chi:.4}, {runs} runs");
        let numbers = serde_json::json!({ "start": start, "starts": starts, "iteration": iteration,
            "chi_square": chi, "evaluations": done, "runs": runs });
        progress.show_fit(done as u64, text, numbers);
    };
    let setup = Setup { step: fit.fd_step, ..Setup::new(&engine, &fitted, &unknowns) };
    let found = if nuisances == Nuisances::default() {
        let identification = identify(setup, &weights, &plan, fit.robust, &mut observe);
        identification.map(|identification| Corrected { identification, observations: vec![], rows: vec![] })
    } else {
        identify_with_zeros(setup, nuisances, &weights, &plan, fit.robust, &mut observe)
    };
    progress.finish();
    let Corrected { identification: found, observations: moved, rows } = found?;
    let setup = if moved.is_empty() { setup } else { Setup { observations: &moved, ..setup } };
    let context = Context {
        setup,
        validation: &validation,
        weights: &weights,
        profile: &fit.profile,
        posterior: fit.posterior.then(|| SamplePlan { seed: fit.seed, ..SamplePlan::default() }),
        evaluations: plan.evaluations,
        command: call.command(),
        settings: kept_settings(arguments, &requests.set, start.as_ref().map(|s| &s.0)),
        nuisances: rows,
        seconds: started.elapsed().as_secs_f64(),
    };
    let (mut report, missing) = report(&context, &found)?;
    report.verdict.warnings.splice(0..0, doubts.into_iter().chain(left_out(setup.observations)));
    write_views(&report, &folder)?;
    if let Some(assumed) = assumed {
        say!("{assumed}");
    }
    folder.write(RESULT, &json(&folder.path().join(RESULT), &report)?)?;
    folder.write(PARAMETERS, ssv(&report.given.title, engine.wiring(), &found.values).as_bytes())?;
    say!("wrote {PARAMETERS} as well: `--parameters` and other FMI tools read it");
    for reason in missing {
        terminal::warning(&reason);
    }
    if let Some(trouble) = engine.cache().trouble() {
        terminal::warning(&format!(
            "runs could not be kept in the cache ({trouble}); results are complete, but --resume would repeat them"
        ));
    }
    terminal::result(&report)?;
    Ok(match (engine.is_stopped(), report.fit.stop.converged()) {
        (true, _) => Ending::Interrupted,
        (false, true) => Ending::Complete,
        (false, false) => Ending::NotConverged,
    })
}

/// Everything that the fitted model was run with.
const PARAMETERS: &str = "parameters.ssv";
/// Outputs wanted beside the force.
const RECORDED: [&str; 2] = ["force_solid", "force_fluid"];

/// Height of the sample, where the FMU knows it.
pub(super) fn sample_height(
    engine: &Engine,
    arguments: &EngineArguments,
) -> Result<Option<f64>, Box<dyn std::error::Error>> {
    const NAME: &str = "geometry.sample_height";
    let set = settings_from(engine.wiring(), &arguments.settings(engine.wiring())?)?;
    let start = || engine.wiring().parameters.get(NAME).and_then(crate::fmi::ScalarVariable::start_number);
    Ok(set.get(NAME).copied().or_else(start))
}

/// Prepares measurements, and tells what was read leniently.
pub(super) fn observations(
    tests: Vec<Synchronised>,
    height: Option<f64>,
) -> Result<Vec<Observation>, ObservationError> {
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
fn kept_settings(arguments: &Arguments, set: &[String], start: Option<&Start>) -> Vec<Setting> {
    let fit = &arguments.fit;
    let mut kept = vec![
        ("starts", fit.starts.to_string()),
        ("seed", fit.seed.to_string()),
        ("derivatives", format!("{:?}", fit.jacobian).to_lowercase()),
        ("finite-difference step", fit.fd_step.to_string()),
    ];
    kept.extend(start.map(|s| ("start from the data", s.in_words())));
    kept.extend(set.iter().map(|s| ("set", s.clone())));
    kept.extend(fit.weight.iter().map(|w| ("weight", w.clone())));
    kept.into_iter().map(|(name, value)| Setting { name: name.to_owned(), value }).collect()
}
