//! How uncertain each point of a measurement is.
//!
//! The spread among specimens is mostly a factor common to all points of a specimen: it says how well the
//! curve's height is known, not how well its shape is. So when the file holds the specimens, the two are
//! separated: `force_k(t) = a_k median(t) + white noise`. The white part, carried through the median, weighs
//! the points; the common part is reported beside the intervals.

pub mod common_factor;
pub mod correlated;

use super::measurement::{Measurement, median, standard_deviation};
use super::random::Random;
use clap::ValueEnum;

/// Which uncertainty weighs the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseModel {
    /// Specimens if the file has at least three, else its spread, else none.
    #[default]
    Auto,
    /// White noise of the median, from the specimens.
    Specimens,
    /// The file's spread per point (of the median if `--specimens` tells how many there were).
    Spread,
    /// None: the plain sum of squared differences of Eq. 16.
    None,
}

/// Standard deviation of each point, and of a factor common to all.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// Standard deviation per point (N); empty when unknown (Eq. 16).
    pub sigma_n: Vec<f64>,
    /// Relative standard deviation of a factor common to all points (-), if it can be told.
    pub common_factor: Option<f64>,
    /// In words, for the report.
    pub description: String,
}

/// Standard deviation of a median over that of a mean, for many normal values: sqrt(pi / 2).
const MEDIAN_OVER_MEAN: f64 = 1.253_314_137_315_5;
/// Draws of the median per point.
const DRAWS: usize = 400;

impl NoiseModel {
    /// Uncertainty of a measurement whose spread (if it has one) is over `specimens` specimens.
    ///
    /// # Errors
    /// In words, when the model asked for needs what the file does not have.
    pub fn of(self, m: &Measurement, specimens: Option<usize>) -> Result<Noise, String> {
        let missing = |what: &str| Err(format!("{}: --noise {what}", m.file.display()));
        match self {
            Self::Auto if m.specimens_n.len() >= 3 => Ok(from_specimens(m)),
            Self::Auto if m.spread_n.is_some() => Self::Spread.of(m, specimens),
            Self::Auto | Self::None => Ok(Noise {
                sigma_n: Vec::new(),
                common_factor: None,
                description: "no noise model: sum of squared differences (Eq. 16)".into(),
            }),
            Self::Specimens if m.specimens_n.len() >= 3 => Ok(from_specimens(m)),
            Self::Specimens => missing("specimens needs at least three specimen columns s01, s02, ..."),
            Self::Spread => match &m.spread_n {
                Some(spread) => Ok(from_spread(m, spread, specimens)),
                None => missing("spread needs a column force_std_mN, or force_q25_mN and force_q75_mN"),
            },
        }
    }
}

fn from_spread(m: &Measurement, spread: &[f64], specimens: Option<usize>) -> Noise {
    let n = specimens.or((m.specimens_n.len() > 1).then_some(m.specimens_n.len()));
    let factor = n.map_or(1.0, |n| MEDIAN_OVER_MEAN / (n as f64).sqrt());
    // A few equal specimens by chance must not give a point endless weight.
    let floor = 0.1 * median(&mut spread.to_vec());
    let description = match n {
        Some(n) => format!("spread of the file, as that of the median of {n} specimens"),
        None => "spread of the file (of single specimens: their number is not known)".into(),
    };
    let sigma_n = spread.iter().map(|s| factor * s.max(floor).max(f64::MIN_POSITIVE)).collect();
    Noise { sigma_n, common_factor: None, description }
}

