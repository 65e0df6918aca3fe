//! What an inspection found: one serialisable structure, in the units that people use.

use super::water::WaterContent;
use crate::data::{CycleTimes, Estimate, Phase, Quartiles};
use crate::noise::correlated::Autocorrelation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Version of the JSON layout.
pub const SCHEMA: &str = "poropunch.inspection/1";

/// All that was read from some measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Inspection {
    /// [`SCHEMA`].
    pub schema: String,
    /// Command that was given.
    pub command: String,
    /// Force that means contact (mN).
    pub contact_threshold_mn: f64,
    /// Water content and volume fraction of solid, if they were asked for.
    pub water: Option<WaterContent>,
    /// One for each test.
    pub tests: Vec<TestInspection>,
    /// Tests against the slowest of them, cycle by cycle.
    pub ratios: Vec<Ratio>,
}

/// One test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TestInspection {
    /// Its name.
    pub name: String,
    /// Where it comes from.
    #[serde(flatten)]
    pub source: Source,
    /// Names of the specimens; empty where the file holds one curve.
    pub specimens: Vec<String>,
    /// Specimens that differ from all others in shape or height.
    pub odd_specimens: Vec<OddSpecimen>,
    /// Number of points.
    pub points: usize,
    /// Standard deviation of a displacement sample's noise (mm).
    pub displacement_noise_mm: f64,
    /// What was added to each specimen's clock (s).
    pub shifts_s: Vec<Estimate>,
    /// The cycles.
    pub cycles: Vec<CycleInspection>,
    /// The noise.
    pub noise: NoiseInspection,
    /// The curve with its phases, for the page and phases.csv.
    #[serde(skip)]
    pub curve: PhaseCurve,
}

/// Where a test comes from, and what its file says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Source {
    /// File, or directory of the specimens' files.
    pub file: String,
    /// Comment lines of the file.
    pub comments: Vec<String>,
    /// Whether the file says that it was not measured.
    pub synthetic: bool,
    /// What was read leniently or needs attention.
    pub notes: Vec<String>,
}

/// A specimen that is none of its kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OddSpecimen {
    /// Its name.
    pub name: String,
    /// What is odd about it.
    pub why: String,
    /// Whether `identify` and `diagnose` leave it out: that of another shape.
    pub left_out: bool,
}

/// Median curve, point by point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PhaseCurve {
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Displacement (mm).
    pub displacement_mm: Vec<f64>,
    /// Force (mN).
    pub force_mn: Vec<f64>,
    /// Lower and upper quartile (mN), where there are specimens.
    pub quartiles_mn: Option<Vec<(f64, f64)>>,
    /// Force of each specimen (mN); empty where there is one curve.
    pub specimens_mn: Vec<Vec<f64>>,
    /// Samples that stand alone: time (s) and force (mN).
    pub outliers: Vec<(f64, f64)>,
    /// Cycle, counted from 1.
    pub cycle: Vec<usize>,
    /// Phase.
    pub phase: Vec<Phase>,
}

/// One cycle. Quartiles are over the specimens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CycleInspection {
    /// Its number and times.
    #[serde(flatten)]
    pub times: CycleTimes,
    /// Length of the hold (s).
    pub hold_s: f64,
    /// Displacement of the hold (mm).
    pub depth_mm: f64,
    /// Rate of the loading (mm/s).
    pub rate_mm_per_s: Estimate,
    /// Rate of the unloading (mm/s), positive.
    pub unload_rate_mm_per_s: Option<f64>,
    /// Largest force (mN).
    pub peak_mn: Quartiles,
    /// Force at some times after the end of the ramp, as far as the hold lasts.
    pub force_after: Vec<ForceAfter>,
    /// Force at the end of the hold (mN).
    pub hold_end_mn: Quartiles,
    /// (peak - force at the end of the hold) / peak (%).
    pub relaxation_percent: Quartiles,
    /// Peak over the peak of cycle 1 of the same specimen (-).
    pub peak_over_first: Quartiles,
    /// Smallest force after the hold.
    pub retraction: Option<Retraction>,
    /// Force off contact.
    #[serde(flatten)]
    pub off_contact: OffContact,
    /// First touch; none where no specimen's force passes the threshold.
    pub contact: Option<ContactInspection>,
}

