//! The report of a fit: the schema of `result.json`. Values are in the units that stand beside them (people's:
//! mm, s, mN, Pa, mm^2).

use super::posterior::PosteriorReport;
use crate::assumption::Assumption;
use crate::fit::{StartRecord, StopReason};
use crate::inference::Finding;
use crate::inference::statistics::{BoundSide, Determination};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name and version of the schema. The number grows when a field changes its meaning or goes; new fields
/// may come without.
pub const SCHEMA: &str = "poropunch.fit-report/1";

/// Everything that is known about a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FitReport {
    /// [`SCHEMA`].
    pub schema: String,
    /// What nothing here is computed from.
    #[serde(flatten)]
    pub given: Given,
    /// The result in words.
    pub verdict: Verdict,
    /// Free parameters.
    pub parameters: Vec<ParameterRow>,
    /// Quantities computed from the parameters.
    pub derived: Vec<DerivedRow>,
    /// How much better values are known from everything than from the first loading and hold of each test; empty
    /// where nothing else was fitted.
    #[serde(default)]
    pub gains: Vec<GainRow>,
    /// Profiles of the likelihood; their intervals stand in the tables.
    #[serde(default)]
    pub profiles: Vec<ProfileRow>,
    /// A sample of the posterior, where it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorReport>,
    /// Correlation of each pair of free parameters.
    pub correlation: Correlation,
    /// What the data do not determine.
    pub findings: Vec<Finding>,
    /// Singular values of the log-parameter Jacobian in units of the noise.
    pub singular_values: Vec<f64>,
    /// Measurements with their fitted or predicted curves.
    pub measurements: Vec<MeasurementResult>,
    /// Peak ratios between measurements.
    pub ratios: Vec<Ratio>,
    /// How the fit went.
    pub fit: FitSummary,
    /// chi^2 after each iteration of the best start.
    pub iterations: Vec<IterationRow>,
}

/// What a report is given as it stands.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Given {
    /// Heading.
    pub title: String,
    /// When it was made, RFC 3339.
    pub created: String,
    /// The command that made it.
    pub command: String,
    /// Name and identification of the model.
    pub model: String,
    /// Fixed and tied parameters.
    pub fixed: Vec<FixedRow>,
    /// What the result rests on: every parameter that was not fitted, given or assumed.
    #[serde(default)]
    pub assumptions: Vec<Assumption>,
    /// Contact points and load cells' zeros that were fitted with the parameters.
    #[serde(default)]
    pub nuisances: Vec<NuisanceRow>,
    /// What it cost.
    pub runs: RunStatistics,
    /// The fate of each start.
    pub starts: Vec<StartRecord>,
    /// Settings of model and fit that are worth keeping, name and value.
    pub settings: Vec<Setting>,
}

/// The result in words.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// One sentence.
    pub headline: String,
    /// What the data determine.
    pub determined: Vec<String>,
    /// What they do not.
    pub undetermined: Vec<String>,
    /// What the reader must know before using the numbers.
    pub warnings: Vec<String>,
}

/// How well a value is known: half-widths of its 95 % interval in ln(value).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainRow {
    /// Symbol, plain text.
    pub symbol: String,
    /// From the first loading and hold of each test.
    pub first_hold: f64,
    /// From everything that was fitted.
    pub all: f64,
}

/// How chi^2 rises when a value is given and everything else is fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProfileRow {
    /// Full name.
    pub name: String,
    /// Symbol, plain text.
    pub symbol: String,
    /// Unit of all values in this row.
    pub unit: String,
    /// Fitted value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub lower: f64,
    /// Upper end of the 95 % interval.
    pub upper: f64,
    /// The interval is open below or above: chi^2 does not rise enough before the bound.
    pub open: [bool; 2],
    /// Rise at the ends of the interval.
    pub threshold: f64,
    /// Value and rise of chi^2.
    pub points: Vec<[f64; 2]>,
    /// Whether the user asked for it; otherwise the linearised interval was open or curved.
    pub asked: bool,
}

/// A free parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterRow {
    /// Full name.
    pub name: String,
    /// Symbol, plain text.
    pub symbol: String,
    /// Unit of all values in this row.
    pub unit: String,
    /// Fitted value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub lower: f64,
    /// Upper end of the 95 % interval.
    pub upper: f64,
    /// The interval is open below or above: it ends at the bound, not where the data end it.
    pub open: [bool; 2],
    /// Half-width of the 95 % interval in ln(value).
    pub half_width: f64,
    /// How well it is known.
    pub determination: Determination,
    /// Bound at which it sits.
    pub at_bound: Option<BoundSide>,
    /// Start value.
    pub start: f64,
    /// Lower bound.
    pub lower_bound: f64,
    /// Upper bound.
    pub upper_bound: f64,
    /// Share of the variance that comes from errors common to all points.
    pub common_share: f64,
    /// The interval is that of a profile of the likelihood.
    #[serde(default)]
    pub profiled: bool,
}

/// What a test does not say itself and no law of the material is: where its surface is, what its load cell reads without load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NuisanceRow {
    /// What, of which test.
    pub name: String,
    /// Unit of all values in this row.
    pub unit: String,
    /// How much higher the surface lies, or the load cell reads, than was read from the file (and told there).
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub lower: f64,
    /// Upper end of the 95 % interval.
    pub upper: f64,
}

