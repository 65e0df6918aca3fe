//! What a diagnosis found: one serialisable structure, in the units that people use.

use super::experiments::Proposal;
use super::leftover::Leftover;
use crate::assumption::Assumption;
use crate::data::Phase;
use crate::inference::effect::{Place, Sign};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Version of the JSON layout.
pub const SCHEMA: &str = "poropunch.diagnosis/1";

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: String,
    /// Command that was given.
    pub command: String,
    /// Whether only the leaders were refitted.
    pub quick: bool,
    /// Answer.
    pub verdict: Verdict,
    /// What it rests on: the parameters that were not fitted.
    #[serde(default)]
    pub assumptions: Vec<Assumption>,
    /// Tests, and what was left out of them.
    pub tests: Vec<TestSummary>,
    /// Relations that need no fit.
    pub parity: Vec<Parity>,
    /// Fit of the plain model.
    pub baseline: ModelSummary,
    /// Where it misses.
    pub location: Location,
    /// Effects as screening sees them, largest evidence first.
    pub effects: Vec<EffectSummary>,
    /// Cosines between the signatures of `effects`, in their order.
    pub overlap: Vec<Vec<f64>>,
    /// Models that were refitted, and their competitors, largest evidence first.
    pub models: Vec<ModelSummary>,
    /// Twice the log evidence of a smooth error outside the catalogue against no gap.
    pub something_else_evidence: f64,
    /// Prediction of data that were not fitted.
    pub held_out: Vec<HeldOut>,
    /// How much of the gap goes.
    pub shrinkage: Option<ShrinkageSummary>,
    /// Effects that these data cannot show, and why.
    pub not_testable: Vec<NotTestable>,
    /// What simpler methods would answer, for comparison.
    pub simple_rules: Vec<SimpleRule>,
    /// What a gap looks like that no effect explains.
    #[serde(default)]
    pub leftover: Option<Leftover>,
    /// Tests that would tell the members of a group apart, the best first.
    #[serde(default)]
    pub proposals: Vec<Proposal>,
    /// What reveals the surviving candidates.
    pub next: Vec<String>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Measured and computed curves.
    pub curves: Vec<CurvePair>,
    /// Wall time (s).
    pub seconds: f64,
}

/// Kind of answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Kind {
    /// The model and the data agree within the noise.
    #[serde(rename = "no gap")]
    NoGap,
    /// One effect explains the gap.
    #[serde(rename = "effect")]
    Effect,
    /// One of several effects that cannot be told apart explains it.
    #[serde(rename = "group")]
    Group,
    /// Two effects together explain it.
    #[serde(rename = "pair")]
    Pair,
    /// No effect of the catalogue explains it.
    #[serde(rename = "none of these")]
    NoneOfThese,
}

/// The answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// Kind of answer.
    pub kind: Kind,
    /// Names of the effects: one, the group, or the pair and then what would do as well in the place of its second; the most
    /// probable first.
    pub effects: Vec<String>,
    /// Probability that the answer is right.
    pub confidence: f64,
    /// Largest mean difference between data and plain model over half a decade of the time since any kink of the motion, as part of
    /// its test's largest force (%).
    #[serde(default)]
    pub gap_percent: f64,
    /// What is smaller does not matter (%).
    #[serde(default)]
    pub matters_percent: f64,
    /// Whether there is a significant gap, but a smaller one, and no effect that is sure to predict better.
    #[serde(default)]
    pub is_immaterial: bool,
    /// In plain words.
    pub text: String,
}

/// One test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TestSummary {
    /// Its name.
    pub name: String,
    /// Points used.
    pub points: usize,
    /// Cycles used.
    pub cycles: usize,
    /// What was left out.
    pub left_out: Option<String>,
    /// Specimens.
    pub specimens: usize,
    /// Its noise.
    #[serde(flatten)]
    pub noise: NoiseSummary,
}

/// Noise of one test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseSummary {
    /// White noise of a specimen's sample (mN).
    pub specimen_white_mn: Option<f64>,
    /// White noise of the curve, median over its points (mN).
    pub white_mn: f64,
    /// Slow noise of the load cell (mN) and its time (s).
    pub slow_noise: Option<(f64, f64)>,
    /// Relative scatter of the specimens' heights (-).
    pub height_scatter: Option<f64>,
    /// Whether the specimens are those of the other tests.
    pub same_specimens: bool,
}

/// One relation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Parity {
    /// What is compared.
    pub relation: String,
    /// Test, tests and cycle.
    pub of: String,
    /// What was found, and what it would be.
    #[serde(flatten)]
    pub deviation: Deviation,
    /// What a deviation would mean.
    pub shows: String,
}

/// A value beside what it would be without an effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Deviation {
    /// Value.
    pub value: f64,
    /// Its standard uncertainty, where known.
    pub sigma: Option<f64>,
    /// Value without the effect that it would show.
    pub expected: Option<f64>,
    /// Unit.
    pub unit: String,
}

/// A fitted model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelSummary {
    /// Effects in it; none for the plain model.
    pub effects: Vec<String>,
    /// chi^2, prior included.
    pub chi_square: f64,
    /// Points.
    pub points: usize,
    /// Decrease of chi^2 against the plain model.
    pub gain: f64,
    /// Twice the log evidence against the plain model.
    pub evidence: f64,
    /// Posterior probability among all competitors.
    pub probability: f64,
    /// Magnitude of each effect (plausible scales) and its standard deviation.
    pub magnitudes: Vec<(f64, f64)>,
    /// Family-wise probability that noise leaves such a residual.
    pub adequacy: f64,
    /// Material parameters (display units): name, value, unit.
    pub parameters: Vec<(String, f64, String)>,
    /// Root mean square residual (mN).
    pub rms_mn: f64,
}

