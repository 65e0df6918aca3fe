//! All results in one table, what they say of the population, and the page.

use super::digest::{Answered, BatchAnswer, Curve, DiagnosisAnswer, Fit, FitAnswer, Value, Words};
use super::frame::{self, Frame};
use super::report::{PopulationReport, report};
use super::results::Kind;
use super::{Failure, Plan, Question, Results, StudyError, Unit, page};
use crate::diagnosis::result as diagnosis;
use crate::inference::statistics::Determination;
use crate::output::{json, write_file, write_file_in_parts};
use std::collections::{BTreeSet, HashSet};
use std::hash::Hash;
use std::path::Path;

/// The table, and the same for programs that read columns.
const TABLE: &str = "table.csv";
const COLUMNS: &str = "table.parquet";
/// Specimens whose curves stand on the page; of more, those with the largest chi^2.
const MOST_CURVES: usize = 200;
/// Rows of the table that are put together at a time.
const BLOCK: usize = 1000;

/// One row of the table.
pub struct Row {
    /// What was asked.
    pub unit: Unit,
    /// `done`, `not converged`, `failed` or `missing`.
    pub state: &'static str,
    /// Why it failed.
    pub reason: String,
    /// What was found.
    pub found: Found,
}

/// What a unit found.
pub enum Found {
    /// A fit.
    Fit(Fit),
    /// A verdict.
    Verdict(Verdict),
    /// Nothing yet.
    Nothing,
}

impl Row {
    /// What its fit found; a verdict has none.
    fn values(&self) -> &[Value] {
        match &self.found {
            Found::Fit(fit) => &fit.values,
            _ => &[],
        }
    }
}

/// An answer of `diagnose`.
pub struct Verdict {
    /// Kind of answer, and the effects of one.
    pub answer: String,
    /// The answer itself.
    pub of: diagnosis::Verdict,
    /// Part of the gap that goes.
    pub shrinkage: Option<f64>,
    /// Tests.
    pub curves: Vec<Curve>,
}

/// What `gather` did.
pub struct Gathered {
    /// In words.
    pub text: String,
    /// Files it wrote.
    pub files: Vec<String>,
    /// The population; `batch` has none.
    pub population: Option<PopulationReport>,
}

/// Gathers everything that there is, whether or not the study is finished.
///
/// # Errors
/// When plan or results cannot be read, or the table not written.
pub fn gather(plan: &Plan, out: &Path, difference_percent: f64) -> Result<Gathered, StudyError> {
    if plan.header.question == Question::Batch {
        return gather_sets(plan, out);
    }
    let (rows, vectors) = rows(plan)?;
    let mut report = report(plan.header.question, &rows, difference_percent);
    if vectors.len() > 1 {
        let vectors: Vec<String> = vectors.into_iter().collect();
        report.warnings.push(format!(
            "processors with different vector instructions computed these units ({}): where a table must be repeated to the last \
             bit, take machines of one kind",
            vectors.join(", ")
        ));
    }
    let columns = Columns::of(&rows, plan.header.question);
    write_table(|| rows.chunks(BLOCK).map(|rows| columns.block(rows)), out)?;
    let file = out.join("population.json");
    write_file(&file, &json(&file, &report)?)?;
    write_file(&out.join("study.html"), page::page(plan, &rows, &report).as_bytes())?;
    let mut text = format!("{} of {} units have results", report.done, report.units);
    for value in &report.values {
        text.push_str(&format!("\n{}", page::in_words(value)));
    }
    report.warnings.iter().for_each(|w| text.push_str(&format!("\nwarning: {w}")));
    let files = [TABLE, COLUMNS, "population.json", "study.html"].map(str::to_owned).to_vec();
    Ok(Gathered { text, files, population: Some(report) })
}

/// All units, and the vector instructions that they were computed with.
fn rows(plan: &Plan) -> Result<(Vec<Row>, BTreeSet<String>), StudyError> {
    let results = Results::new(&plan.results());
    let done = results.keys(Kind::Result)?;
    let failed = results.keys(Kind::Failure)?;
    let (mut rows, mut words, mut vectors): (Vec<Row>, _, _) =
        (Vec::new(), Words::default(), BTreeSet::new());
    for unit in plan.units()? {
        let mut unit = unit?;
        // Not needed any more, and there may be a hundred thousand.
        (unit.options, unit.inputs) = (vec![], vec![]);
        let mut row = Row { state: "missing", reason: String::new(), found: Found::Nothing, unit };
        let key = row.unit.key.clone();
        if done.contains(&key) {
            let found = match plan.header.question {
                Question::Identify => results
                    .get::<Answered<FitAnswer>>(Kind::Result, &key)?
                    .map(|a| (a.converged, a.run.vector, Found::Fit(a.answer.digest(&mut words)))),
                _ => {
                    let found = results.get::<Answered<DiagnosisAnswer>>(Kind::Result, &key)?;
                    found.map(|a| (a.converged, a.run.vector, verdict(a.answer)))
                }
            };
            if let Some((converged, vector, found)) = found {
                vectors.insert(vector);
                row.state = if converged { "done" } else { "not converged" };
                row.found = found;
            }
        } else if failed.contains(&key)
            && let Some(failure) = results.get::<Failure>(Kind::Failure, &key)?
        {
            (row.state, row.reason) = ("failed", failure.reason);
        }
        if plan.header.question == Question::Challenge && row.state == "done" {
            keep_answer(plan, &results, &row.unit)?;
        }
        rows.push(row);
        if rows.len().is_multiple_of(2 * MOST_CURVES) {
            forget_curves(&mut rows);
        }
    }
    forget_curves(&mut rows);
    Ok((rows, vectors))
}

