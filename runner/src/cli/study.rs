//! `runner study`: the same question for many specimens.

use super::exit::UsageError;
use super::progress::Progress;
use super::terminal;
use super::{CliResult, Ending};
use crate::study::plan::{Asked, rows_per_unit};
use crate::study::submit::{Engine, Needs, Submission, measured, per_task, tasks, units_of_task};
use crate::study::unit::program_hash;
use crate::study::work::{Ended, Worker};
use crate::study::{Plan, Question, Unit, gather, ranges, status};
use clap::{Args, Subcommand, ValueHint};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// What is done with the specimens.
#[derive(Debug, Subcommand)]
pub enum Step {
    /// Write the units of work: plan.json and units.jsonl
    Plan(PlanArguments),
    /// Do units: one, those of an array's task, or all that have no result
    Work(WorkArguments),
    /// Hand the units that have no result to an engine
    Submit(SubmitArguments),
    /// Tell how many units are done, running, failed and why
    Status(StatusArguments),
    /// Write the table of all results, the population and the page
    Gather(GatherArguments),
}

#[derive(Debug, Args)]
pub struct PlanArguments {
    /// CSV table with the columns specimen, files (several with `;`), and if wanted group, parameters
    /// (`geometry.sample_height [mm]`) and covariates; the table of batch; a folder of challenge; or a study.toml
    #[arg(value_name = "TABLE|TOML", value_hint = ValueHint::AnyPath)]
    table: PathBuf,
    /// Directory of the plan, on a file system that all workers see
    #[arg(long, short, value_name = "DIR", default_value = "study")]
    out: PathBuf,
    /// What is asked of each
    #[arg(long, value_enum)]
    question: Option<Question>,
    /// Rows of the table of batch in one unit [default: 60]
    #[arg(long, value_name = "N", value_parser = super::count::starts)]
    rows: Option<usize>,
    /// Where results are kept, shared by any number of plans [default: DIR/results]
    #[arg(long, value_name = "DIR")]
    results: Option<PathBuf>,
    /// Options of the command that is asked, after `--`
    #[arg(last = true, value_name = "OPTION")]
    options: Vec<String>,
}

#[derive(Debug, Args)]
pub struct WorkArguments {
    /// Directory of the plan
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// Units, as 3 or 1-20,35
    #[arg(long, value_name = "N", conflicts_with_all = ["all", "task"])]
    unit: Option<String>,
    /// All units that have no result, on this machine
    #[arg(long, conflicts_with = "task")]
    all: bool,
    /// Task of an array, from 1 [default: SLURM_ARRAY_TASK_ID, HQ_TASK_ID or PBS_ARRAY_INDEX]
    #[arg(long, value_name = "I")]
    task: Option<usize>,
    /// Units of one task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::count::starts)]
    per_task: usize,
    /// Try failed units again
    #[arg(long)]
    again: bool,
    /// Cores to use; with --all, units at a time [default: one of each; with --all, all cores]
    #[arg(long, short, value_name = "N", default_value_t = 0, hide_default_value = true,
        value_parser = super::count::jobs)]
    jobs: usize,
}

#[derive(Debug, Args)]
pub struct SubmitArguments {
    /// Directory of the plan
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// What runs the units
    #[arg(long, value_enum, default_value_t)]
    engine: Engine,
    /// Print the script and submit nothing
    #[arg(long)]
    dry_run: bool,
    /// Failed units, too
    #[arg(long)]
    again: bool,
    /// Units of one task [default: so many that there are 1000 tasks at most; of Slurm's, that one takes two minutes]
    #[arg(long, value_name = "N", value_parser = super::count::starts)]
    per_task: Option<usize>,
    /// Cores of a task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::count::starts)]
    cores: usize,
    /// Memory of a task (MB) [default: half as much again as units took]
    #[arg(long, value_name = "MB")]
    memory: Option<u64>,
    /// Time of a task, as 20min [default: three times what its units took]
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    time: Option<Duration>,
    /// Option for the engine, as --engine-option=--partition=short (repeatable)
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    engine_option: Vec<String>,
}

#[derive(Debug, Args)]
pub struct StatusArguments {
    /// Directory of the plan
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// One JSON line for each unit instead
    #[arg(long)]
    lines: bool,
}

#[derive(Debug, Args)]
pub struct GatherArguments {
    /// Directory of the plan
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// Where to write table.csv, population.json and study.html [default: PLAN/gathered]
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Difference between groups that is to be found, in per cent of a value
    #[arg(long, value_name = "PERCENT", default_value_t = 20.0)]
    difference: f64,
}

/// Runs the command.
pub fn run(step: &Step, stop: &Arc<AtomicBool>) -> CliResult {
    match step {
        Step::Plan(arguments) => plan(arguments),
        Step::Work(arguments) => work(arguments, stop),
        Step::Submit(arguments) => submit(arguments, stop),
        Step::Status(arguments) => show_status(arguments),
        Step::Gather(arguments) => gathered(arguments),
    }
}

/// Options that belong to the study, not to its question.
const OWN: [&str; 8] = ["--out", "-o", "--cache", "--resume", "--jobs", "-j", "--json", "--progress"];