/// Force some time after the end of the ramp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ForceAfter {
    /// Time after the end of the ramp (s).
    pub after_s: f64,
    /// Force (mN).
    pub force_mn: Quartiles,
}

/// Force while the punch is pulled off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Retraction {
    /// Smallest force (mN).
    pub minimum_mn: Quartiles,
    /// What noise alone would not fall below in 99 of 100 cycles (mN).
    pub noise_alone_mn: f64,
    /// Whether the median minimum is below that: the sample holds the punch.
    pub adhesion: bool,
}

/// Force off contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OffContact {
    /// Mean force before first touch (mN).
    pub off_contact_before_mn: Option<Estimate>,
    /// Mean force after withdrawal (mN).
    pub off_contact_after_mn: Option<Estimate>,
    /// Change of the force off contact over the cycle, specimen by specimen (mN).
    pub drift_mn: Option<Estimate>,
}

/// First touch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContactInspection {
    /// Displacement at which the force passes the threshold above that off contact (mm).
    pub threshold_mm: Quartiles,
    /// Standard uncertainty of that for one specimen: noise over slope, sampling (mm).
    pub threshold_sigma_mm: f64,
    /// Displacement at which the force begins, extrapolated (mm).
    pub onset_mm: Option<Quartiles>,
    /// Standard uncertainty of that for one specimen (mm).
    pub onset_sigma_mm: Option<f64>,
}

/// Where noise was told from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseSource {
    /// Punch in the air.
    OffContact,
    /// Late part of the holds, from sample to sample.
    Holds,
}

/// Noise of the force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseInspection {
    /// White part of one specimen's samples (mN).
    pub white_mn: Option<Estimate>,
    /// Where the white part was told.
    pub white_from: NoiseSource,
    /// The correlated part.
    #[serde(flatten)]
    pub correlated: CorrelatedNoise,
    /// Samples that tell it.
    pub samples: usize,
    /// Samples left out.
    pub outliers: usize,
    /// Standard deviation of the logarithm of a factor common to a specimen's whole curve (-).
    pub specimen_log_deviation: Option<Estimate>,
    /// What that leaves unknown of the median curve's height, relative (-).
    pub height_of_median: Option<f64>,
    /// Factor of each specimen (-).
    pub specimen_factors: Vec<f64>,
    /// Autocorrelation off contact.
    #[serde(skip)]
    pub autocorrelation: Vec<Autocorrelation>,
}

/// Noise off contact that lasts from sample to sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrelatedNoise {
    /// Correlated part off contact (mN); none where none is seen.
    pub correlated_mn: Option<Estimate>,
    /// Correlation time of that part (s).
    pub correlation_time_s: Option<Estimate>,
    /// The correlated part is below this, with 95 % confidence (mN).
    pub correlated_below_mn: Option<f64>,
}

/// A faster test against the slowest, in one cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ratio {
    /// Name of the faster test.
    pub test: String,
    /// Name of the slowest test.
    pub reference: String,
    /// Cycle.
    pub cycle: usize,
    /// Ratio of the rates (-).
    pub rate: f64,
    /// Ratio of the median peaks (-).
    pub peak: RatioValue,
    /// Ratio of the median forces at the end of the hold (-): an amplitude, of any fading memory.
    pub hold_end: RatioValue,
    /// Ratio of peaks over that of hold ends (-): what is left for the rate.
    pub rate_effect: RatioValue,
}

/// A ratio; its uncertainty is known where both tests have specimens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RatioValue {
    /// Ratio (-).
    pub value: f64,
    /// Standard uncertainty from the scatter of specimens (-).
    pub sigma: Option<f64>,
}
