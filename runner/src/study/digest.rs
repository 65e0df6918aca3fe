//! What a study keeps of each answer: values with their uncertainty, one verdict, few points of the curves. The rest stays on disk, so
//! that memory does not grow with what a result weighs.

use super::results::Provenance;
use crate::diagnosis::result::{CurvePair, ShrinkageSummary, Verdict};
use crate::inference::statistics::Determination;
use crate::report::{DerivedRow, MeasurementResult, ParameterRow, Role};
use serde::Deserialize;
use std::collections::HashSet;
use std::sync::Arc;

/// Points of a curve on the page.
const POINTS: usize = 80;
/// Half-width of a normal distribution's 95 % interval in standard deviations.
const NORMAL: f64 = 1.959_963_984_540_054;

/// A result, of which only some fields are read.
#[derive(Debug, Deserialize)]
pub struct Answered<A> {
    /// The fit converged.
    pub converged: bool,
    /// How it was computed.
    pub run: Provenance,
    /// The answer.
    pub answer: A,
}

/// What is read of `result.json`.
#[derive(Debug, Deserialize)]
pub struct FitAnswer {
    parameters: Vec<ParameterRow>,
    derived: Vec<DerivedRow>,
    fit: FitNumbers,
    measurements: Vec<MeasurementResult>,
}

#[derive(Debug, Deserialize)]
struct FitNumbers {
    reduced_chi_square: f64,
}

/// What is read of `diagnosis.json`.
#[derive(Debug, Deserialize)]
pub struct DiagnosisAnswer {
    /// Answer.
    pub verdict: Verdict,
    /// How much of the gap goes.
    pub shrinkage: Option<ShrinkageSummary>,
    curves: Vec<CurvePair>,
}

/// What is read of the answer to `batch`.
#[derive(Debug, Deserialize)]
pub struct BatchAnswer {
    /// Rows of its table, with their header.
    pub summary: String,
    /// Curves by the names of their files.
    pub curves: std::collections::BTreeMap<String, String>,
}

/// Words that many specimens share, each of them in memory once.
#[derive(Debug, Default)]
pub struct Words(HashSet<Arc<str>>);

impl Words {
    fn get(&mut self, word: &str) -> Arc<str> {
        if let Some(known) = self.0.get(word) {
            return Arc::clone(known);
        }
        let new: Arc<str> = word.into();
        self.0.insert(Arc::clone(&new));
        new
    }
}

/// A value of a specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// Symbol, branches in order of their times.
    pub symbol: Arc<str>,
    /// Unit.
    pub unit: Arc<str>,
    /// Value.
    pub value: f64,
    /// Lower end of its 95 % interval.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// Standard deviation of ln(value) of the normal distribution with the same interval.
    pub ln_sigma: f64,
    /// How well it is known.
    pub determination: Determination,
    /// The data end its interval on both sides: its likelihood may be taken for normal.
    pub is_closed: bool,
}

impl Value {
    /// A value that the data end on both sides, with its interval's ends and half-width in ln(value).
    fn of(
        words: &mut Words,
        (symbol, unit): (&str, &str),
        [value, lower, upper]: [f64; 3],
        half_width: f64,
        determination: Determination,
    ) -> Self {
        let (symbol, unit, ln_sigma) = (words.get(symbol), words.get(unit), half_width / NORMAL);
        Self { symbol, unit, value, lower, upper, ln_sigma, determination, is_closed: true }
    }
}

/// Measured and model.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Test.
    pub name: String,
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Measured force (mN).
    pub measured_mn: Vec<f64>,
    /// Model's force (mN).
    pub model_mn: Vec<f64>,
}

/// What a fit found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Parameters and their combinations.
    pub values: Vec<Value>,
    /// Number of viscous branches.
    pub branches: usize,
    /// chi^2 per degree of freedom.
    pub reduced_chi_square: f64,
    /// Root mean square difference over all fitted tests (mN).
    pub rms_mn: f64,
    /// Fitted tests.
    pub curves: Vec<Curve>,
}

