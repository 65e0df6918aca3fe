//! One unit of work: the command that answers it runs as a process of its own, in a directory on the node's own disk.
//!
//! A process of its own: what a user would type gives the same answer; a model that crashes takes nobody with it; memory is given
//! back. Its run cache stays in that directory and goes with it, so that only the answer reaches the shared file system.

use super::results::{Kind, Provenance, SCHEMA, host};
use super::table::Sets;
use super::{Failure, Plan, Question, Results, StudyError, Unit, UnitResult};
use crate::exit_code;
use crate::processor::vector_instructions;
use nix::sys::resource::{UsageWho, getrusage};
use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How a unit ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Ended {
    /// Its result was there already.
    Already,
    /// It failed earlier, with this reason; `--again` tries again.
    FailedBefore(String),
    /// Somebody else works on it.
    Elsewhere,
    /// It has its result now.
    Done {
        /// The fit converged.
        converged: bool,
    },
    /// It failed, with this reason.
    Failed(String),
    /// It was stopped, and nothing is left of it.
    Stopped,
}

/// Works on units of one plan.
#[derive(Debug)]
pub struct Worker<'a> {
    plan: &'a Plan,
    results: Results,
    stop: &'a AtomicBool,
    /// FMU instances at a time of one unit.
    pub jobs: usize,
    /// Failed units are tried again.
    pub again: bool,
}

/// Set for the command of a unit: it ends with its worker.
pub const WORKER: &str = "POROPUNCH_STUDY_WORKER";

/// Ends this process when the worker that started it ends, however that ends; called first by the command of a unit.
pub fn follow_worker() {
    let Some(worker) = std::env::var(WORKER).ok().and_then(|w| w.parse::<i32>().ok()) else { return };
    #[cfg(target_os = "linux")]
    let _ = nix::sys::prctl::set_pdeathsig(nix::sys::signal::Signal::SIGKILL);
    // It may have ended before that was asked for.
    if nix::unistd::getppid().as_raw() != worker {
        std::process::exit(i32::from(exit_code::STOPPED));
    }
}

impl<'a> Worker<'a> {
    /// A worker on a plan that this program made.
    ///
    /// # Errors
    /// When this program is not the plan's.
    pub fn new(plan: &'a Plan, jobs: usize, again: bool, stop: &'a AtomicBool) -> Result<Self, StudyError> {
        plan.check_program()?;
        Ok(Self { plan, results: Results::new(&plan.results()), stop, jobs, again })
    }

    /// Does a unit, unless it has its result; any number of times, anywhere.
    ///
    /// # Errors
    /// When files cannot be read or written: nothing is left of the unit then, and it can be done again.
    pub fn work(&self, unit: &Unit) -> Result<Ended, StudyError> {
        let started = Instant::now();
        if self.results.has(Kind::Result, &unit.key)? {
            return Ok(Ended::Already);
        }
        if self.again {
            self.results.forget_failure(&unit.key)?;
        } else if let Some(failure) = self.results.get::<Failure>(Kind::Failure, &unit.key)? {
            return Ok(Ended::FailedBefore(failure.reason));
        }
        unit.check_inputs()?;
        let mut claim = self.results.claim(&unit.key);
        let scratch = tempfile::Builder::new().prefix("poropunch-study-").tempdir();
        let scratch = scratch.map_err(StudyError::io(&std::env::temp_dir()))?;
        let began = Instant::now();
        let mut child = self.start(unit, scratch.path())?;
        let Some(status) = self.wait(&mut child, || claim.touch())? else { return Ok(Ended::Stopped) };
        let seconds = began.elapsed().as_secs_f64();
        match verdict(status) {
            Verdict::Stopped => Ok(Ended::Stopped),
            Verdict::Failed(what) => {
                let said = std::fs::read_to_string(scratch.path().join(MESSAGES)).unwrap_or_default();
                self.fail(unit, status.code(), &complaint(&said).unwrap_or(what))
            }
            Verdict::Answered { converged } => {
                let answer = answer(self.plan.header.question, scratch.path())?;
                let whole = started.elapsed().as_secs_f64();
                let run = self.provenance(whole, whole - seconds);
                let question = self.plan.header.question;
                let (schema, key) = (SCHEMA.to_owned(), unit.key.clone());
                let result = UnitResult { schema, key, question, converged, run, answer };
                self.results.publish(Kind::Result, &unit.key, &result)?;
                Ok(Ended::Done { converged })
            }
        }
    }