/// A parameter that was not fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FixedRow {
    /// Full name.
    pub name: String,
    /// Symbol, plain text.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// `fixed`, or the expression it is tied by.
    pub how: String,
}

/// A quantity computed from the parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DerivedRow {
    /// Full name.
    pub name: String,
    /// Symbol, plain text.
    pub symbol: String,
    /// Formula in symbols.
    pub formula: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub lower: f64,
    /// Upper end of the 95 % interval.
    pub upper: f64,
    /// Half-width in ln(value).
    pub half_width: f64,
    /// How well it is known.
    pub determination: Determination,
}

/// Correlation matrix, in the order of the parameters.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Correlation {
    /// Symbols of the rows and columns.
    pub symbols: Vec<String>,
    /// The matrix, by rows.
    pub matrix: Vec<Vec<f64>>,
}

/// What a measurement was used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The parameters were fitted to it.
    Fit,
    /// The model only predicts it.
    Validation,
}

/// A measured number and the model's.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Pair {
    /// From the data.
    pub measured: f64,
    /// From the model.
    pub model: f64,
}

/// A measurement and the model's curve at the solution. All series have the length of `time_s`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredCurve {
    /// Short name, e.g. `P2`.
    pub name: String,
    /// File it came from.
    pub file: String,
    /// What it was used for.
    pub role: Role,
    /// Where the data come from, if the file says so; data that are synthetic say it here.
    pub provenance: Option<String>,
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Depth, positive into the sample (mm).
    pub displacement_mm: Vec<f64>,
    /// Measured force (mN).
    pub measured_mn: Vec<f64>,
    /// Spread between specimens (standard deviation) (mN).
    pub spread_mn: Option<Vec<f64>>,
    /// Force of each specimen (mN), where the file has them.
    #[serde(default)]
    pub specimens: Vec<SpecimenCurve>,
    /// Standard deviation of each measured point (mN); empty if unknown.
    pub sigma_mn: Vec<f64>,
    /// Model's force (mN).
    pub model_mn: Vec<f64>,
    /// Its solid part (mN).
    pub model_solid_mn: Option<Vec<f64>>,
    /// Its fluid part (mN).
    pub model_fluid_mn: Option<Vec<f64>>,
    /// Sum of squared differences over sigma, or over mN (Eq. 16) if sigma is unknown.
    pub chi_square: f64,
}

/// A measurement with the model's curve. All series have the length of `time_s`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasurementResult {
    /// Both curves.
    #[serde(flatten)]
    pub curve: MeasuredCurve,
    /// Whether the data are synthetic.
    pub synthetic: bool,
    /// chi^2 per point.
    pub chi_square_per_point: f64,
    /// Root mean square of the difference (mN).
    pub rms_mn: f64,
    /// Peak force (mN).
    pub peak_mn: Pair,
    /// Force at the end (mN).
    pub end_mn: Pair,
    /// Relaxation, (peak - end) / peak (%).
    pub relaxation_percent: Pair,
}

/// A specimen's curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpecimenCurve {
    /// Its name.
    pub name: String,
    /// Force (mN) at the times of the measurement.
    pub force_mn: Vec<f64>,
}

/// Ratio of two measurements' peak forces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ratio {
    /// What, e.g. `peak P2 / peak P1`.
    pub name: String,
    /// Its values.
    pub value: Pair,
}

/// How the fit went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FitSummary {
    /// Why it ended.
    pub stop: StopReason,
    /// The same in words.
    pub stop_text: String,
    /// Accepted steps of the best start.
    pub iterations: usize,
    /// Residual evaluations of the best start.
    pub evaluations: usize,
    /// Sum of squared residuals.
    pub chi_square: f64,
    /// Part of it that errors account for which many points share, such as the heights of the specimens.
    #[serde(default)]
    pub shared_chi_square: f64,
    /// Number of residuals.
    pub points: usize,
    /// Residuals minus free parameters.
    pub degrees_of_freedom: usize,
    /// The rest of chi^2 per degree of freedom.
    pub reduced_chi_square: f64,
    /// Residuals are in units of their known standard deviation.
    pub noise_known: bool,
    /// Integrated autocorrelation time of the residuals (points).
    pub correlation_time: f64,
    /// Names of errors common to all points that the intervals account for.
    pub common_errors: Vec<String>,
}

/// What the fit cost.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct RunStatistics {
    /// Simulations made.
    pub runs: usize,
    /// Simulations found in the cache instead.
    pub cache_hits: usize,
    /// Simulations that failed.
    pub failed: usize,
    /// Simulations cancelled because they were no longer needed.
    pub cancelled: usize,
    /// Mean number of simulations under way while a Jacobian was formed.
    pub mean_in_flight: f64,
    /// Wall time (s).
    pub wall_time_s: f64,
    /// Reasons of failures, without repetition.
    pub failures: Vec<String>,
}

/// chi^2 after an iteration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct IterationRow {
    /// Its number; 0 is the start.
    pub iteration: usize,
    /// Sum of squared residuals.
    pub chi_square: f64,
    /// Length of the step.
    pub step_norm: f64,
    /// Bound-scaled gradient.
    pub optimality: f64,
    /// Parameter values in their units, in the order of `parameters`.
    pub values: Vec<f64>,
}

/// A setting worth keeping.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Setting {
    /// Name.
    pub name: String,
    /// Value with unit.
    pub value: String,
}