impl FitAnswer {
    /// What a study keeps of it.
    pub fn digest(self, words: &mut Words) -> Fit {
        let mut values: Vec<Value> = Vec::new();
        for d in &self.derived {
            let interval = [d.value, d.lower, d.upper];
            values.push(Value::of(words, (&d.symbol, &d.unit), interval, d.half_width, d.determination));
        }
        for p in &self.parameters {
            if !values.iter().any(|v| *v.symbol == *p.symbol) {
                let interval = [p.value, p.lower, p.upper];
                let known = Value::of(words, (&p.symbol, &p.unit), interval, p.half_width, p.determination);
                let is_closed = p.open == [false; 2] && p.at_bound.is_none();
                values.push(Value { is_closed, ..known });
            }
        }
        let branches = in_order_of_time(&mut values, words);
        values.shrink_to_fit();
        let fitted = || self.measurements.iter().filter(|m| m.curve.role == Role::Fit);
        let points: usize = fitted().map(|m| m.curve.time_s.len()).sum();
        let square: f64 = fitted().map(|m| m.rms_mn.powi(2) * m.curve.time_s.len() as f64).sum();
        let curve = |m: &MeasurementResult| {
            few(&m.curve.name, &m.curve.time_s, &m.curve.measured_mn, &m.curve.model_mn)
        };
        Fit {
            values,
            branches,
            reduced_chi_square: self.fit.reduced_chi_square,
            rms_mn: (square / points.max(1) as f64).sqrt(),
            curves: fitted().map(curve).collect(),
        }
    }
}

impl DiagnosisAnswer {
    /// Curves of the plain model, or of the one with the effect where there is one.
    pub fn curves(&self) -> Vec<Curve> {
        let model = |c: &CurvePair| c.after_mn.clone().unwrap_or_else(|| c.before_mn.clone());
        self.curves.iter().map(|c| few(&c.name, &c.time_s, &c.measured_mn, &model(c))).collect()
    }
}

/// Renumbers branches by rising relaxation time, as a specimen's fit may have them in any order; how many there are.
fn in_order_of_time(values: &mut [Value], words: &mut Words) -> usize {
    let number = |symbol: &str, head: &str| symbol.strip_prefix(head)?.parse::<usize>().ok();
    let mut times: Vec<(f64, usize)> =
        values.iter().filter_map(|v| Some((v.value, number(&v.symbol, "tau_")?))).collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    for value in values.iter_mut() {
        let Some((head, tail)) = value.symbol.rsplit_once('_') else { continue };
        let place = tail.parse().ok().and_then(|k: usize| times.iter().position(|(_, of)| *of == k));
        if let Some(place) = place {
            value.symbol = words.get(&format!("{head}_{}", place + 1));
        }
    }
    times.len()
}

/// Some points of a curve, its largest force and its last point among them.
fn few(name: &str, time_s: &[f64], measured_mn: &[f64], model_mn: &[f64]) -> Curve {
    let n = time_s.len().min(measured_mn.len()).min(model_mn.len());
    let step = n.div_ceil(POINTS).max(1);
    let peak = (0..n).max_by(|a, b| measured_mn[*a].total_cmp(&measured_mn[*b]));
    let kept: Vec<usize> = (0..n).filter(|k| k % step == 0 || Some(*k) == peak || *k + 1 == n).collect();
    let of = |all: &[f64]| kept.iter().map(|&k| all[k]).collect();
    Curve { name: name.to_owned(), time_s: of(time_s), measured_mn: of(measured_mn), model_mn: of(model_mn) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(symbol: &str, value: f64) -> Value {
        Value {
            symbol: symbol.into(),
            unit: "".into(),
            value,
            lower: value,
            upper: value,
            ln_sigma: 0.1,
            determination: Determination::Determined,
            is_closed: true,
        }
    }

    #[test]
    fn branches_are_numbered_by_their_times() {
        let mut values = [value("G_inf", 1.0), value("G_1", 2.0), value("tau_1", 20.0), value("G_2", 3.0)]
            .into_iter()
            .chain([value("tau_2", 0.02), value("G_0", 6.0)])
            .collect::<Vec<_>>();
        assert_eq!(in_order_of_time(&mut values, &mut Words::default()), 2);
        let symbols: Vec<&str> = values.iter().map(|v| &*v.symbol).collect();
        assert_eq!(symbols, ["G_inf", "G_2", "tau_2", "G_1", "tau_1", "G_0"]);
    }

    #[test]
    fn few_points_keep_peak_and_end() {
        let t: Vec<f64> = (0..1000).map(f64::from).collect();
        let f: Vec<f64> = t.iter().map(|t| -(t - 501.0).abs()).collect();
        let c = few("P2", &t, &f, &f);
        assert!(c.time_s.len() <= POINTS + 2 && c.time_s.contains(&501.0) && c.time_s.contains(&999.0));
    }
}
