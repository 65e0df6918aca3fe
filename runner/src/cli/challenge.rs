//! `runner challenge`: cases whose cause the diagnosis does not know.

use super::diagnose::{self, diagnosis_of, tests_of};
use super::engine_args::EngineArguments;
use super::exit::{USAGE, UsageError, code_of};
use super::job::{Invocation, JobArguments};
use super::progress::Progress;
use super::terminal;
use super::{CliResult, Ending};
use crate::challenge::draw::Kind;
use crate::challenge::ground::Ground;
use crate::challenge::key::{CASES, SEAL, Secret, open};
use crate::challenge::make::{Made, Plan, make};
use crate::challenge::score::{Batch, Table, score};
use crate::challenge::table::markdown;
use crate::data::Reading;
use crate::diagnosis::result::Diagnosis;
use crate::output::{check_free, json, read_input, write_file};
use crate::setting::settings_from;
use clap::{Args, Subcommand};
use std::path::{Path, PathBuf};

/// What is done with the cases.
#[derive(Debug, Subcommand)]
pub enum Step {
    /// Draw causes, sizes and materials at random, simulate them with another solver than the diagnosis', add noise,
    /// and write the data; the key is sealed.
    ///
    /// The wide ground is computed by a solver that shares nothing with the model but its laws (other elements, time
    /// steps, contact, and another form of every effect); --mesh, --set and --parameters are the model's and act on the
    /// near ground alone, which is computed with the model on a finer mesh and by backward Euler.
    Make(Make),
    /// Diagnose every case of a folder (only its data are read); answers that are there already are kept.
    Answer(Box<Answer>),
    /// Open the key and print the table of scores.
    Score(Score),
}

#[derive(Debug, Args)]
pub struct Make {
    /// Seed of all draws [default: one that only the key tells]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Number of cases
    #[arg(long, value_name = "N", default_value_t = 100)]
    cases: usize,
    /// Only these kinds of cases, as often as among all of them [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    kinds: Vec<Kind>,
    /// Where they are drawn from
    #[arg(long, value_name = "GROUND", default_value_t = Ground::Wide, value_enum)]
    ground: Ground,
    /// Draw single effects and pairs again until each effect can be seen
    #[arg(long)]
    visible: bool,
    /// Cycles of each test; one ends with its hold
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(i32).range(1..=12))]
    cycles: i32,
    /// Folder of the cases
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
    /// File of the key [default: DIR.key.json, beside the folder]
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// Where what opens the key is kept [default: it is printed, once]
    #[arg(long, value_name = "FILE")]
    secret: Option<PathBuf>,
    #[command(flatten)]
    engine: EngineArguments,
    #[command(flatten)]
    job: JobArguments,
}

#[derive(Debug, Args)]
pub struct Answer {
    /// Folder of the cases
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Screening, and refits of the effects that promise most only
    #[arg(long)]
    quick: bool,
    /// Largest number of evaluations of each fit
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = super::count::evaluations)]
    max_evaluations: usize,
    /// Where runs are kept; without it, no run outlasts its case
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    #[command(flatten)]
    engine: EngineArguments,
    #[command(flatten)]
    job: JobArguments,
}

#[derive(Debug, Args)]
pub struct Score {
    /// Folders of the cases and answers: the batches are scored as one
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// File of the key; of several batches once for each [default: DIR.key.json]
    #[arg(long, value_name = "FILE")]
    key: Vec<PathBuf>,
    /// What opens it: the digits that `challenge make` printed, or the file that it wrote; once for each batch
    #[arg(long, value_name = "SECRET", required = true)]
    secret: Vec<String>,
    /// Table of cases that were scored before (the JSON of this command), to which these are added; repeatable
    #[arg(long, value_name = "FILE")]
    with: Vec<PathBuf>,
    /// Case that is not counted, because its data are no fair question; the table tells it (repeatable)
    #[arg(long, value_name = "ID")]
    without: Vec<String>,
    /// Score although cases are still without an answer: these are then no longer blind
    #[arg(long)]
    unfinished: bool,
    /// Where to write the table and the reliability diagram: PATH.md, PATH.json, PATH.svg [default: DIR/scores, in the first folder]
    #[arg(long, short, value_name = "PATH")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(step: &Step, call: &Invocation) -> CliResult {
    match step {
        Step::Make(arguments) => make_cases(arguments, call),
        Step::Answer(arguments) => answer(arguments, call),
        Step::Score(arguments) => score_answers(arguments),
    }
}

/// The near ground's mesh and steps unless others are set: finer than a quick diagnosis', of another scheme, and as far from the exact
/// curve as two correct programs are from each other (0.4 % of the force; with a tolerance of 1e-3 it was 3 %).
const NUMERICS: [&str; 3] =
    ["mesh.preset=standard", "solver.time_scheme=backward_euler", "solver.tolerance=1e-5"];

/// Of the wide ground, whose forces another solver computes, the engine tells no more than what can be seen: by a quick diagnosis'
/// own derivatives.
const DERIVATIVES: [&str; 1] = ["mesh.preset=coarse"];

