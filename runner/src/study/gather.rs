//! All results in one table, what they say of the population, and the page.

use super::digest::{Answered, BatchAnswer, Curve, DiagnosisAnswer, Fit, FitAnswer, Value};
use super::population::{Interval, Observed, Population};
use super::results::Kind;
use super::{Failure, Plan, Question, Results, StudyError, Unit, page};
use crate::inference::statistics::Determination;
use crate::output::{json, write_file};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::BTreeMap;
use std::path::Path;

/// Version of the layout.
pub const SCHEMA: &str = "poropunch.study-population/1";
/// Specimens whose curves stand on the page; of more, those with the largest chi^2.
const MOST_CURVES: usize = 200;
/// Covariates with so few values are groupings, too: rigs, operators, days.
const MOST_KINDS: usize = 8;

/// `population.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PopulationReport {
    /// [`SCHEMA`].
    pub schema: String,
    /// What was asked.
    pub question: Question,
    /// Units of the plan.
    pub units: usize,
    /// Those with a result.
    pub done: usize,
    /// Difference that `specimens_needed` is about (%).
    pub difference_percent: f64,
    /// Values of the specimens' material, those that most specimens determine.
    pub values: Vec<ValueReport>,
    /// Answers of `diagnose` by group and by covariate.
    pub answers: Vec<Answers>,
    /// Specimens that are far from their group.
    pub outliers: Vec<Outlier>,
    /// What a reader must know.
    pub warnings: Vec<String>,
}

/// One value in the population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ValueReport {
    /// Symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Geometric mean of each group.
    pub groups: Vec<GroupMean>,
    /// Standard deviation of ln(value) between specimens of one group.
    pub spread: Interval,
    /// Standard deviation of ln(value) within a specimen's own likelihood, root mean square.
    pub own_sigma: f64,
    /// Specimens that were left out, as their data do not determine it or have another number of branches.
    pub left_out: usize,
    /// Ratios of groups.
    pub differences: Vec<Difference>,
    /// Specimens in each of two groups that find the difference with a power of 80 % at a level of 5 %.
    pub specimens_needed: Option<usize>,
}

/// A group's mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroupMean {
    /// Group; empty where the table has none.
    pub group: String,
    /// Specimens.
    pub specimens: usize,
    /// Geometric mean.
    pub mean: Option<Interval>,
}

/// How many times larger a group's mean is than another's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Difference {
    /// The one.
    pub of: String,
    /// The other.
    pub over: String,
    /// Ratio.
    pub ratio: Interval,
}

/// Answers of `diagnose` in one group of specimens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Answers {
    /// What they are grouped by: `group` or a covariate.
    pub by: String,
    /// Its value.
    pub group: String,
    /// Number of specimens with each answer.
    pub counts: BTreeMap<String, usize>,
}

/// A specimen that is far from its group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Outlier {
    /// Specimen.
    pub specimen: String,
    /// In which value.
    pub symbol: String,
    /// Distance from its group's mean, in standard deviations (spread and its own uncertainty).
    pub distance: f64,
}

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
    Verdict {
        /// Kind of answer, and the effects of one.
        answer: String,
        /// In words.
        text: String,
        /// Probability that it is right.
        confidence: f64,
        /// Size of the gap (%).
        gap_percent: f64,
        /// Part of the gap that goes.
        shrinkage: Option<f64>,
        /// Tests.
        curves: Vec<Curve>,
    },
    /// Nothing yet.
    Nothing,
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
    let rows = rows(plan)?;
    let report = report(plan.header.question, &rows, difference_percent);
    write_file(&out.join("table.csv"), table(&rows, plan)?.as_bytes())?;
    let file = out.join("population.json");
    write_file(&file, &json(&file, &report)?)?;
    write_file(&out.join("study.html"), page::page(plan, &rows, &report).as_bytes())?;
    let mut text = format!("{} of {} units have results", report.done, report.units);
    for value in &report.values {
        text.push_str(&format!("\n{}", page::in_words(value)));
    }
    report.warnings.iter().for_each(|w| text.push_str(&format!("\nwarning: {w}")));
    let files = ["table.csv", "population.json", "study.html"].map(str::to_owned).to_vec();
    Ok(Gathered { text, files, population: Some(report) })
}

