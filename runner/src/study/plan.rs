//! The plan: what is asked of whom, in two files that anybody reads and nobody changes.
//!
//! `plan.json` says what all units share; `units.jsonl` has a line for each, all of the same length, so that a worker finds its own
//! without reading the others.

use super::table::{self, Row};
use super::unit::{Input, program_hash};
use super::{Question, StudyError, Unit};
use crate::output::{json, write_file};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Version of the layout.
pub const SCHEMA: &str = "poropunch.study-plan/1";
const PLAN: &str = "plan.json";
const UNITS: &str = "units.jsonl";

/// What is asked for: the options of `study plan`, or `study.toml`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// Table of specimens, folder of cases, or table of `batch`.
    pub table: PathBuf,
    /// What is asked of each.
    #[serde(default)]
    pub question: Question,
    /// Options of the command.
    #[serde(default)]
    pub options: Vec<String>,
    /// Rows of the table of `batch` in one unit.
    #[serde(default = "rows_per_unit")]
    pub rows_per_unit: usize,
    /// Where results are kept; in the plan's directory where it is not said.
    #[serde(default)]
    pub results: Option<PathBuf>,
}

/// A minute of one-second runs: the start of a process is below a thousandth of it.
pub fn rows_per_unit() -> usize {
    60
}

/// `plan.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Header {
    /// [`SCHEMA`].
    pub schema: String,
    /// What is asked of each unit.
    pub question: Question,
    /// The table, or the folder of cases.
    pub table: PathBuf,
    /// Hash of the program and its FMU.
    pub program: String,
    /// Where results are kept; from the plan's directory.
    pub results: PathBuf,
    /// Number of units.
    pub units: usize,
    /// Bytes of a line of `units.jsonl`.
    pub line_bytes: usize,
}

/// A plan on disk.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Its directory.
    pub directory: PathBuf,
    /// What all units share.
    pub header: Header,
}

impl Asked {
    /// `study.toml`; paths are taken from its directory.
    ///
    /// # Errors
    /// With file, line and field.
    pub fn read(file: &Path) -> Result<Self, StudyError> {
        let bytes = crate::output::read_input(file).map_err(StudyError::io(file))?;
        let text = String::from_utf8_lossy(&bytes);
        let mut asked: Self = toml::from_str(&text).map_err(|e| {
            let before = e.span().map_or(0, |s| s.start);
            let line = text.bytes().take(before).filter(|b| *b == b'\n').count() as u64 + 1;
            let problem = format!(
                "{}; its fields are table, question (identify, diagnose, batch, challenge), options, rows_per_unit, results",
                e.message()
            );
            StudyError::Line { file: file.to_owned(), line, problem }
        })?;
        let base = file.parent().unwrap_or(Path::new(""));
        asked.table = base.join(&asked.table);
        asked.results = asked.results.map(|r| base.join(r));
        Ok(asked)
    }

    /// The units, checked as far as it can be done without computing: every file is there. Which options (`--fmu`) are paths is the
    /// command line's to say.
    ///
    /// # Errors
    /// The first thing that is wrong with the table or with a file that it names.
    pub fn units(&self, program: &str, is_path: &dyn Fn(&str) -> bool) -> Result<Vec<Unit>, StudyError> {
        let own = self.question.defaults().iter().filter(|d| {
            let name = d.split('=').next().unwrap_or(d);
            !self.options.iter().any(|o| o.split('=').next() == Some(name))
        });
        let options: Vec<String> = own.map(|d| (*d).to_owned()).chain(self.options.iter().cloned()).collect();
        let (options, shared) = with_files(options, is_path)?;
        let mut units = match self.question {
            Question::Identify | Question::Diagnose => {
                self.of_rows(table::read(&self.table)?, &options, &shared)?
            }
            Question::Challenge => self.of_rows(table::cases(&self.table)?, &options, &shared)?,
            Question::Batch => self.of_sets(&options, &shared)?,
        };
        for (k, unit) in units.iter_mut().enumerate() {
            unit.unit = k + 1;
            unit.key = Unit::key_of(program, self.question, &unit.options, &unit.inputs);
        }
        Ok(units)
    }

    fn of_rows(&self, rows: Vec<Row>, options: &[String], shared: &[Input]) -> Result<Vec<Unit>, StudyError> {
        let one = |row: Row| -> Result<Unit, StudyError> {
            let measured = row.files.iter().map(|f| Input::measurement(f));
            let measured = measured.collect::<Result<Vec<_>, _>>().map_err(|e| match row.line {
                0 => e,
                line => StudyError::Line { file: self.table.clone(), line, problem: format!("`files`: {e}") },
            })?;
            let set = row.set.iter().map(|s| format!("--set={s}"));
            Ok(Unit {
                unit: 0,
                key: String::new(),
                specimen: row.specimen,
                group: row.group,
                covariates: row.covariates,
                options: options.iter().cloned().chain(set).collect(),
                inputs: measured.into_iter().chain(shared.iter().cloned()).collect(),
                rows: None,
            })
        };
        rows.into_iter().map(one).collect()
    }

