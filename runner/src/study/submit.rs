//! Submission to the engine that the site has: a script that it runs, or the command that takes one. The program schedules nothing
//! across machines itself.

use super::results::Kind;
use super::status::missing;
use super::{Plan, Results, StudyError, UnitResult, hyperqueue, ranges};
use clap::ValueEnum;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What runs the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Engine {
    /// This machine: as many units at a time as it has cores
    #[default]
    Local,
    /// A Slurm array (sbatch)
    Slurm,
    /// A HyperQueue array (hq submit)
    Hyperqueue,
    /// GNU parallel, on this machine or on those in its --sshlogin
    Parallel,
}

/// Slurm's default MaxArraySize is 1001, and indices lie below it; a scheduler is not made for more and shorter tasks either.
const MOST_TASKS: usize = 1000;
/// A Slurm task costs about two seconds of its slot (README.md): 2 % of this.
const LEAST_TASK_S: f64 = 120.0;
/// Tasks that are kept however short they are, so that many cores have work.
const KEPT_TASKS: usize = 100;
/// Results that are looked at for time and memory.
const LOOKED_AT: usize = 20;

/// What a task asks its engine for.
#[derive(Debug, Clone, PartialEq)]
pub struct Needs {
    /// Cores.
    pub cores: usize,
    /// Memory (MB).
    pub memory_mb: u64,
    /// Time (s).
    pub seconds: u64,
}

/// A submission.
#[derive(Debug, Clone, PartialEq)]
pub struct Submission {
    /// Engine.
    pub engine: Engine,
    /// Units of one task.
    pub per_task: usize,
    /// Tasks, from 1, that have a unit without a result.
    pub tasks: Vec<usize>,
    /// What each needs.
    pub needs: Needs,
    /// Options for the engine.
    pub options: Vec<String>,
    /// The worker's options.
    pub work: Vec<String>,
}

/// Units of a task, from its index.
pub fn units_of_task(task: usize, per_task: usize, count: usize) -> std::ops::RangeInclusive<usize> {
    let per_task = per_task.max(1);
    (task.saturating_sub(1) * per_task + 1)..=(task * per_task).min(count)
}

/// Units of one task: so many that there are not too many tasks, and that a scheduler's own time is small against a task's.
pub fn per_task(engine: Engine, units: usize, seconds: f64) -> usize {
    let fewest = units.div_ceil(MOST_TASKS).max(1);
    if engine != Engine::Slurm {
        return fewest;
    }
    let wanted = (LEAST_TASK_S / seconds.max(1e-3)).ceil() as usize;
    wanted.clamp(fewest, fewest.max(units.div_ceil(KEPT_TASKS)))
}

/// Tasks that have a unit without a result.
///
/// # Errors
/// When plan or store cannot be read.
pub fn tasks(plan: &Plan, per_task: usize, again: bool) -> Result<Vec<usize>, StudyError> {
    let mut tasks: Vec<usize> =
        missing(plan, again)?.into_iter().map(|unit| unit.div_ceil(per_task.max(1))).collect();
    tasks.dedup();
    Ok(tasks)
}

/// Time (s) and memory (MB) of the slowest and largest of some units that are done.
///
/// # Errors
/// When plan or store cannot be read.
pub fn measured(plan: &Plan) -> Result<Option<(f64, f64)>, StudyError> {
    let results = Results::new(&plan.results());
    let mut keys: Vec<String> = results.keys(Kind::Result)?.into_iter().collect();
    keys.sort();
    let mut most: Option<(f64, f64)> = None;
    for key in keys.iter().take(LOOKED_AT) {
        if let Some(UnitResult { run, .. }) = results.get(Kind::Result, key)? {
            let (seconds, memory) = most.unwrap_or_default();
            most = Some((seconds.max(run.seconds), memory.max(run.memory_mb)));
        }
    }
    Ok(most)
}

