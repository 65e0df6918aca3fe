//! Water content (Eq. 1) and the volume fraction of solid that the model needs.

use crate::data::Estimate;
use crate::data::measurement::standard_deviation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use thiserror::Error;

/// A number as given on the command line, with its standard deviation if there is one: `0.968` or `0.968+-0.002`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertain {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub sigma: Option<f64>,
}

/// A water content that cannot be.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WaterError {
    /// Not `VALUE` or `VALUE+-SD`.
    #[error("`{0}` is neither VALUE nor VALUE+-SD, for example 0.968+-0.002")]
    NotANumber(String),
    /// Not between none and all.
    #[error("a water fraction of {0} is not between 0 and 1: give a fraction, not per cent")]
    Fraction(f64),
    /// A dry sample that weighs as much as the wet one.
    #[error("wet mass {wet} g and dry mass {dry} g: the wet one must be the larger, both positive")]
    Masses {
        /// Wet (g).
        wet: f64,
        /// Dry (g).
        dry: f64,
    },
    /// Wet and dry masses do not belong together.
    #[error("{wet} wet masses but {dry} dry ones: give both for every specimen, in the same order")]
    Unpaired {
        /// Number of wet masses.
        wet: usize,
        /// Number of dry masses.
        dry: usize,
    },
    /// Not a density.
    #[error("a density of {0} kg/m^3 is not positive")]
    Density(f64),
}

impl FromStr for Uncertain {
    type Err = WaterError;

    fn from_str(text: &str) -> Result<Self, WaterError> {
        let bad = || WaterError::NotANumber(text.to_owned());
        let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(bad);
        match text.split_once("+-").or_else(|| text.split_once('±')) {
            None => Ok(Self { value: number(text)?, sigma: None }),
            Some((value, sigma)) => {
                let sigma = number(sigma)?;
                if sigma < 0.0 {
                    return Err(bad());
                }
                Ok(Self { value: number(value)?, sigma: Some(sigma) })
            }
        }
    }
}

/// What was weighed, or the fraction that was computed from it.
#[derive(Debug, Clone, PartialEq)]
pub enum WaterMeasurement {
    /// Wet and dry masses (g), one of each per specimen.
    Masses {
        /// With its water.
        wet: Vec<Uncertain>,
        /// Without.
        dry: Vec<Uncertain>,
    },
    /// Mass fraction of water (-).
    Fraction(Uncertain),
}

/// Water and solid of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WaterContent {
    /// Mass fraction of water, (m_wet - m_dry) / m_wet (-).
    pub water_fraction: Estimate,
    /// Volume fraction of solid `material.n0s` (-).
    pub n0s: Estimate,
    /// Whether an uncertainty was given or could be told from several specimens.
    pub uncertainty_known: bool,
    /// Specimens that were weighed.
    pub specimens: usize,
    /// Density of the solid (kg/m^3).
    pub solid_density: f64,
    /// Density of water (kg/m^3).
    pub water_density: f64,
}

/// Eq. 1 and n0S. With equal densities, as the paper takes them, n0S is one minus the water fraction.
///
/// # Errors
/// When the numbers are not those of a wet and a dry sample.
pub fn water_content(
    measured: &WaterMeasurement,
    solid_density: f64,
    water_density: f64,
) -> Result<WaterContent, WaterError> {
    for density in [solid_density, water_density] {
        if density.is_nan() || density <= 0.0 {
            return Err(WaterError::Density(density));
        }
    }
    let (w, known, specimens) = match measured {
        WaterMeasurement::Fraction(w) => {
            (Estimate { value: w.value, sigma: w.sigma.unwrap_or(0.0) }, w.sigma.is_some(), 1)
        }
        WaterMeasurement::Masses { wet, dry } => from_masses(wet, dry)?,
    };
    if !(0.0..=1.0).contains(&w.value) {
        return Err(WaterError::Fraction(w.value));
    }
    // Volumes of solid and water in a unit of mass.
    let (solid, water) = ((1.0 - w.value) / solid_density, w.value / water_density);
    let value = solid / (solid + water);
    let slope = 1.0 / (solid_density * water_density * (solid + water).powi(2));
    Ok(WaterContent {
        water_fraction: w,
        n0s: Estimate { value, sigma: slope * w.sigma },
        uncertainty_known: known,
        specimens,
        solid_density,
        water_density,
    })
}