fn plan(arguments: &PlanArguments) -> CliResult {
    let is_toml = arguments.table.extension().is_some_and(|e| e == "toml");
    let mut asked = if is_toml {
        Asked::read(&arguments.table)?
    } else {
        Asked { table: arguments.table.clone(), rows_per_unit: rows_per_unit(), ..Asked::default() }
    };
    asked.question = arguments.question.unwrap_or(asked.question);
    asked.rows_per_unit = arguments.rows.unwrap_or(asked.rows_per_unit).max(1);
    asked.results = arguments.results.clone().or(asked.results);
    asked.options.extend(arguments.options.iter().cloned());
    let is_own = |o: &&String| OWN.contains(&o.split('=').next().unwrap_or(o));
    if let Some(own) = asked.options.iter().find(is_own) {
        let why = format!("{own}: the study decides that for each unit; leave it out");
        return Err(UsageError(why).into());
    }
    let program = super::program();
    let command = program.find_subcommand(asked.question.command());
    let takes_path = |a: &&clap::Arg| a.get_value_hint() != ValueHint::Unknown;
    let paths: Vec<String> = command
        .into_iter()
        .flat_map(|c| c.get_arguments().filter(takes_path).filter_map(clap::Arg::get_long))
        .map(|long| format!("--{long}"))
        .collect();
    let hash = program_hash()?;
    let units = asked.units(&hash, &|name| paths.iter().any(|p| p == name))?;
    check(&program, asked.question, &units)?;
    let plan = Plan::make(&asked, hash, &units, &arguments.out)?;
    let done = units.len() - status::missing(&plan, true)?.len();
    let there = if done > 0 { format!("; {done} have their results already") } else { String::new() };
    say!("{} units in {}{there}", units.len(), arguments.out.display());
    say!("next: runner study submit {}", arguments.out.display());
    Ok(Ending::Complete)
}

/// What clap would say to the first unit, before a thousand of them say it.
fn check(program: &clap::Command, question: Question, units: &[Unit]) -> Result<(), UsageError> {
    let Some(unit) = units.first() else { return Ok(()) };
    let words = ["runner", question.command()].map(str::to_owned).into_iter();
    let words = words.chain(unit.options.iter().cloned()).chain(["--".to_owned()]);
    let inputs = unit.inputs.iter().filter(|i| !i.is_option).map(|i| i.argument.clone());
    let refused = program.clone().try_get_matches_from(words.chain(inputs)).err();
    refused.map_or(Ok(()), |e| {
        let text = e.to_string();
        let said = text.lines().take_while(|l| !l.is_empty()).map(str::trim).collect::<Vec<_>>().join(" ");
        Err(UsageError(format!("`{}`: {}", question.command(), said.trim_start_matches("error: "))))
    })
}

fn work(arguments: &WorkArguments, stop: &Arc<AtomicBool>) -> CliResult {
    let plan = Plan::open(&arguments.plan)?;
    if arguments.all {
        return work_all(&plan, arguments.jobs, arguments.again, stop);
    }
    let numbers = match &arguments.unit {
        Some(text) => ranges::read(text).map_err(|e| UsageError(format!("--unit: {e}")))?,
        None => {
            let task = arguments.task.or_else(task_of_engine).ok_or_else(|| {
                UsageError(
                    "which unit? give --unit N or --all; within an array, SLURM_ARRAY_TASK_ID, HQ_TASK_ID or PBS_ARRAY_INDEX \
                     say it"
                        .to_owned(),
                )
            })?;
            units_of_task(task, arguments.per_task, plan.header.units).collect()
        }
    };
    let worker = Worker::new(&plan, arguments.jobs.max(1), arguments.again, stop)?;
    let mut failed = 0;
    for number in numbers {
        let unit = plan.unit(number)?;
        let ended = worker.work(&unit)?;
        tell(&unit, &ended);
        if ended == Ended::Stopped {
            return Ok(Ending::Interrupted);
        }
        failed += usize::from(is_failure(&ended));
    }
    if failed > 0 {
        return Err(format!("{failed} units failed; their reasons are kept, --again tries again").into());
    }
    Ok(Ending::Complete)
}

/// Index of the array's task, from the engine that started this process.
fn task_of_engine() -> Option<usize> {
    let names = ["SLURM_ARRAY_TASK_ID", "HQ_TASK_ID", "PBS_ARRAY_INDEX"];
    names.iter().find_map(|name| std::env::var(name).ok()?.trim().parse().ok())
}

fn is_failure(ended: &Ended) -> bool {
    matches!(ended, Ended::Failed(_) | Ended::FailedBefore(_))
}

fn tell(unit: &Unit, ended: &Ended) {
    let text = match ended {
        Ended::Already => "its result is there".to_owned(),
        Ended::Done { converged: true } => "done".to_owned(),
        Ended::Done { converged: false } => "done, but the fit did not converge".to_owned(),
        Ended::FailedBefore(reason) => format!("failed before: {reason}"),
        Ended::Failed(reason) => format!("failed: {reason}"),
        Ended::Elsewhere => "another process works on it".to_owned(),
        Ended::Stopped => "stopped; nothing of it is kept".to_owned(),
    };
    say!("unit {}, {}: {text}", unit.unit, unit.specimen);
}

