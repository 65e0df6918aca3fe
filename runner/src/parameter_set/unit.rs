//! Units as an SSV file defines them, by powers of the base units of SI.

use crate::units::{Dimension, Unit};
use roxmltree::Node;

/// A unit that a file defines: `value_si = factor * value + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Definition {
    /// Exponents of kg, m and s.
    pub exponents: (i8, i8, i8),
    /// Whether other base units (A, K, mol, cd, rad) are in it.
    pub others: bool,
    /// Multiplies a value.
    pub factor: f64,
    /// Added to it.
    pub offset: f64,
}

impl Definition {
    /// Reads a `BaseUnit`.
    ///
    /// # Errors
    /// An attribute that is no number.
    pub fn read(base: Node) -> Result<Self, String> {
        let number = |name: &str, absent: f64| match base.attribute(name) {
            None => Ok(absent),
            Some(text) => text.trim().parse::<f64>().map_err(|_| format!("{name}=\"{text}\" is no number")),
        };
        let exponent = |name: &str| {
            let value = number(name, 0.0)?;
            let is_whole = value.fract() == 0.0 && value.abs() <= 9.0;
            if is_whole { Ok(value as i8) } else { Err(format!("{name}=\"{value}\" is no exponent")) }
        };
        let others = ["A", "K", "mol", "cd", "rad"];
        Ok(Self {
            exponents: (exponent("kg")?, exponent("m")?, exponent("s")?),
            others: others
                .iter()
                .map(|name| exponent(name))
                .collect::<Result<Vec<_>, _>>()?
                .iter()
                .any(|e| *e != 0),
            factor: number("factor", 1.0)?,
            offset: number("offset", 0.0)?,
        })
    }

    /// Whether it says what the unit of this name is.
    pub fn is(&self, unit: &Unit) -> bool {
        let same = (self.factor - unit.factor).abs() <= 1e-9 * unit.factor;
        !self.others && self.exponents == exponents(unit.dimension) && same && self.offset == 0.0
    }
}

/// Exponents of kg, m and s.
pub fn exponents(dimension: Dimension) -> (i8, i8, i8) {
    match dimension {
        Dimension::Length => (0, 1, 0),
        Dimension::Area => (0, 2, 0),
        Dimension::Volume => (0, 3, 0),
        Dimension::Time => (0, 0, 1),
        Dimension::Speed => (0, 1, -1),
        Dimension::Force => (1, 1, -2),
        Dimension::Pressure => (1, -1, -2),
        Dimension::Viscosity => (1, -1, -1),
        Dimension::Energy => (1, 2, -2),
        Dimension::Power => (1, 2, -3),
        Dimension::Number => (0, 0, 0),
    }
}