impl Needs {
    /// From what units took: three times the slowest, as fits differ, and half as much memory again.
    pub fn from_measured((seconds, memory_mb): (f64, f64), per_task: usize, cores: usize) -> Self {
        let seconds = 60 + (3.0 * seconds * per_task as f64).ceil() as u64;
        Self { cores, memory_mb: 256 + (1.5 * memory_mb).ceil() as u64, seconds }
    }

    fn clock(&self) -> String {
        let s = self.seconds;
        format!("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
    }
}

impl Submission {
    /// The script.
    ///
    /// # Errors
    /// When this program's place is not known.
    pub fn script(&self, plan: &Plan) -> Result<String, StudyError> {
        let program = std::env::current_exe().map_err(StudyError::io(Path::new("the running program")))?;
        let folder = logs(plan);
        let name = plan.directory.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (list, needs) = (ranges::written(&self.tasks), &self.needs);
        let mut words: Vec<String> = vec![program.to_string_lossy().into_owned()];
        words.extend(["study", "work"].map(str::to_owned));
        words.push(plan.directory.to_string_lossy().into_owned());
        words.extend(["--per-task".to_owned(), self.per_task.to_string()]);
        words.extend(["--jobs".to_owned(), needs.cores.to_string()]);
        words.extend(self.work.iter().cloned());
        let worker = words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
        let logs = folder.display();
        let mut text = "#!/bin/bash\n".to_owned();
        match self.engine {
            Engine::Slurm => {
                let given = [
                    format!("--job-name={name}"),
                    format!("--array={list}"),
                    format!("--cpus-per-task={}", needs.cores),
                    format!("--mem={}M", needs.memory_mb),
                    format!("--time={}", needs.clock()),
                    format!("--output={logs}/%A_%a.txt"),
                    "--open-mode=append".to_owned(),
                    "--requeue".to_owned(),
                ];
                for option in given.iter().chain(&self.options) {
                    let _ = writeln!(text, "#SBATCH {option}");
                }
                let _ = writeln!(text, "exec {worker}");
            }
            Engine::Hyperqueue if hyperqueue::has_command() => {
                text.push_str(&hyperqueue::by_command(self, &name, &list, &words, &folder));
            }
            Engine::Hyperqueue => text.push_str(&hyperqueue::by_python(self, &name, &words, &folder)),
            Engine::Parallel | Engine::Local => {
                let slots = self.slots();
                let options = self.options.iter().map(|o| format!(" {}", quoted(o))).collect::<String>();
                let runs = list.split(',').map(|run| match run.split_once('-') {
                    Some((a, b)) => format!("seq {a} {b}"),
                    None => format!("echo {run}"),
                });
                let _ = writeln!(
                    text,
                    "{{ {}; }} | \\\n  parallel --jobs {slots} --halt never --joblog '{logs}/parallel.txt'{options} \\\n  {worker} \
                     --task {{}}",
                    runs.collect::<Vec<_>>().join("; ")
                );
            }
        }
        Ok(text)
    }

    /// Tasks at a time on this machine.
    fn slots(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, Into::into);
        (cores / self.needs.cores.max(1)).max(1)
    }

    /// Hands the script over; what the engine said, its job's number among it.
    ///
    /// # Errors
    /// When the engine is not there or refuses.
    pub fn submit(&self, plan: &Plan) -> Result<String, StudyError> {
        let folder = logs(plan);
        std::fs::create_dir_all(&folder).map_err(StudyError::io(&folder))?;
        let script = self.script(plan)?;
        let (command, arguments): (&str, &[&str]) = match self.engine {
            Engine::Slurm => ("sbatch", &["--parsable"]),
            _ => ("bash", &["-s"]),
        };
        let failed = |problem: String| StudyError::Engine { command: command.to_owned(), problem };
        let missing = |e: std::io::Error| {
            failed(format!("cannot be run: {e}; is the engine here? --dry-run shows the script"))
        };
        let mut child = Command::new(command)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(missing)?;
        if let Some(mut input) = child.stdin.take() {
            input.write_all(script.as_bytes()).map_err(|e| failed(e.to_string()))?;
        }
        let output = child.wait_with_output().map_err(|e| failed(e.to_string()))?;
        let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        // GNU parallel's exit code is the number of tasks that failed, whose reasons are kept.
        if !output.status.success() && (self.engine != Engine::Parallel || output.status.code() >= Some(102))
        {
            return Err(failed(format!("failed ({}): {}", output.status, said(&output.stderr))));
        }
        Ok(said(&output.stdout))
    }
}