/// Where `challenge score` looks for the answer; one that is there stays.
fn keep_answer(plan: &Plan, results: &Results, unit: &Unit) -> Result<(), StudyError> {
    let file = plan.header.table.join("answers").join(format!("{}.json", unit.specimen));
    if file.exists() {
        return Ok(());
    }
    let Some(whole) = results.get::<Answered<serde_json::Value>>(Kind::Result, &unit.key)? else {
        return Ok(());
    };
    let text = serde_json::to_vec_pretty(&whole.answer)
        .map_err(|e| StudyError::File { file: file.clone(), problem: e.to_string() })?;
    Ok(write_file(&file, &text)?)
}

fn verdict(answer: DiagnosisAnswer) -> Found {
    let v = &answer.verdict;
    let kind = serde_json::to_value(v.kind).ok().and_then(|k| k.as_str().map(str::to_owned));
    let kind = kind.unwrap_or_default();
    let named = if v.effects.is_empty() { kind } else { format!("{kind}: {}", v.effects.join(" + ")) };
    Found::Verdict(Verdict {
        answer: named,
        shrinkage: answer.shrinkage.as_ref().and_then(|s| s.value),
        curves: answer.curves(),
        of: answer.verdict,
    })
}

/// Keeps the curves of those that are fitted worst.
fn forget_curves(rows: &mut [Row]) {
    let misfit = |row: &Row| match &row.found {
        Found::Fit(fit) if !fit.curves.is_empty() => Some(fit.reduced_chi_square),
        Found::Verdict(v) if !v.curves.is_empty() => Some(v.of.gap_percent),
        _ => None,
    };
    let mut misfits: Vec<f64> = rows.iter().filter_map(misfit).collect();
    if misfits.len() <= MOST_CURVES {
        return;
    }
    misfits.sort_by(|a, b| b.total_cmp(a));
    let least = misfits[MOST_CURVES - 1];
    // Of those that are fitted as badly as the last that is kept, the first ones.
    let mut equal = misfits[..MOST_CURVES].iter().filter(|m| **m == least).count();
    for row in rows.iter_mut() {
        let Some(misfit) = misfit(row) else { continue };
        if misfit > least || (misfit == least && equal > 0) {
            equal -= usize::from(misfit == least);
            continue;
        }
        match &mut row.found {
            Found::Fit(fit) => fit.curves.clear(),
            Found::Verdict(v) => v.curves.clear(),
            Found::Nothing => {}
        }
    }
}

/// Columns of the table: one row per unit, in the plan's order. Nothing in it depends on where, when or in which order units were
/// computed.
struct Columns<'a> {
    question: Question,
    /// Covariates, and whether they are numbers.
    covariates: Vec<(&'a str, bool)>,
    /// Values with their units.
    symbols: Vec<(&'a str, &'a str)>,
}

impl<'a> Columns<'a> {
    fn of(rows: &'a [Row], question: Question) -> Self {
        let names = in_order_of_appearance(rows.iter().flat_map(|r| r.unit.covariates.keys()));
        let numbers = |name| {
            frame::are_numbers(rows.iter().filter_map(|r| r.unit.covariates.get(name).map(String::as_str)))
        };
        let covariates = names.into_iter().map(|name| (name.as_str(), numbers(name))).collect();
        let values = || rows.iter().flat_map(Row::values);
        let symbols = in_order_of_appearance(values().map(|v| &*v.symbol));
        let unit = |symbol: &str| values().find(|v| *v.symbol == *symbol).map_or("", |v| &*v.unit);
        let symbols = symbols.into_iter().map(|symbol| (symbol, unit(symbol))).collect();
        Self { question, covariates, symbols }
    }

    /// Some rows.
    fn block(&self, rows: &[Row]) -> Frame {
        let mut table = Frame::default();
        let unit = |of: fn(&Unit) -> String| rows.iter().map(move |row| of(&row.unit));
        table.number("unit", rows.iter().map(|row| Some(row.unit.unit as f64)));
        table.text("specimen", unit(|u| u.specimen.clone()));
        table.text("group", unit(|u| u.group.clone().unwrap_or_default()));
        for &(name, numbers) in &self.covariates {
            let cell = |row: &Row| row.unit.covariates.get(name).cloned().unwrap_or_default();
            table.either(name, rows.iter().map(cell), numbers);
        }
        table.text("state", rows.iter().map(|row| row.state.to_owned()));
        table.text("reason", rows.iter().map(|row| row.reason.clone()));
        if self.question == Question::Identify {
            self.add_fits(&mut table, rows)
        } else {
            add_verdicts(&mut table, rows)
        }
        table
    }