/// Refuses what would have no effect.
fn check(arguments: &Make) -> Result<(), UsageError> {
    let EngineArguments { set, parameters, mesh, .. } = &arguments.engine;
    let given =
        [("--mesh", mesh.is_some()), ("--set", !set.is_empty()), ("--parameters", !parameters.is_empty())];
    match given.iter().find(|(_, is_given)| *is_given && arguments.ground == Ground::Wide) {
        Some((option, _)) => Err(UsageError(format!(
            "{option} acts on the model, but the cases of --ground wide are computed by an independent solver; leave it \
             out, or add --ground near"
        ))),
        None => Ok(()),
    }
}

fn make_cases(arguments: &Make, call: &Invocation) -> CliResult {
    check(arguments)?;
    let engine = arguments.engine.engine(&[], true, None, &call.stop)?;
    let own = match arguments.ground {
        Ground::Near => &NUMERICS[..],
        Ground::Wide => &DERIVATIVES[..],
    };
    let own = own.iter().map(|s| (*s).to_owned());
    let settings: Vec<String> = own.chain(arguments.engine.settings(engine.wiring())?).collect();
    // Found before hours of making, not after.
    arguments.secret.iter().try_for_each(|file| check_free(file, "--secret"))?;
    let key = arguments.key.clone().unwrap_or_else(|| key_of(&arguments.out));
    let plan = Plan {
        seed: arguments.seed.unwrap_or_else(fresh_seed),
        cases: arguments.cases,
        kinds: &arguments.kinds,
        ground: arguments.ground,
        visible: arguments.visible,
        cycles: arguments.cycles,
        numerics: settings_from(engine.wiring(), &settings)?,
        jobs: arguments.engine.jobs,
        out: &arguments.out,
        key: &key,
    };
    let progress = Progress::of_fit(0);
    let made = make(&engine, &plan, &mut |what| progress.show(0, what));
    progress.finish();
    if engine.is_stopped() {
        return Ok(Ending::Interrupted);
    }
    let Made { secret, replaced } = made?;
    let secret = secret.text();
    // It may tell the seed: it belongs to the key, not to the cases.
    call.keep_as(&key.with_extension("toml"))?;
    say!(
        "wrote {} cases to {}; the encrypted key is in {}, its hash in {}",
        arguments.cases,
        arguments.out.join(CASES).display(),
        key.display(),
        arguments.out.join(SEAL).display()
    );
    if replaced > 0 {
        say!(
            "{replaced} draws could not be computed or depend on the time steps however short, others of their kinds replace them; the key tells which and why"
        );
    }
    match &arguments.secret {
        Some(file) => write_file(file, format!("{secret}\n").as_bytes())?,
        None => say!("what opens the key, told this once: {secret}"),
    }
    Ok(Ending::Complete)
}

/// A seed that nobody chose.
fn fresh_seed() -> u64 {
    use std::hash::BuildHasher as _;
    std::collections::hash_map::RandomState::new().hash_one(std::process::id())
}

/// Folders of the cases, in alphabetical order.
fn cases(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn std::error::Error>> {
    let inside = folder.join(CASES);
    let entries = std::fs::read_dir(&inside)
        .map_err(|e| format!("{} holds no cases: {e}; `challenge make` writes them", inside.display()))?;
    let mut all: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| p.is_dir()).collect();
    all.sort();
    Ok(all)
}

/// Where a folder's key is unless another place is told.
fn key_of(folder: &Path) -> PathBuf {
    folder.with_extension("key.json")
}

/// Where answers are kept, in the folder of the cases.
const ANSWERS: &str = "answers";

/// Where the answer to a case is kept.
fn answer_file(folder: &Path, id: &str) -> PathBuf {
    folder.join(ANSWERS).join(format!("{id}.json"))
}

fn answer(arguments: &Answer, call: &Invocation) -> CliResult {
    call.keep_as(&arguments.folder.join(format!("{ANSWERS}.toml")))?;
    let mut failed = Vec::new();
    for case in cases(&arguments.folder)? {
        let id = case.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let file = answer_file(&arguments.folder, &id);
        if file.exists() {
            continue;
        }
        let scratch = tempfile::tempdir()?;
        let asked = diagnose::Arguments {
            measurements: vec![case.join("P1.csv"), case.join("P2.csv")],
            published: None,
            resume: false,
            quick: arguments.quick,
            verbose: false,
            out: scratch.path().to_owned(),
            cache: arguments.cache.clone(),
            free: vec![],
            bounds: vec![],
            effect: vec![],
            threshold: vec![],
            fix: vec![],
            start: vec![],
            matters: 1.0,
            max_evaluations: arguments.max_evaluations,
            reading: Reading::default(),
            job: JobArguments::default(),
            engine: arguments.engine.clone(),
        };
        let command = std::env::args().collect::<Vec<_>>().join(" ");
        let tests = tests_of(&asked).map_err(Into::into);
        let found = tests.and_then(|tests| diagnosis_of(&asked, tests, command, &call.stop));
        let diagnosis = match found {
            Ok(Some(diagnosis)) => diagnosis,
            Ok(None) => return Ok(Ending::Interrupted),
            Err(wrong) if code_of(wrong.as_ref()) == USAGE => return Err(wrong),
            // One case that cannot be answered keeps no other from it.
            Err(reason) => {
                say!("{id}: no answer: {reason}");
                failed.push(id);
                continue;
            }
        };
        write_file(&file, &json(&file, &diagnosis)?)?;
        say!("{id}: {} ({:.0} s)", diagnosis.verdict.text, diagnosis.seconds);
    }
    if !failed.is_empty() {
        let folder = arguments.folder.display();
        return Err(format!("{folder}: no answer to {}; the others are kept", failed.join(", ")).into());
    }
    Ok(Ending::Complete)
}