fn rows(plan: &Plan) -> Result<Vec<Row>, StudyError> {
    let results = Results::new(&plan.results());
    let done = results.keys(Kind::Result)?;
    let failed = results.keys(Kind::Failure)?;
    let mut rows: Vec<Row> = Vec::new();
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
                    .map(|a| (a.converged, Found::Fit(a.answer.digest()))),
                _ => {
                    let found = results.get::<Answered<DiagnosisAnswer>>(Kind::Result, &key)?;
                    found.map(|a| (a.converged, verdict(&a.answer)))
                }
            };
            if let Some((converged, found)) = found {
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
    Ok(rows)
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

fn verdict(answer: &DiagnosisAnswer) -> Found {
    let v = &answer.verdict;
    let kind = serde_json::to_value(v.kind).ok().and_then(|k| k.as_str().map(str::to_owned));
    let kind = kind.unwrap_or_default();
    let named = if v.effects.is_empty() { kind } else { format!("{kind}: {}", v.effects.join(" + ")) };
    Found::Verdict {
        answer: named,
        text: v.text.clone(),
        confidence: v.confidence,
        gap_percent: v.gap_percent,
        shrinkage: answer.shrinkage.as_ref().and_then(|s| s.value),
        curves: answer.curves(),
    }
}

/// Keeps the curves of those that are fitted worst.
fn forget_curves(rows: &mut [Row]) {
    let misfit = |row: &Row| match &row.found {
        Found::Fit(fit) if !fit.curves.is_empty() => Some(fit.reduced_chi_square),
        Found::Verdict { gap_percent, curves, .. } if !curves.is_empty() => Some(*gap_percent),
        _ => None,
    };
    let mut misfits: Vec<f64> = rows.iter().filter_map(misfit).collect();
    if misfits.len() <= MOST_CURVES {
        return;
    }
    misfits.sort_by(|a, b| b.total_cmp(a));
    let least = misfits[MOST_CURVES - 1];
    for row in rows.iter_mut().filter(|row| misfit(row).is_some_and(|m| m < least)) {
        match &mut row.found {
            Found::Fit(fit) => fit.curves.clear(),
            Found::Verdict { curves, .. } => curves.clear(),
            Found::Nothing => {}
        }
    }
}

/// The table: one row per unit, in the plan's order. Nothing in it depends on where, when or in which order units were computed.
fn table(rows: &[Row], plan: &Plan) -> Result<String, StudyError> {
    let mut covariates: Vec<&String> = Vec::new();
    let mut symbols: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        for name in row.unit.covariates.keys().filter(|n| !covariates.contains(n)).collect::<Vec<_>>() {
            covariates.push(name);
        }
        let Found::Fit(fit) = &row.found else { continue };
        for v in &fit.values {
            if !symbols.iter().any(|(s, _)| *s == v.symbol) {
                symbols.push((&v.symbol, &v.unit));
            }
        }
    }
    let mut header: Vec<String> = ["unit", "specimen", "group"].map(str::to_owned).to_vec();
    header.extend(covariates.iter().map(|c| (*c).clone()));
    header.extend(["state", "reason"].map(str::to_owned));
    let is_fit = plan.header.question == Question::Identify;
    if is_fit {
        header.extend(["branches", "reduced_chi_square", "rms_mN"].map(str::to_owned));
    } else {
        header.extend(["answer", "confidence", "gap_percent", "shrinkage", "text"].map(str::to_owned));
    }
    for (symbol, unit) in &symbols {
        let with_unit =
            if *unit == "1" || unit.is_empty() { (*symbol).to_owned() } else { format!("{symbol} [{unit}]") };
        header.push(with_unit);
        header.extend(["lower", "upper", "ln_sigma", "known"].map(|what| format!("{symbol} {what}")));
    }
    let mut out = csv::Writer::from_writer(Vec::new());
    let failed = |e: csv::Error| StudyError::File { file: plan.directory.clone(), problem: e.to_string() };
    out.write_record(&header).map_err(failed)?;
    for row in rows {
        let unit = &row.unit;
        let mut fields =
            vec![unit.unit.to_string(), unit.specimen.clone(), unit.group.clone().unwrap_or_default()];
        fields.extend(covariates.iter().map(|c| unit.covariates.get(*c).cloned().unwrap_or_default()));
        fields.extend([row.state.to_owned(), row.reason.clone()]);
        match &row.found {
            Found::Fit(fit) => {
                fields.push(fit.branches.to_string());
                fields.extend([fit.reduced_chi_square, fit.rms_mn].map(|v| v.to_string()));
                for (symbol, _) in &symbols {
                    fields.extend(value_fields(fit.values.iter().find(|v| v.symbol == *symbol)));
                }
            }
            Found::Verdict { answer, text, confidence, gap_percent, shrinkage, .. } => {
                let shrinkage = shrinkage.map(|s| s.to_string()).unwrap_or_default();
                let (confidence, gap) = (confidence.to_string(), gap_percent.to_string());
                fields.extend([answer.clone(), confidence, gap, shrinkage, text.clone()]);
            }
            Found::Nothing => fields.resize(header.len(), String::new()),
        }
        out.write_record(&fields).map_err(failed)?;
    }
    let bytes = out.into_inner().map_err(|e| e.to_string());
    let text = bytes.and_then(|b| String::from_utf8(b).map_err(|e| e.to_string()));
    text.map_err(|problem| StudyError::File { file: plan.directory.clone(), problem })
}

