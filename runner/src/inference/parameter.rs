//! A parameter as the user knows it, and the variable that the optimiser sees instead.

use super::wording::significant;
use crate::fit::{Bounds, FitError};
use serde::{Deserialize, Serialize};

/// Unit in which people read a value that is SI inside.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unit {
    /// Symbol, e.g. `mm^2`; empty for a pure number.
    pub name: String,
    /// Size of one unit in SI.
    pub si: f64,
}

impl Unit {
    /// A unit of the given size in SI.
    pub fn new(name: &str, si: f64) -> Self {
        Self { name: name.to_owned(), si }
    }

    /// Converts an SI value for people.
    pub fn from_si(&self, value: f64) -> f64 {
        value / self.si
    }
}

/// Change of variable between a parameter and the optimiser's `x`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Transform {
    /// `x = ln |value|`; the sign is kept. Intervals then respect it by construction.
    Logarithmic {
        /// The parameter is negative.
        negative: bool,
    },
    /// `x = value / scale`, where the bounds allow both signs.
    Linear {
        /// One unit of x.
        scale: f64,
    },
}

/// A free parameter: name, unit, start and bounds, all values in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitParameter {
    /// Full name, e.g. `material.branch[1].mu`.
    pub name: String,
    /// Short symbol, e.g. `mu_1`.
    pub symbol: String,
    /// Unit for people.
    pub unit: Unit,
    /// Start value.
    pub start: f64,
    /// Lower bound of the value.
    pub lower: f64,
    /// Upper bound of the value.
    pub upper: f64,
    /// How the optimiser sees it.
    pub transform: Transform,
}

impl FitParameter {
    /// A parameter in log variables when its bounds have one sign, in linear ones otherwise.
    ///
    /// # Errors
    /// When a value is not finite, the bounds are not ordered, or the start lies outside.
    pub fn new(
        name: &str,
        symbol: &str,
        unit: Unit,
        start: f64,
        [lower, upper]: [f64; 2],
    ) -> Result<Self, FitError> {
        let refuse = |reason: String| Err(FitError::Parameter { name: name.to_owned(), reason });
        let shown =
            |v: f64| format!("{} {}", significant(unit.from_si(v), 4), unit.name).trim_end().to_owned();
        if ![start, lower, upper].iter().all(|v| v.is_finite()) {
            return refuse("start and bounds must be finite numbers".to_owned());
        }
        if lower >= upper {
            let (l, u) = (shown(lower), shown(upper));
            return refuse(format!("lower bound {l} is not below upper bound {u}; swap or widen them"));
        }
        if start < lower || start > upper {
            let (s, l, u) = (shown(start), shown(lower), shown(upper));
            return refuse(format!(
                "start {s} is outside its bounds [{l}, {u}]; move the start or widen the bounds"
            ));
        }
        let transform = if lower * upper > 0.0 {
            Transform::Logarithmic { negative: upper < 0.0 }
        } else {
            Transform::Linear { scale: upper - lower }
        };
        Ok(Self { name: name.to_owned(), symbol: symbol.to_owned(), unit, start, lower, upper, transform })
    }

    /// The optimiser's variable for a value (SI).
    pub fn to_internal(&self, value: f64) -> f64 {
        match self.transform {
            Transform::Logarithmic { .. } => value.abs().ln(),
            Transform::Linear { scale } => value / scale,
        }
    }

    /// The value (SI) for the optimiser's variable.
    pub fn to_value(&self, x: f64) -> f64 {
        match self.transform {
            Transform::Logarithmic { negative } => x.exp() * if negative { -1.0 } else { 1.0 },
            Transform::Linear { scale } => x * scale,
        }
    }

    /// Change of the value (SI) per unit of the optimiser's variable.
    pub fn slope(&self, x: f64) -> f64 {
        match self.transform {
            Transform::Logarithmic { .. } => self.to_value(x),
            Transform::Linear { scale } => scale,
        }
    }

    /// Bounds in the optimiser's variable, ascending.
    pub fn internal_bounds(&self) -> (f64, f64) {
        let (a, b) = (self.to_internal(self.lower), self.to_internal(self.upper));
        (a.min(b), a.max(b))
    }

    /// Relative change of the value per unit of x (1 in log variables).
    pub fn relative_slope(&self, x: f64) -> f64 {
        match self.transform {
            Transform::Logarithmic { .. } => 1.0,
            Transform::Linear { .. } => 1.0 / x.abs().max(1e-12),
        }
    }
}

/// Start vector and bounds of the optimiser's variables.
///
/// # Errors
/// When the bounds of a parameter are not ordered.
pub fn internal_problem(parameters: &[FitParameter]) -> Result<(Vec<f64>, Bounds), FitError> {
    let (lower, upper) = parameters.iter().map(FitParameter::internal_bounds).unzip();
    let start = parameters.iter().map(|p| p.to_internal(p.start)).collect();
    Ok((start, Bounds::new(lower, upper)?))
}

/// Values (SI) at a point of the optimiser.
pub fn values_at(parameters: &[FitParameter], x: &[f64]) -> Vec<f64> {
    parameters.iter().zip(x).map(|(p, &x)| p.to_value(x)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn negative_parameters_keep_their_sign_and_order() {
        let mu = FitParameter::new("mu", "mu", Unit::new("Pa", 1.0), -217.0, [-1000.0, -1.0]).unwrap();
        assert_eq!(mu.internal_bounds(), (0.0, 1000f64.ln()));
        assert_relative_eq!(mu.to_value(mu.to_internal(-217.0)), -217.0, max_relative = 1e-14);
    }

    #[test]
    fn slopes_are_those_of_the_value() {
        let mu = FitParameter::new("mu", "mu", Unit::new("Pa", 1.0), -217.0, [-1000.0, -1.0]).unwrap();
        let offset = FitParameter::new("o", "o", Unit::new("mm", 1e-3), 0.0, [-1.0, 3.0]).unwrap();
        for (p, x) in [(mu, 2.0), (offset, 0.3)] {
            let numeric = (p.to_value(x + 1e-6) - p.to_value(x - 1e-6)) / 2e-6;
            assert_relative_eq!(p.slope(x), numeric, max_relative = 1e-8);
        }
    }

    #[test]
    fn bounds_of_both_signs_are_linear() {
        let offset = FitParameter::new("o", "o", Unit::new("mm", 1e-3), 0.0, [-1.0, 3.0]).unwrap();
        assert_eq!(offset.transform, Transform::Linear { scale: 4.0 });
        assert_relative_eq!(offset.to_value(offset.to_internal(1e-4)), 1e-4, max_relative = 1e-14);
    }

    #[test]
    fn a_start_outside_names_parameter_values_and_remedy() {
        let unit = Unit::new("mm^2", 1e-6);
        let error = FitParameter::new("material.permeability", "K0", unit, 1.0, [1e-20, 1e-8]).unwrap_err();
        let text = error.to_string();
        for part in ["material.permeability", "start 1.000e6 mm^2", "[1.000e-14 mm^2", "widen"] {
            assert!(text.contains(part), "{text}");
        }
    }
}