    fn add_fits(&self, table: &mut Frame, rows: &[Row]) {
        let fit = |row: &Row, of: fn(&Fit) -> f64| match &row.found {
            Found::Fit(fit) => Some(of(fit)),
            _ => None,
        };
        let mut add =
            |name: &str, of: fn(&Fit) -> f64| table.number(name, rows.iter().map(|row| fit(row, of)));
        add("branches", |f| f.branches as f64);
        add("reduced_chi_square", |f| f.reduced_chi_square);
        add("rms_mN", |f| f.rms_mn);
        for &(symbol, unit) in &self.symbols {
            let value =
                |row: &Row, of: fn(&Value) -> f64| row.values().iter().find(|v| *v.symbol == *symbol).map(of);
            let mut add = |name: String, of: fn(&Value) -> f64| {
                table.number(name, rows.iter().map(|row| value(row, of)))
            };
            let is_plain = unit == "1" || unit.is_empty();
            add(if is_plain { symbol.to_owned() } else { format!("{symbol} [{unit}]") }, |v| v.value);
            add(format!("{symbol} lower"), |v| v.lower);
            add(format!("{symbol} upper"), |v| v.upper);
            add(format!("{symbol} ln_sigma"), |v| v.ln_sigma);
            let known = |row: &Row| {
                row.values().iter().find(|v| *v.symbol == *symbol).map_or("", |v| match v.determination {
                    Determination::Determined => "determined",
                    Determination::Loose => "loose",
                    Determination::Undetermined => "not determined",
                    Determination::Unresolved => "not told apart",
                })
            };
            table.text(format!("{symbol} known"), rows.iter().map(|row| known(row).to_owned()));
        }
    }
}

/// What differs, each once.
pub(super) fn in_order_of_appearance<T: Copy + Eq + Hash>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut seen = HashSet::new();
    all.filter(|one| seen.insert(*one)).collect()
}

fn add_verdicts(table: &mut Frame, rows: &[Row]) {
    let said = |row: &Row, of: fn(&Verdict) -> String| match &row.found {
        Found::Verdict(verdict) => of(verdict),
        _ => String::new(),
    };
    let number = |row: &Row, of: fn(&Verdict) -> Option<f64>| match &row.found {
        Found::Verdict(verdict) => of(verdict),
        _ => None,
    };
    table.text("answer", rows.iter().map(|row| said(row, |v| v.answer.clone())));
    table.number("confidence", rows.iter().map(|row| number(row, |v| Some(v.of.confidence))));
    table.number("gap_percent", rows.iter().map(|row| number(row, |v| Some(v.of.gap_percent))));
    table.number("shrinkage", rows.iter().map(|row| number(row, |v| v.shrinkage)));
    table.text("text", rows.iter().map(|row| said(row, |v| v.of.text.clone())));
}

/// The table of `batch`, row by row, and its curves.
fn gather_sets(plan: &Plan, out: &Path) -> Result<Gathered, StudyError> {
    let results = Results::new(&plan.results());
    let (mut table, mut done) = (String::new(), 0);
    for unit in plan.units()? {
        let unit = unit?;
        let Some(found) = results.get::<Answered<BatchAnswer>>(Kind::Result, &unit.key)? else { continue };
        done += 1;
        let mut lines = found.answer.summary.lines().filter(|l| !l.starts_with('#'));
        let header = lines.next().unwrap_or_default();
        if table.is_empty() {
            table = format!("{header}\n");
        }
        lines.for_each(|line| table.extend([line, "\n"]));
        for (name, text) in &found.answer.curves {
            write_file(&out.join("curves").join(name), text.as_bytes())?;
        }
    }
    // The words of `batch` as they are.
    let columns = Frame::of_csv(&table, &out.join(TABLE))?;
    write_file_in_parts(&out.join(COLUMNS), |out| frame::write_parquet(std::iter::once(columns), out))?;
    write_file(&out.join(TABLE), table.as_bytes())?;
    let text = format!("{done} of {} units have results", plan.header.units);
    let files = [TABLE, COLUMNS, "curves"].map(str::to_owned).to_vec();
    Ok(Gathered { text, files, population: None })
}

fn write_table<B: Iterator<Item = Frame>>(blocks: impl Fn() -> B, out: &Path) -> Result<(), StudyError> {
    write_file_in_parts(&out.join(TABLE), |out| frame::write_csv(blocks(), out))?;
    Ok(write_file_in_parts(&out.join(COLUMNS), |out| frame::write_parquet(blocks(), out))?)
}