    fn of_sets(&self, options: &[String], shared: &[Input]) -> Result<Vec<Unit>, StudyError> {
        let sets = table::Sets::read(&self.table)?;
        let count = sets.count();
        let file = std::path::absolute(&self.table).map_err(StudyError::io(&self.table))?;
        let one = |first: usize| -> Result<Unit, StudyError> {
            let rows = (first, (first + self.rows_per_unit - 1).min(count));
            let table = Input {
                argument: file.to_string_lossy().into_owned(),
                blake3: blake3::hash(&sets.chunk(rows)?).to_hex().to_string(),
                is_option: false,
            };
            Ok(Unit {
                unit: 0,
                key: String::new(),
                specimen: format!("rows {}-{}", rows.0, rows.1),
                group: None,
                covariates: std::collections::BTreeMap::new(),
                options: options.to_vec(),
                inputs: std::iter::once(table).chain(shared.iter().cloned()).collect(),
                rows: Some(rows),
            })
        };
        (1..=count).step_by(self.rows_per_unit.max(1)).map(one).collect()
    }
}

/// Values of options that are paths become absolute, and what is there counts by its bytes.
fn with_files(
    options: Vec<String>,
    is_path: &dyn Fn(&str) -> bool,
) -> Result<(Vec<String>, Vec<Input>), StudyError> {
    let (mut words, mut inputs, mut follows) = (Vec::new(), Vec::new(), false);
    for word in options {
        let (head, value) = match word.split_once('=') {
            Some((name, value)) if is_path(name) => (format!("{name}="), value),
            _ if word.starts_with('-') => {
                follows = is_path(&word);
                words.push(word);
                continue;
            }
            _ if follows => (String::new(), word.as_str()),
            _ => {
                words.push(word);
                continue;
            }
        };
        let input = Input::of_option(Path::new(value))?;
        words.push(format!("{head}{}", input.argument));
        inputs.push(input);
    }
    Ok((words, inputs))
}

impl Plan {
    /// Plans a study into a directory; the same plan again changes nothing. `program` is what made the units' keys.
    ///
    /// # Errors
    /// When something is wrong with what is asked, or another plan is in the directory.
    pub fn make(
        asked: &Asked,
        program: String,
        units: &[Unit],
        directory: &Path,
    ) -> Result<Self, StudyError> {
        let absolute = |p: &Path| std::path::absolute(p).map_err(StudyError::io(p));
        let lines = units.iter().map(serde_json::to_string).collect::<Result<Vec<_>, _>>();
        let lines =
            lines.map_err(|e| StudyError::File { file: directory.join(UNITS), problem: e.to_string() })?;
        let width = lines.iter().map(String::len).max().unwrap_or(0) + 1;
        let text: String =
            lines.iter().map(|l| format!("{l}{}\n", " ".repeat(width - 1 - l.len()))).collect();
        let header = Header {
            schema: SCHEMA.to_owned(),
            question: asked.question,
            table: absolute(&asked.table)?,
            program,
            results: asked.results.as_deref().map_or_else(|| Ok(PathBuf::from("results")), absolute)?,
            units: units.len(),
            line_bytes: width,
        };
        let plan = Self { directory: absolute(directory)?, header };
        if let Ok(there) = Self::open(directory) {
            let same = there.header == plan.header
                && std::fs::read_to_string(directory.join(UNITS)).is_ok_and(|t| t == text);
            if same {
                return Ok(there);
            }
            return Err(StudyError::File {
                file: directory.to_owned(),
                problem: "another plan is in it; choose another directory with --out (with --results, results of equal questions \
                          are shared)"
                    .to_owned(),
            });
        }
        // The header comes last: a plan that has it is whole.
        let file = directory.join(UNITS);
        std::fs::create_dir_all(directory).map_err(StudyError::io(directory))?;
        std::fs::write(&file, text).map_err(StudyError::io(&file))?;
        let file = directory.join(PLAN);
        write_file(&file, &json(&file, &plan.header)?)?;
        Ok(plan)
    }

    /// Opens a plan.
    ///
    /// # Errors
    /// When there is none.
    pub fn open(directory: &Path) -> Result<Self, StudyError> {
        let file = directory.join(PLAN);
        let text = std::fs::read(&file).map_err(|e| StudyError::File {
            file: file.clone(),
            problem: format!("{e}; `runner study plan` writes it"),
        })?;
        let header: Header = serde_json::from_slice(&text)
            .map_err(|e| StudyError::File { file: file.clone(), problem: format!("it is no plan: {e}") })?;
        if header.schema != SCHEMA {
            let problem = format!("it is of schema {}, this program reads {SCHEMA}", header.schema);
            return Err(StudyError::File { file, problem });
        }
        let directory = std::path::absolute(directory).map_err(StudyError::io(directory))?;
        Ok(Self { directory, header })
    }

