//! What all specimens together say: the population of every value, the answers of `diagnose`, who is far from the others.

use super::Question;
use super::gather::{Found, Row, Verdict, in_order_of_appearance};
use super::population::{Interval, Observed, Population};
use crate::inference::statistics::Determination;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::BTreeMap;

/// Version of the layout.
pub const SCHEMA: &str = "poropunch.study-population/1";
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

/// What the rows say together; `difference_percent` is what the number of specimens is asked for.
pub fn report(question: Question, rows: &[Row], difference_percent: f64) -> PopulationReport {
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
    let names = rows.iter().map(|row| row.unit.group.as_deref().unwrap_or_default());
    in_order_of_appearance(names).into_iter().map(str::to_owned).collect()
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
    let of_population = || fits().filter(|(_, fit)| fit.branches == branches);
    let symbols = of_population().flat_map(|(_, fit)| fit.values.iter().map(|v| &*v.symbol));
    for symbol in in_order_of_appearance(symbols) {
        let (mut observed, mut specimens, mut unit) = (Vec::new(), Vec::new(), "");
        for (of, fit) in of_population() {
            let Some(v) = fit.values.iter().find(|v| *v.symbol == *symbol) else { continue };
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
        let Found::Verdict(Verdict { answer, .. }) = &row.found else { continue };
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