fn from_specimens(m: &Measurement) -> Noise {
    let n = m.specimens_n.len();
    let amplitudes = common_factor::amplitudes(m);
    let residuals = m.specimens_n.iter().zip(&amplitudes);
    let sum: f64 =
        residuals.map(|(s, a)| s.iter().zip(&m.force_n).map(|(f, b)| (f - a * b).powi(2)).sum::<f64>()).sum();
    // Each specimen spends one degree of freedom on its amplitude.
    let white = (sum / (n as f64 * (m.len() as f64 - 1.0))).sqrt();
    let scatter = standard_deviation(&amplitudes);
    let sigma_n = m.force_n.iter().map(|&f| median_deviation(&amplitudes, f, white)).collect();
    let common_factor = MEDIAN_OVER_MEAN * scatter / (n as f64).sqrt();
    let description = format!(
        "median of {n} specimens: white noise {:.3} mN per specimen; a factor common to all points of a \
         specimen scatters by {:.1} %, so the height of the median is known to {:.1} %",
        white * 1e3,
        scatter * 100.0,
        common_factor * 100.0
    );
    Noise { sigma_n, common_factor: Some(common_factor), description }
}

/// Standard deviation of `median_k(a_k f + white noise)`: between white / sqrt(2) (only the middle two
/// specimens speak, because the amplitudes order them) and 1.25 white / sqrt(n) (all speak).
fn median_deviation(amplitudes: &[f64], force: f64, white: f64) -> f64 {
    let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
    let draw = |_| {
        let mut values: Vec<f64> = amplitudes.iter().map(|a| a * force + white * random.normal()).collect();
        median(&mut values)
    };
    standard_deviation(&(0..DRAWS).map(draw).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten specimens that differ by a factor (sd `scatter`) and by white noise of 0.07 mN.
    fn measurement(scatter: f64) -> Measurement {
        let mut normal = Random::new(7);
        let truth: Vec<f64> =
            (0..300).map(|i| if i < 100 { 0.0 } else { 5e-3 + 1e-5 * f64::from(i) }).collect();
        let specimens: Vec<Vec<f64>> = (0..10)
            .map(|_| {
                let factor = 1.0 + scatter * normal.normal();
                truth.iter().map(|f| factor * f + 0.07e-3 * normal.normal()).collect()
            })
            .collect();
        let force_n =
            (0..300).map(|i| median(&mut specimens.iter().map(|s| s[i]).collect::<Vec<_>>())).collect();
        let line = |i| f64::from(i);
        Measurement {
            time_s: (0..300).map(line).collect(),
            displacement_m: vec![1e-3; 300],
            force_n,
            specimens_n: specimens,
            ..Measurement::default()
        }
    }

    #[test]
    fn white_noise_and_common_factor_are_separated() {
        let noise = NoiseModel::Auto.of(&measurement(0.12), None).unwrap();
        let common = noise.common_factor.unwrap();
        assert!((0.03..0.07).contains(&common), "{common}");
        // Off contact all ten specimens speak, in contact the middle two.
        let (off, on) = (noise.sigma_n[50], noise.sigma_n[250]);
        assert!((0.022e-3..0.032e-3).contains(&off), "{off}");
        assert!((0.040e-3..0.056e-3).contains(&on), "{on}");
    }

    #[test]
    fn without_scatter_every_point_is_as_good() {
        let noise = NoiseModel::Specimens.of(&measurement(0.0), None).unwrap();
        let (off, on) = (noise.sigma_n[50], noise.sigma_n[250]);
        assert!((on / off - 1.0).abs() < 0.15, "{off} {on}");
        assert!(noise.common_factor.unwrap() < 1e-3);
    }

    #[test]
    fn models_say_what_they_miss() {
        let mut m = measurement(0.1);
        m.specimens_n.clear();
        assert!(NoiseModel::Specimens.of(&m, None).is_err());
        assert!(NoiseModel::Spread.of(&m, None).is_err());
        assert!(NoiseModel::Auto.of(&m, None).unwrap().sigma_n.is_empty());
        m.spread_n = Some(vec![1e-3; 300]);
        let of_one = NoiseModel::Auto.of(&m, None).unwrap().sigma_n[0];
        let of_ten = NoiseModel::Auto.of(&m, Some(10)).unwrap().sigma_n[0];
        assert!((of_ten / of_one - MEDIAN_OVER_MEAN / 10f64.sqrt()).abs() < 1e-12);
    }
}