    /// One unit, found without reading the others.
    ///
    /// # Errors
    /// When there is no such unit.
    pub fn unit(&self, number: usize) -> Result<Unit, StudyError> {
        let count = self.header.units;
        if number == 0 || number > count {
            return Err(StudyError::NoUnit { number, count });
        }
        let file = self.directory.join(UNITS);
        let read = || -> std::io::Result<Vec<u8>> {
            let mut units = File::open(&file)?;
            units.seek(SeekFrom::Start(((number - 1) * self.header.line_bytes) as u64))?;
            let mut line = vec![0; self.header.line_bytes];
            units.read_exact(&mut line)?;
            Ok(line)
        };
        parsed(&file, number as u64, &read().map_err(StudyError::io(&file))?)
    }

    /// All units, one at a time.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn units(&self) -> Result<impl Iterator<Item = Result<Unit, StudyError>> + use<>, StudyError> {
        let file = self.directory.join(UNITS);
        let lines = BufReader::new(File::open(&file).map_err(StudyError::io(&file))?).lines();
        Ok(lines.enumerate().map(move |(k, line)| {
            let line = line.map_err(StudyError::io(&file))?;
            parsed(&file, k as u64 + 1, line.as_bytes())
        }))
    }

    /// Where results are kept.
    pub fn results(&self) -> PathBuf {
        self.directory.join(&self.header.results)
    }

    /// Checks that this program is the one that the plan was made with.
    ///
    /// # Errors
    /// When it is not.
    pub fn check_program(&self) -> Result<(), StudyError> {
        let here = program_hash()?;
        if here == self.header.program {
            return Ok(());
        }
        let short = |hash: &str| hash.chars().take(8).collect();
        Err(StudyError::OtherProgram { planned: short(&self.header.program), here: short(&here) })
    }
}

fn parsed(file: &Path, line: u64, text: &[u8]) -> Result<Unit, StudyError> {
    serde_json::from_slice(text).map_err(|e| StudyError::Line {
        file: file.to_owned(),
        line,
        problem: format!("{e}; plan again"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned(d: &Path) -> (Asked, Vec<Unit>) {
        for name in ["a.csv", "longer_name.csv"] {
            std::fs::write(d.join(name), name).unwrap();
        }
        std::fs::write(d.join("t.csv"), "specimen,files,group\na,a.csv,x\nb,longer_name.csv,y\n").unwrap();
        let asked = Asked { table: d.join("t.csv"), ..Asked::default() };
        let units = asked.units("program", &|_| false).unwrap();
        (asked, units)
    }

    #[test]
    fn every_unit_is_found_by_its_number() {
        let d = tempfile::tempdir().unwrap();
        let (asked, units) = planned(d.path());
        let directory = d.path().join("study");
        let plan = Plan::make(&asked, program_hash().unwrap(), &units, &directory).unwrap();
        assert_eq!(plan, Plan::open(&directory).unwrap());
        assert_eq!(plan.units().unwrap().collect::<Result<Vec<_>, _>>().unwrap(), units);
        for unit in &units {
            assert_eq!(plan.unit(unit.unit).unwrap(), *unit);
            unit.check_inputs().unwrap();
        }
        assert!(plan.unit(0).is_err() && plan.unit(3).is_err());
        // The same again is no other plan; another one is refused.
        assert_eq!(Plan::make(&asked, program_hash().unwrap(), &units, &directory).unwrap(), plan);
        let error =
            Plan::make(&asked, program_hash().unwrap(), &units[..1], &directory).unwrap_err().to_string();
        assert!(error.contains("another plan"), "{error}");
        std::fs::write(d.path().join("a.csv"), "changed").unwrap();
        assert!(matches!(units[0].check_inputs(), Err(StudyError::Changed { .. })));
    }

    #[test]
    fn a_file_of_an_option_is_part_of_the_question() {
        let d = tempfile::tempdir().unwrap();
        let (asked, units) = planned(d.path());
        let job = d.path().join("job.toml");
        std::fs::write(&job, "x").unwrap();
        let with = || {
            let options = vec!["--job".to_owned(), job.to_string_lossy().into_owned()];
            Asked { options, ..asked.clone() }.units("program", &|name| name == "--job").unwrap()
        };
        let before = with();
        assert_ne!(before[0].key, units[0].key);
        std::fs::write(&job, "y").unwrap();
        assert_ne!(with()[0].key, before[0].key);
    }

    #[test]
    fn study_files_are_refused_with_line_and_fields() {
        let d = tempfile::tempdir().unwrap();
        let file = d.path().join("study.toml");
        std::fs::write(&file, "table = \"t.csv\"\nqestion = \"identify\"\n").unwrap();
        let error = Asked::read(&file).unwrap_err().to_string();
        assert!(
            error.contains("line 2") && error.contains("qestion") && error.contains("rows_per_unit"),
            "{error}"
        );
        std::fs::write(&file, "table = \"t.csv\"\nquestion = \"diagnose\"\noptions = [\"--quick\"]\n")
            .unwrap();
        let asked = Asked::read(&file).unwrap();
        assert_eq!((asked.question, asked.table), (Question::Diagnose, d.path().join("t.csv")));
    }
}