fn logs(plan: &Plan) -> PathBuf {
    plan.directory.join("logs")
}

/// A word as a shell takes it.
pub(super) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_./=:,+-^%@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Question;
    use crate::study::plan::Header;

    #[test]
    fn tasks_hold_all_units_once() {
        for (count, k) in [(10, 3), (9, 3), (1, 1), (1001, 2)] {
            let tasks = count_tasks(count, k);
            let all: Vec<usize> = (1..=tasks).flat_map(|t| units_of_task(t, k, count)).collect();
            assert_eq!(all, (1..=count).collect::<Vec<_>>());
        }
        assert!(units_of_task(9, 3, 10).is_empty());
        let hyperqueue = |units| per_task(Engine::Hyperqueue, units, 10.0);
        assert_eq!((hyperqueue(1000), hyperqueue(1001), hyperqueue(100_000)), (1, 2, 100));
        // Two seconds of Slurm's beside ten of a unit are too many, unless there are few units.
        let slurm = |units, seconds| per_task(Engine::Slurm, units, seconds);
        assert_eq!((slurm(5000, 10.0), slurm(300, 10.0), slurm(5000, 600.0)), (12, 3, 5));
    }

    fn count_tasks(count: usize, k: usize) -> usize {
        count.div_ceil(k)
    }

    #[test]
    fn scripts_say_what_each_engine_needs() {
        let plan = Plan {
            directory: "/shared/my study".into(),
            header: Header {
                schema: String::new(),
                question: Question::Identify,
                table: "t.csv".into(),
                program: String::new(),
                results: "results".into(),
                units: 40,
                line_bytes: 100,
            },
        };
        let needs = Needs::from_measured((20.0, 100.0), 2, 1);
        assert_eq!((needs.seconds, needs.memory_mb), (180, 406));
        let of = |engine| {
            let options = vec!["--partition=short".to_owned()];
            let s = Submission {
                engine,
                per_task: 2,
                tasks: vec![1, 2, 3, 7],
                needs: needs.clone(),
                options,
                work: vec![],
            };
            s.script(&plan).unwrap()
        };
        let slurm = of(Engine::Slurm);
        for part in [
            "#SBATCH --array=1-3,7\n",
            "--mem=406M",
            "--time=00:03:00",
            "--partition=short",
            "--requeue",
            "study work '/shared/my study' --per-task 2 --jobs 1\n",
        ] {
            assert!(slurm.contains(part), "{part}: {slurm}");
        }
        let words = ["/bin/runner", "study", "work", "/shared/my study"].map(str::to_owned);
        let logs = Path::new("/shared/my study/logs");
        let asked = Submission {
            engine: Engine::Hyperqueue,
            per_task: 2,
            tasks: vec![1, 2, 3, 7],
            needs: needs.clone(),
            options: vec![],
            work: vec![],
        };
        let queue = hyperqueue::by_command(&asked, "my study", "1-3,7", &words, logs);
        assert!(queue.contains("hq submit") && queue.contains("--array 1-3,7 --cpus 1"), "{queue}");
        assert!(queue.ends_with("/bin/runner study work '/shared/my study'\n"), "{queue}");
        let python = hyperqueue::by_python(&asked, "my study", &words, logs);
        for part in
            ["Job(name=\"my study\"", "cpus=1", "seconds=180", "in [1,2,3,7]:", "\"/shared/my study\"]"]
        {
            assert!(python.contains(part), "{part}: {python}");
        }
        let parallel = of(Engine::Parallel);
        assert!(parallel.contains("{ seq 1 3; echo 7; }") && parallel.contains("--task {}"), "{parallel}");
    }
}