/// Where the plain model misses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Location {
    /// Score that the largest of all passes by noise alone in 1 of 20 cases.
    pub threshold: f64,
    /// Family-wise probability of the largest score, effects included, under noise.
    pub probability: f64,
    /// Phases and time scales.
    pub spots: Vec<SpotSummary>,
}

/// One place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpotSummary {
    /// Test.
    pub test: String,
    /// Cycle, counted from 1; none for a time scale of all holds.
    pub cycle: Option<usize>,
    /// Phase.
    pub phase: Option<Phase>,
    /// `level`, `tilt`, or the relaxation time.
    pub pattern: String,
    /// Relaxation time (s).
    pub time_s: Option<f64>,
    /// Score, standard normal under noise.
    pub score: f64,
    /// Mean of measured minus model (mN).
    pub mean_mn: f64,
    /// Root mean square of measured minus model (mN).
    pub rms_mn: f64,
    /// Family-wise probability under noise.
    pub probability: f64,
}

/// One effect in screening.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectSummary {
    /// Name.
    pub name: String,
    /// Name of the effect in the catalogue that it is a variant of.
    pub family: String,
    /// In words.
    pub title: String,
    /// Where it acts.
    pub place: Place,
    /// Its magnitudes.
    pub sign: Sign,
    /// Score.
    pub score: f64,
    /// Family-wise probability under noise.
    pub probability: f64,
    /// Expected magnitude (plausible scales).
    pub magnitude: f64,
    /// Its standard deviation (plausible scales).
    pub magnitude_sigma: f64,
    /// Size of magnitude 1, where it has a unit.
    pub scale: f64,
    /// Unit of the scale.
    pub unit: String,
    /// Decrease of chi^2 that is expected of a refit.
    pub predicted_gain: f64,
    /// Decrease of chi^2 in the refit, where one was made.
    pub actual_gain: Option<f64>,
    /// Share that a refit of the parameters hides.
    pub absorbed: f64,
    /// Score that the plausible scale would give.
    pub power: f64,
    /// Twice the log evidence, linear.
    pub evidence: f64,
    /// Whether these data would show it.
    pub testable: bool,
    /// Names of the effects that look the same.
    pub group: Vec<String>,
}

/// A prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldOut {
    /// What was predicted from what.
    pub split: String,
    /// Effects that the fitted part alone would have chosen; the prediction is with them.
    #[serde(default)]
    pub chosen: Vec<String>,
    /// Twice the gain in log predictive density by the effects.
    pub score: f64,
    /// Whether the fitted part determines the effects.
    pub informative: bool,
    /// Gap before and after, per phase and total.
    pub parts: Vec<PartGap>,
}

/// Gap in some part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PartGap {
    /// `total` or the phase.
    pub part: String,
    /// Without the effect (mN).
    pub before_mn: f64,
    /// With it (mN).
    pub after_mn: f64,
    /// `1 - after / before`; undefined where the plain model has no significant gap.
    pub shrinkage: Option<f64>,
    /// 90 % interval.
    #[serde(default)]
    pub interval: Option<(f64, f64)>,
}

/// How much of the gap goes, in total.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShrinkageSummary {
    /// Of which data.
    pub of: String,
    /// Effects that the rest of the data alone would have chosen; the prediction is with them.
    #[serde(default)]
    pub chosen: Vec<String>,
    /// Gap before (mN).
    pub before_mn: f64,
    /// Gap after (mN).
    pub after_mn: f64,
    /// `1 - after / before`; undefined where the plain model has no significant gap.
    pub value: Option<f64>,
    /// 90 % interval.
    pub interval: Option<(f64, f64)>,
    /// Predicted points among those of all tests, one test after the other.
    pub points: Vec<usize>,
    /// Predictions at these points without the effect (mN).
    pub predicted_before_mn: Vec<f64>,
    /// And with it (mN).
    pub predicted_after_mn: Vec<f64>,
}

impl ShrinkageSummary {
    /// Shrinkage of the distance from the force without noise (mN, all points of all tests), where it is known.
    pub fn against(&self, truth_mn: &[f64]) -> Option<f64> {
        let distance = |predicted: &[f64]| -> Option<f64> {
            let square = |(&i, p): (&usize, &f64)| truth_mn.get(i).map(|t| (t - p).powi(2));
            let sum: Option<f64> = self.points.iter().zip(predicted).map(square).sum();
            Some(sum?.sqrt())
        };
        let before = distance(&self.predicted_before_mn)?;
        (before > 0.0).then_some(1.0 - distance(&self.predicted_after_mn)? / before)
    }
}

/// What a simple rule would answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SimpleRule {
    /// Rule.
    pub rule: String,
    /// Effect of the catalogue; none for no gap.
    pub effect: Option<String>,
}

/// An effect that these data cannot show.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NotTestable {
    /// Name.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// One test's curves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurvePair {
    /// Test.
    pub name: String,
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Measured (mN).
    pub measured_mn: Vec<f64>,
    /// Each specimen's curve (mN), where the file has them.
    #[serde(default)]
    pub specimens_mn: Vec<Vec<f64>>,
    /// Standard deviation of the measured curve, simulation error included (mN).
    pub sigma_mn: Vec<f64>,
    /// Plain model (mN).
    pub before_mn: Vec<f64>,
    /// Model with the effect of the verdict (mN), where there is one.
    pub after_mn: Option<Vec<f64>>,
}
