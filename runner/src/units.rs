//! Units that people write, and their factors to SI.

use thiserror::Error;

/// What a unit measures; the name is that of the SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Length (m).
    Length,
    /// Area, permeability (m^2).
    Area,
    /// Volume (m^3).
    Volume,
    /// Time (s).
    Time,
    /// Speed (m/s).
    Speed,
    /// Force (N).
    Force,
    /// Pressure, stress, modulus (Pa).
    Pressure,
    /// Dynamic viscosity (Pa s).
    Viscosity,
    /// Energy (J).
    Energy,
    /// Power (W).
    Power,
    /// A number (-).
    Number,
}

/// A unit: `value_si = factor * value`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// How it is written in messages and headers.
    pub symbol: &'static str,
    /// What it measures.
    pub dimension: Dimension,
    /// Multiplies a value to make it SI.
    pub factor: f64,
}

macro_rules! units {
    ($($symbol:literal $dimension:ident $factor:expr;)*) => {
        &[$(Unit { symbol: $symbol, dimension: Dimension::$dimension, factor: $factor }),*]
    };
}

/// Every unit that is understood. The first of a dimension is its SI unit.
pub const UNITS: &[Unit] = units! {
    "m" Length 1.0; "cm" Length 1e-2; "mm" Length 1e-3; "um" Length 1e-6; "nm" Length 1e-9;
    "m^2" Area 1.0; "cm^2" Area 1e-4; "mm^2" Area 1e-6; "um^2" Area 1e-12;
    "m^3" Volume 1.0; "mm^3" Volume 1e-9; "ul" Volume 1e-9;
    "s" Time 1.0; "ms" Time 1e-3; "us" Time 1e-6; "min" Time 60.0; "h" Time 3600.0;
    "m/s" Speed 1.0; "mm/s" Speed 1e-3; "um/s" Speed 1e-6;
    "N" Force 1.0; "mN" Force 1e-3; "uN" Force 1e-6; "nN" Force 1e-9; "kN" Force 1e3;
    "gf" Force 9.806_65e-3; "kgf" Force 9.806_65;
    "Pa" Pressure 1.0; "hPa" Pressure 1e2; "kPa" Pressure 1e3; "MPa" Pressure 1e6; "GPa" Pressure 1e9;
    "Pa.s" Viscosity 1.0; "mPa.s" Viscosity 1e-3; "kPa.s" Viscosity 1e3;
    "J" Energy 1.0; "mJ" Energy 1e-3; "uJ" Energy 1e-6; "nJ" Energy 1e-9;
    "W" Power 1.0; "mW" Power 1e-3; "uW" Power 1e-6; "nW" Power 1e-9;
    "1" Number 1.0; "-" Number 1.0; "%" Number 1e-2;
};

/// A number with a unit that cannot be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnitError {
    /// The number itself.
    #[error("`{0}` does not start with a number (write for example 2.3e-9mm^2)")]
    NotANumber(String),
    /// A unit that is not in the table.
    #[error("unknown unit `{unit}`; known for this quantity: {known}")]
    Unknown {
        /// As written.
        unit: String,
        /// What would be understood.
        known: String,
    },
    /// A known unit of another quantity.
    #[error("`{unit}` is not a unit of {expected:?}; known: {known}")]
    WrongDimension {
        /// As written.
        unit: String,
        /// What was wanted.
        expected: Dimension,
        /// What would be understood.
        known: String,
    },
}

impl Unit {
    /// The unit written as `text`: `mm^2`, `mm2` and `mm²`, `um` and `µm`, `Pa.s`, `Pa s` and `Pa*s` are the same.
    ///
    /// Case matters (mN is not MN), except that an all-lower-case spelling is accepted when only one unit fits.
    pub fn parse(text: &str) -> Option<Self> {
        let text = normalised(text);
        let exact = UNITS.iter().find(|u| normalised(u.symbol) == text);
        if exact.is_some() {
            return exact.copied();
        }
        if text.is_empty() || text.chars().any(char::is_uppercase) {
            return None;
        }
        let mut lower = UNITS.iter().filter(|u| normalised(u.symbol).to_lowercase() == text);
        let first = lower.next().copied();
        if lower.next().is_some() { None } else { first }
    }