    fn start(&self, unit: &Unit, scratch: &Path) -> Result<Child, StudyError> {
        let program = std::env::current_exe().map_err(StudyError::io(Path::new("the running program")))?;
        let question = self.plan.header.question;
        let mut command = Command::new(&program);
        command.arg(question.command()).args(&unit.options).arg("--out").arg(scratch.join(OUT));
        if question != Question::Batch {
            command.arg("--cache").arg(scratch.join("cache"));
        }
        command.args(["--jobs", &self.jobs.to_string(), "--progress", "none", "--"]);
        for input in unit.inputs.iter().filter(|i| !i.is_option) {
            match unit.rows {
                None => command.arg(&input.argument),
                Some(rows) => {
                    let chunk = Sets::read(Path::new(&input.argument))?.chunk(rows)?;
                    if blake3::hash(&chunk).to_hex().as_str() != input.blake3 {
                        return Err(StudyError::Changed { file: (&input.argument).into() });
                    }
                    let file = scratch.join("sets.csv");
                    std::fs::write(&file, chunk).map_err(StudyError::io(&file))?;
                    command.arg(file)
                }
            };
        }
        let messages = scratch.join(MESSAGES);
        let messages = File::create(&messages).map_err(StudyError::io(&messages))?;
        command.env(WORKER, std::process::id().to_string());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(messages);
        command.spawn().map_err(StudyError::io(&program))
    }