/// What opens a key, from its digits or the file that holds them.
fn secret_of(told: &str) -> Result<Secret, Box<dyn std::error::Error>> {
    if let Some(secret) = Secret::of(told) {
        return Ok(secret);
    }
    let bytes = read_input(Path::new(told))
        .map_err(|e| UsageError(format!("--secret {told}: neither 64 hexadecimal digits nor a file: {e}")))?;
    Secret::of(&String::from_utf8_lossy(&bytes))
        .ok_or_else(|| format!("{told} does not hold 64 hexadecimal digits").into())
}

fn score_answers(arguments: &Score) -> CliResult {
    let secrets: Vec<Secret> = arguments.secret.iter().map(|s| secret_of(s)).collect::<Result<_, _>>()?;
    for (option, given) in [("--secret", secrets.len()), ("--key", arguments.key.len())] {
        let (folders, none_needed) = (arguments.folders.len(), option == "--key" && given == 0);
        if given != folders && !none_needed {
            return Err(UsageError(format!(
                "{option}: give one for each folder, in their order: {given} for {folders}"
            ))
            .into());
        }
    }
    // No key is opened before all folders have all their answers.
    if !arguments.unfinished {
        arguments.folders.iter().try_for_each(|folder| check_answers(folder))?;
    }
    let (mut batches, mut scored, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (folder, secret)) in arguments.folders.iter().zip(&secrets).enumerate() {
        let key = arguments.key.get(i).cloned().unwrap_or_else(|| key_of(folder));
        let key = open(&key, folder, secret)?;
        batches.push(Batch::of(&key));
        for case in key.cases {
            if arguments.without.contains(&case.drawn.id) {
                left_out.push(case.drawn.id);
                continue;
            }
            let answer = read_answer(&answer_file(folder, &case.drawn.id))?;
            scored.push((case, answer));
        }
    }
    let first = &arguments.folders[0];
    if left_out.is_empty() && scored.iter().all(|(_, answer)| answer.is_none()) {
        return Err(format!(
            "{} holds no answers; `challenge answer {}` writes them",
            first.join(ANSWERS).display(),
            first.display()
        )
        .into());
    }
    if let Some(unknown) = arguments.without.iter().find(|id| !left_out.contains(id)) {
        return Err(UsageError(format!("--without {unknown}: no case of these folders has this name")).into());
    }
    let own = Table { left_out, ..score(batches, &scored) };
    let table = arguments.with.iter().try_fold(own, |table, file| add(table, file))?;
    let text = markdown(&table);
    say!("{text}");
    let base = arguments.out.clone().unwrap_or_else(|| first.join("scores"));
    write_file(&base.with_extension("md"), text.as_bytes())?;
    let diagram = table.confidence().diagram().to_svg();
    write_file(&base.with_extension("svg"), diagram.as_bytes())?;
    let file = base.with_extension("json");
    write_file(&file, &json(&file, &table)?)?;
    terminal::result(&table)?;
    Ok(Ending::Complete)
}

/// A table with another one that was written before.
fn add(table: Table, file: &Path) -> Result<Table, Box<dyn std::error::Error>> {
    let bytes = read_input(file)?;
    let read: Result<Table, _> = serde_json::from_slice(&bytes);
    let read = read.map_err(|e| format!("{} is no table of `challenge score`: {e}", file.display()))?;
    Ok(read.beside(table).map_err(|e| format!("{}: {e}", file.display()))?)
}

/// Refuses a folder with a case that has no answer.
fn check_answers(folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let ids =
        cases(folder)?.into_iter().map(|c| c.file_name().unwrap_or_default().to_string_lossy().into_owned());
    let missing: Vec<String> = ids.filter(|id| !answer_file(folder, id).exists()).collect();
    let Some(first) = missing.first() else { return Ok(()) };
    let (missing, folder) = (missing.len(), folder.display());
    Err(format!(
        "{missing} cases of {folder} have no answer yet, {first} is one: the key is opened after the last answer; \
         `challenge answer {folder}` writes them, --unfinished opens it all the same"
    )
    .into())
}

/// An answer; none where its file is not there.
fn read_answer(file: &Path) -> Result<Option<Diagnosis>, Box<dyn std::error::Error>> {
    let Ok(bytes) = read_input(file) else { return Ok(None) };
    let read = serde_json::from_slice(&bytes);
    Ok(Some(read.map_err(|e| format!("{} is no diagnosis: {e}; delete it", file.display()))?))
}