    /// The SI unit of a dimension.
    pub fn si(dimension: Dimension) -> Self {
        *UNITS.iter().find(|u| u.dimension == dimension).unwrap_or(&UNITS[0])
    }
}

/// Every unit of a dimension, as a list for messages.
pub fn known_units(dimension: Dimension) -> String {
    let symbols = UNITS.iter().filter(|u| u.dimension == dimension).map(|u| u.symbol);
    symbols.collect::<Vec<_>>().join(", ")
}

/// Reads `2.3e-9mm^2` or `2.3e-15` (SI then) into SI.
///
/// # Errors
/// When there is no number, or the unit is unknown or of another dimension.
pub fn parse_quantity(text: &str, dimension: Option<Dimension>) -> Result<f64, UnitError> {
    let text = text.trim();
    // The number is the longest prefix that parses: `1e-3m` must not stop at `1`.
    let split = (1..=text.len())
        .rev()
        .filter(|&n| text.is_char_boundary(n))
        .find(|&n| text[..n].trim().parse::<f64>().is_ok_and(f64::is_finite))
        .ok_or_else(|| UnitError::NotANumber(text.to_owned()))?;
    let value: f64 = text[..split].trim().parse().map_err(|_| UnitError::NotANumber(text.to_owned()))?;
    let unit = text[split..].trim();
    if unit.is_empty() {
        return Ok(value);
    }
    let known = || dimension.map_or_else(|| "none, give the bare SI value".to_owned(), known_units);
    let found =
        Unit::parse(unit).ok_or_else(|| UnitError::Unknown { unit: unit.to_owned(), known: known() })?;
    match dimension {
        Some(expected) if expected != found.dimension => {
            Err(UnitError::WrongDimension { unit: unit.to_owned(), expected, known: known() })
        }
        _ => Ok(value * found.factor),
    }
}

fn normalised(text: &str) -> String {
    text.trim()
        .chars()
        .filter_map(|c| match c {
            '^' => None,
            'µ' | 'μ' => Some('u'),
            '²' => Some('2'),
            '³' => Some('3'),
            ' ' | '*' | '·' => Some('.'),
            other => Some(other),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_one_unit_are_equal() {
        for text in ["mm^2", "mm2", "mm²"] {
            assert_eq!(Unit::parse(text).map(|u| u.factor), Some(1e-6), "{text}");
        }
        for text in ["Pa.s", "Pa s", "Pa*s", "pa.s"] {
            assert_eq!(Unit::parse(text).map(|u| u.dimension), Some(Dimension::Viscosity), "{text}");
        }
        assert_eq!(Unit::parse("µm").map(|u| u.factor), Some(1e-6));
    }

    #[test]
    fn case_is_forgiven_only_when_it_cannot_mislead() {
        assert_eq!(Unit::parse("mn").map(|u| u.factor), Some(1e-3));
        assert_eq!(Unit::parse("MN"), None);
        assert_eq!(Unit::parse("mpa").map(|u| u.factor), Some(1e6));
        assert_eq!(Unit::parse("furlong"), None);
    }

    #[test]
    fn quantities_convert_to_si() {
        assert_eq!(parse_quantity("2.3e-9mm^2", Some(Dimension::Area)), Ok(2.3e-9 * 1e-6));
        assert_eq!(parse_quantity("-217 Pa", Some(Dimension::Pressure)), Ok(-217.0));
        assert_eq!(parse_quantity("5e-1", None), Ok(0.5));
        assert!(matches!(
            parse_quantity("2 s", Some(Dimension::Area)),
            Err(UnitError::WrongDimension { .. })
        ));
        assert!(matches!(parse_quantity("2 furlong", None), Err(UnitError::Unknown { .. })));
        assert!(matches!(parse_quantity("fast", None), Err(UnitError::NotANumber(_))));
        assert!(matches!(parse_quantity("NaN", None), Err(UnitError::NotANumber(_))));
    }
}