fn work_all(plan: &Plan, jobs: usize, again: bool, stop: &Arc<AtomicBool>) -> CliResult {
    let numbers = status::missing(plan, again)?;
    let worker = Worker::new(plan, 1, again, stop)?;
    let cores = std::thread::available_parallelism().map_or(1, Into::into);
    let at_a_time = if jobs > 0 { jobs } else { cores };
    let progress = Progress::of_runs(numbers.len() as u64);
    let told = |unit: &Unit, ended: &Ended| {
        progress.advance();
        if is_failure(ended) {
            tell(unit, ended);
        }
    };
    let worked = worker.work_all(&numbers, at_a_time, &told);
    progress.finish();
    worked?;
    if stop.load(Ordering::Relaxed) {
        return Ok(Ending::Interrupted);
    }
    say_status(&status::status(plan, &mut |_| {})?);
    Ok(Ending::Complete)
}

fn submit(arguments: &SubmitArguments, stop: &Arc<AtomicBool>) -> CliResult {
    let plan = Plan::open(&arguments.plan)?;
    plan.check_program()?;
    let again = arguments.again;
    if arguments.engine == Engine::Local && !arguments.dry_run {
        return work_all(&plan, 0, again, stop);
    }
    let known = || arguments.memory.is_some() && arguments.time.is_some();
    if !arguments.dry_run && !known() && measured(&plan)?.is_none() {
        // What a unit needs is told by one that was done.
        if let Some(&first) = status::missing(&plan, again)?.first() {
            let unit = plan.unit(first)?;
            let ended = Worker::new(&plan, arguments.cores, again, stop)?.work(&unit)?;
            tell(&unit, &ended);
            if ended == Ended::Stopped {
                return Ok(Ending::Interrupted);
            }
        }
    }
    let pilot = measured(&plan)?;
    // A fit of minutes in a few hundred megabytes, until a unit says better.
    let (seconds, memory_mb) = pilot.unwrap_or((600.0, 500.0));
    let per_task =
        arguments.per_task.unwrap_or_else(|| per_task(arguments.engine, plan.header.units, seconds));
    let tasks = tasks(&plan, per_task, again)?;
    if tasks.is_empty() {
        say!("nothing is left to do");
        return Ok(Ending::Complete);
    }
    if pilot.is_none() && !known() {
        terminal::note(
            "no unit is done yet: time and memory are guesses until the first one (--memory, --time)",
        );
    }
    let mut needs = Needs::from_measured((seconds, memory_mb), per_task, arguments.cores);
    needs.memory_mb = arguments.memory.unwrap_or(needs.memory_mb);
    needs.seconds = arguments.time.map_or(needs.seconds, |t| t.as_secs().max(1));
    let work = if again { vec!["--again".to_owned()] } else { vec![] };
    let options = arguments.engine_option.clone();
    let submission = Submission { engine: arguments.engine, per_task, tasks, needs, options, work };
    if arguments.dry_run {
        // As it is: a script must not be wrapped.
        let _ = std::io::Write::write_all(&mut std::io::stdout(), submission.script(&plan)?.as_bytes());
        return Ok(Ending::Complete);
    }
    let said = submission.submit(&plan)?;
    match arguments.engine {
        Engine::Parallel | Engine::Local => say_status(&status::status(&plan, &mut |_| {})?),
        Engine::Slurm => say!("job {said}, {} tasks", submission.tasks.len()),
        Engine::Hyperqueue => say!("{said}"),
    }
    Ok(Ending::Complete)
}

fn show_status(arguments: &StatusArguments) -> CliResult {
    let plan = Plan::open(&arguments.plan)?;
    let mut lines = String::new();
    let found = status::status(&plan, &mut |unit| {
        if arguments.lines {
            lines.push_str(&serde_json::to_string(unit).unwrap_or_default());
            lines.push('\n');
        }
    })?;
    if arguments.lines {
        let _ = std::io::Write::write_all(&mut std::io::stdout(), lines.as_bytes());
    } else {
        say_status(&found);
        terminal::result(&found)?;
    }
    Ok(Ending::Complete)
}

fn say_status(s: &status::Status) {
    say!(
        "{} units: {} done, {} running, {} failed, {} waiting",
        s.units,
        s.counts.done,
        s.counts.running,
        s.counts.failed,
        s.counts.waiting
    );
    if let Some(left) = s.seconds_left {
        say!("some {} left", humantime::format_duration(Duration::from_secs(left.ceil() as u64)));
    }
    for reason in &s.reasons {
        say!("failed {}: {}", reason.units, reason.reason);
    }
}

fn gathered(arguments: &GatherArguments) -> CliResult {
    let plan = Plan::open(&arguments.plan)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new(&plan.directory).join("gathered"));
    let summary = gather::gather(&plan, &out, arguments.difference)?;
    say!("{}", summary.text);
    say!("wrote {} to {}", summary.files.join(", "), out.display());
    if let Some(population) = &summary.population {
        terminal::result(population)?;
    }
    Ok(Ending::Complete)
}