fn from_masses(wet: &[Uncertain], dry: &[Uncertain]) -> Result<(Estimate, bool, usize), WaterError> {
    if wet.len() != dry.len() || wet.is_empty() {
        return Err(WaterError::Unpaired { wet: wet.len(), dry: dry.len() });
    }
    let (mut fractions, mut square) = (Vec::new(), 0.0);
    for (wet, dry) in wet.iter().zip(dry) {
        if dry.value <= 0.0 || wet.value <= dry.value {
            return Err(WaterError::Masses { wet: wet.value, dry: dry.value });
        }
        fractions.push(1.0 - dry.value / wet.value);
        let of_wet = dry.value / wet.value.powi(2) * wet.sigma.unwrap_or(0.0);
        square += of_wet.powi(2) + (dry.sigma.unwrap_or(0.0) / wet.value).powi(2);
    }
    let n = fractions.len() as f64;
    let value = fractions.iter().sum::<f64>() / n;
    let given = square.sqrt() / n;
    let known = wet.iter().chain(dry).any(|m| m.sigma.is_some()) || fractions.len() > 1;
    // The scatter of specimens holds the error of weighing already.
    let sigma = given.max(if fractions.len() > 1 { standard_deviation(&fractions) / n.sqrt() } else { 0.0 });
    Ok((Estimate { value, sigma }, known, fractions.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fraction(text: &str) -> WaterMeasurement {
        WaterMeasurement::Fraction(text.parse().unwrap())
    }

    #[test]
    fn the_papers_water_fraction_gives_its_n0s() {
        let content = water_content(&fraction("0.968+-0.002"), 1000.0, 1000.0).unwrap();
        assert!((content.n0s.value - 0.032).abs() < 1e-12 && (content.n0s.sigma - 0.002).abs() < 1e-12);
    }

    #[test]
    fn a_dense_solid_takes_less_room() {
        // 32 g of solid of 1.5 g/ml in 21.33 ml, 968 ml of water.
        let content = water_content(&fraction("0.968+-0.002"), 1500.0, 1000.0).unwrap();
        assert!((content.n0s.value - 21.333_333 / 989.333_333).abs() < 1e-6, "{content:?}");
        let shifted = water_content(&fraction("0.9681"), 1500.0, 1000.0).unwrap();
        let slope = (content.n0s.value - shifted.n0s.value) / 1e-4;
        assert!((content.n0s.sigma / 0.002 / slope - 1.0).abs() < 1e-3);
    }

    #[test]
    fn masses_give_fraction_and_uncertainty() {
        let masses = |wet: &[&str], dry: &[&str]| {
            let all = |texts: &[&str]| texts.iter().map(|t| t.parse().unwrap()).collect();
            water_content(&WaterMeasurement::Masses { wet: all(wet), dry: all(dry) }, 1000.0, 1000.0)
        };
        let one = masses(&["10+-0.1"], &["0.32+-0.01"]).unwrap();
        assert!((one.water_fraction.value - 0.968).abs() < 1e-12);
        assert!(
            (one.water_fraction.sigma - (0.0032_f64.powi(2) * 0.01 + 0.001_f64.powi(2)).sqrt()).abs() < 1e-9
        );
        let three = masses(&["10", "10", "10"], &["0.30", "0.32", "0.34"]).unwrap();
        assert!((three.water_fraction.sigma - 0.002 / 3f64.sqrt()).abs() < 1e-9 && three.uncertainty_known);
        assert!(matches!(masses(&["10", "9"], &["0.3"]), Err(WaterError::Unpaired { .. })));
        assert!(matches!(masses(&["0.3"], &["10"]), Err(WaterError::Masses { .. })));
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(matches!(water_content(&fraction("96.8"), 1e3, 1e3), Err(WaterError::Fraction(_))));
        assert!(matches!(water_content(&fraction("0.9"), 0.0, 1e3), Err(WaterError::Density(_))));
        assert!("much".parse::<Uncertain>().is_err() && "0.9+-x".parse::<Uncertain>().is_err());
    }
}