fn value_fields(value: Option<&Value>) -> [String; 5] {
    let Some(v) = value else { return Default::default() };
    let known = match v.determination {
        Determination::Determined => "determined",
        Determination::Loose => "loose",
        Determination::Undetermined => "not determined",
    };
    let [a, b, c, d] = [v.value, v.lower, v.upper, v.ln_sigma].map(|v| v.to_string());
    [a, b, c, d, known.to_owned()]
}

fn report(question: Question, rows: &[Row], difference_percent: f64) -> PopulationReport {
    let done = rows.iter().filter(|r| !matches!(r.found, Found::Nothing)).count();
    let mut report = PopulationReport {
        schema: SCHEMA.to_owned(),
        question,
        units: rows.len(),
        done,
        difference_percent,
        values: vec![],
        answers: answers(rows),
        outliers: vec![],
        warnings: vec![],
    };
    if question == Question::Identify {
        populations(rows, &mut report);
    }
    report
}

/// Groups in the order of the table.
fn groups(rows: &[Row]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in rows {
        let name = row.unit.group.clone().unwrap_or_default();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn populations(rows: &[Row], report: &mut PopulationReport) {
    let fits = || {
        rows.iter().filter_map(|row| match &row.found {
            Found::Fit(fit) if row.state == "done" => Some((&row.unit, fit)),
            _ => None,
        })
    };
    // Values of models with other branches are other values.
    let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
    fits().for_each(|(_, fit)| *numbers.entry(fit.branches).or_default() += 1);
    let Some((&branches, &most)) = numbers.iter().max_by_key(|(k, n)| (**n, std::cmp::Reverse(**k))) else {
        return;
    };
    let all = fits().count();
    if most < all {
        report.warnings.push(format!(
            "{most} specimens have {branches} branches and {} another number; the population is that of the former: give all the \
             same (--free or --fix) to have them together",
            all - most
        ));
    }
    let names = groups(rows);
    let mut symbols: Vec<&str> = Vec::new();
    for (_, fit) in fits().filter(|(_, fit)| fit.branches == branches) {
        let new = fit.values.iter().map(|v| v.symbol.as_str()).filter(|s| !symbols.contains(s));
        let new: Vec<&str> = new.collect();
        symbols.extend(new);
    }
    for symbol in symbols {
        let (mut observed, mut specimens, mut unit) = (Vec::new(), Vec::new(), "");
        for (of, fit) in fits().filter(|(_, fit)| fit.branches == branches) {
            let Some(v) = fit.values.iter().find(|v| v.symbol == symbol) else { continue };
            if v.determination != Determination::Determined || !v.is_closed || v.value == 0.0 {
                continue;
            }
            let group = names.iter().position(|n| *n == of.group.clone().unwrap_or_default());
            let (ln_value, sigma) = (v.value.abs().ln(), v.ln_sigma);
            observed.push(Observed { ln_value, sigma, group: group.unwrap_or(0) });
            specimens.push((of.specimen.as_str(), v.value));
            unit = &v.unit;
        }
        // Those few whose data determine what most do not are no sample of the population.
        if 2 * observed.len() < most {
            continue;
        }
        let is_one_sign = specimens.windows(2).all(|w| w[0].1 * w[1].1 > 0.0);
        let Some(p) = Population::of(&observed, names.len()).filter(|_| is_one_sign) else { continue };
        let sign = specimens[0].1.signum();
        report.outliers.extend(outliers(symbol, &specimens, &observed, &p));
        report.values.push(value_report(
            symbol,
            unit,
            sign,
            &names,
            &p,
            all - observed.len(),
            report.difference_percent,
        ));
    }
}

fn value_report(
    symbol: &str,
    unit: &str,
    sign: f64,
    names: &[String],
    p: &Population,
    left_out: usize,
    difference_percent: f64,
) -> ValueReport {
    let natural = |i: Interval| match i.map(|v| sign * v.exp()) {
        // A negative value's ends exchange.
        Interval { value, lower, upper } if lower > upper => Interval { value, lower: upper, upper: lower },
        other => other,
    };
    let mean = |(k, name): (usize, &String)| GroupMean {
        group: name.clone(),
        specimens: p.counts[k],
        mean: p.means[k].map(natural),
    };
    let mut differences = Vec::new();
    for (i, over) in names.iter().enumerate() {
        for (j, of) in names.iter().enumerate().skip(i + 1) {
            let ratio = p.difference(i, j).map(|d| d.map(f64::exp));
            differences.extend(ratio.map(|ratio| Difference { of: of.clone(), over: over.clone(), ratio }));
        }
    }
    ValueReport {
        symbol: symbol.to_owned(),
        unit: unit.to_owned(),
        groups: names.iter().enumerate().map(mean).collect(),
        spread: p.spread,
        own_sigma: p.own_variance.sqrt(),
        left_out,
        differences,
        specimens_needed: p.specimens_needed((1.0 + difference_percent / 100.0).ln()),
    }
}

/// Specimens beyond what the most distant of so many reaches by chance once in twenty studies.
fn outliers(symbol: &str, specimens: &[(&str, f64)], observed: &[Observed], p: &Population) -> Vec<Outlier> {
    let level = 0.025 / observed.len() as f64;
    let limit = Normal::new(0.0, 1.0).map_or(f64::INFINITY, |n| n.inverse_cdf(1.0 - level));
    let distance = |o: &Observed| {
        let mean = p.means[o.group].map_or(o.ln_value, |m| m.value);
        (o.ln_value - mean) / (p.spread.value.powi(2) + o.sigma * o.sigma).sqrt()
    };
    let all = specimens.iter().zip(observed).map(|((name, _), o)| (name, distance(o)));
    let far = all.filter(|(_, d)| d.abs() > limit);
    far.map(|(name, distance)| Outlier { specimen: (*name).to_owned(), symbol: symbol.to_owned(), distance })
        .collect()
}

/// How often each answer was given, by group and by covariates of few values.
fn answers(rows: &[Row]) -> Vec<Answers> {
    let mut all: Vec<Answers> = Vec::new();
    let mut kinds: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, value) in rows.iter().flat_map(|r| &r.unit.covariates) {
        let values = kinds.entry(name).or_default();
        if !values.contains(&value.as_str()) && values.len() <= MOST_KINDS {
            values.push(value);
        }
    }
    for row in rows {
        let Found::Verdict { answer, .. } = &row.found else { continue };
        let mut count = |by: &str, group: &str| {
            let place = all.iter().position(|a| a.by == by && a.group == group).unwrap_or_else(|| {
                all.push(Answers { by: by.to_owned(), group: group.to_owned(), counts: BTreeMap::new() });
                all.len() - 1
            });
            *all[place].counts.entry(answer.clone()).or_default() += 1;
        };
        count("group", row.unit.group.as_deref().unwrap_or(""));
        for (name, value) in &row.unit.covariates {
            if kinds.get(name.as_str()).is_some_and(|v| v.len() <= MOST_KINDS) {
                count(name, value);
            }
        }
    }
    all.sort_by(|a, b| (a.by != "group", &a.by, &a.group).cmp(&(b.by != "group", &b.by, &b.group)));
    all
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
    write_file(&out.join("table.csv"), table.as_bytes())?;
    let text = format!("{done} of {} units have results", plan.header.units);
    Ok(Gathered { text, files: vec!["table.csv".to_owned(), "curves".to_owned()], population: None })
}