    /// Waits for its end; `None` when this worker is stopped, and the command with it.
    fn wait(&self, child: &mut Child, mut meanwhile: impl FnMut()) -> Result<Option<ExitStatus>, StudyError> {
        let failed = StudyError::io;
        let command = Path::new("the command of a unit");
        loop {
            if let Some(status) = child.try_wait().map_err(failed(command))? {
                return Ok(Some(status).filter(|_| !self.is_stopped()));
            }
            if self.is_stopped() {
                let _ = child.kill();
                child.wait().map_err(failed(command))?;
                return Ok(None);
            }
            meanwhile();
            // A thousandth of a unit of ten seconds.
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn fail(&self, unit: &Unit, exit_code: Option<i32>, reason: &str) -> Result<Ended, StudyError> {
        let failure = Failure {
            schema: SCHEMA.to_owned(),
            key: unit.key.clone(),
            exit_code,
            reason: reason.to_owned(),
            host: host(),
        };
        self.results.publish(Kind::Failure, &unit.key, &failure)?;
        Ok(Ended::Failed(failure.reason))
    }

    fn provenance(&self, seconds: f64, overhead_seconds: f64) -> Provenance {
        // In kilobytes on Linux.
        let memory = getrusage(UsageWho::RUSAGE_CHILDREN).map_or(0.0, |u| u.max_rss() as f64 / 1024.0);
        let (host, vector, jobs) = (host(), vector_instructions().to_owned(), self.jobs);
        Provenance { host, vector, jobs, seconds, overhead_seconds, memory_mb: memory }
    }

    /// The local engine: does all these units, so many at a time, and tells each one's end. What another process works on is left to
    /// it as long as it does.
    ///
    /// # Errors
    /// The first error; units under way are ended first.
    pub fn work_all(
        &self,
        numbers: &[usize],
        at_a_time: usize,
        told: &(dyn Fn(&Unit, &Ended) + Sync),
    ) -> Result<(), StudyError> {
        let mut left = numbers.to_vec();
        loop {
            let (next, elsewhere) = (AtomicUsize::new(0), std::sync::Mutex::new(Vec::new()));
            let (left_ref, elsewhere_ref, next_ref) = (&left, &elsewhere, &next);
            let one_thread = || -> Result<(), StudyError> {
                while !self.is_stopped()
                    && let Some(&number) = left_ref.get(next_ref.fetch_add(1, Ordering::Relaxed))
                {
                    let unit = self.plan.unit(number)?;
                    let is_elsewhere = self.results.is_running(&unit.key);
                    let ended = if is_elsewhere { Ended::Elsewhere } else { self.work(&unit)? };
                    if is_elsewhere {
                        elsewhere_ref.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(number);
                    } else {
                        told(&unit, &ended);
                    }
                }
                Ok(())
            };
            std::thread::scope(|scope| {
                let threads: Vec<_> = (0..at_a_time.max(1)).map(|_| scope.spawn(one_thread)).collect();
                threads
                    .into_iter()
                    .try_for_each(|t| t.join().unwrap_or_else(|p| std::panic::resume_unwind(p)))
            })?;
            left = elsewhere.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
            if left.is_empty() || self.is_stopped() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(500));
        }
    }
}

const OUT: &str = "out";
const MESSAGES: &str = "messages.txt";

/// What the end of a command says about the unit.
#[derive(Debug, PartialEq)]
enum Verdict {
    Answered { converged: bool },
    Failed(String),
    Stopped,
}

fn verdict(status: ExitStatus) -> Verdict {
    use nix::sys::signal::Signal;
    const FAULTS: [Signal; 5] =
        [Signal::SIGSEGV, Signal::SIGABRT, Signal::SIGBUS, Signal::SIGFPE, Signal::SIGILL];
    match (status.code(), status.signal()) {
        (Some(0), _) => Verdict::Answered { converged: true },
        (Some(code), _) if code == i32::from(exit_code::NOT_CONVERGED) => {
            Verdict::Answered { converged: false }
        }
        (Some(code), _) if code == i32::from(exit_code::STOPPED) => Verdict::Stopped,
        (Some(code), _) => Verdict::Failed(format!("it ended with the exit code {code} and said nothing")),
        // A fault is the program's own; any other signal, and the kernel's for want of memory, came from outside.
        (None, Some(signal)) => match FAULTS.iter().find(|f| **f as i32 == signal) {
            Some(fault) => Verdict::Failed(format!("it crashed ({fault})")),
            None => Verdict::Stopped,
        },
        (None, None) => Verdict::Stopped,
    }
}

/// The error message, in one line.
fn complaint(said: &str) -> Option<String> {
    let at = said.rfind("error: ")?;
    Some(said[at + "error: ".len()..].split_whitespace().collect::<Vec<_>>().join(" "))
}

/// What the command wrote.
fn answer(question: Question, scratch: &Path) -> Result<serde_json::Value, StudyError> {
    let folder = scratch.join(OUT);
    let file = folder.join(question.answer_file());
    let text = std::fs::read_to_string(&file).map_err(StudyError::io(&file))?;
    if question != Question::Batch {
        let read = serde_json::from_slice(text.as_bytes());
        return read.map_err(|e| StudyError::File { file, problem: e.to_string() });
    }
    let mut curves = BTreeMap::new();
    for entry in std::fs::read_dir(&folder).map_err(StudyError::io(&folder))?.flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if name.ends_with(".csv") && name != question.answer_file() {
            curves.insert(name, std::fs::read_to_string(&path).map_err(StudyError::io(&path))?);
        }
    }
    Ok(serde_json::json!({ "summary": text, "curves": curves }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_answers_and_the_programs_own_verdicts_count() {
        let code = |c: i32| verdict(ExitStatus::from_raw(c << 8));
        assert_eq!(code(0), Verdict::Answered { converged: true });
        assert_eq!(code(3), Verdict::Answered { converged: false });
        assert_eq!(code(130), Verdict::Stopped);
        assert!(matches!(code(1), Verdict::Failed(_)) && matches!(code(4), Verdict::Failed(_)));
        let signal = |s: i32| verdict(ExitStatus::from_raw(s));
        for outside in [9, 15, 2, 1] {
            assert_eq!(signal(outside), Verdict::Stopped);
        }
        assert!(matches!(signal(11), Verdict::Failed(why) if why.contains("SIGSEGV")));
    }

    #[test]
    fn the_complaint_is_the_last_error() {
        let said = "note: x\nerror: P2.csv: no column\n  for the force\n";
        assert_eq!(complaint(said).as_deref(), Some("P2.csv: no column for the force"));
        assert_eq!(complaint("note: x"), None);
    }
}
