//! What the user says about the files: the answers to what a file leaves open.

use super::header::Quantity;
use super::number::DecimalMark;
use crate::units::{Dimension, Unit, parse_quantity};
use clap::{Args, ValueEnum};
use std::str::FromStr;

/// How measurement files are to be read, where they do not say it themselves.
#[derive(Debug, Clone, Default, PartialEq, Args)]
#[command(next_help_heading = "Reading the files")]
pub struct Reading {
    /// Column of time, displacement or force, by its name or number, with its unit where the file has none, e.g.
    /// force=Fz:N, time=1:s, time=Clock:h:m:s (repeatable)
    #[arg(long = "column", value_name = "QUANTITY=NAME[:UNIT]")]
    pub columns: Vec<ColumnChoice>,
    /// Reverse signs: displacement is positive into the sample, force positive when it is pressed [bare: both]
    #[arg(long, value_enum, value_name = "QUANTITY", num_args = 0..=1, require_equals = true,
        default_missing_value = "both")]
    pub flip: Option<Flip>,
    /// Where the sample's surface is: contact (where the force begins to rise), first (the first sample), fit (unknown,
    /// found by `identify` with the rest), or a value in the file's coordinate, e.g. 12.34mm
    #[arg(long, value_name = "contact|first|fit|VALUE", allow_hyphen_values = true)]
    pub zero: Option<Zero>,
    /// What the load cell reads without load: off-contact (the mean before contact), first, none, fit (unknown, found by
    /// `identify` with the rest), or a value, e.g. 1.2mN
    #[arg(long, value_name = "off-contact|first|none|fit|VALUE", allow_hyphen_values = true)]
    pub tare: Option<Tare>,
    /// The decimal mark, where `1,234` may be either
    #[arg(long, value_enum, value_name = "MARK")]
    pub decimal: Option<DecimalMark>,
}

/// A column that the user names.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnChoice {
    /// What it holds.
    pub quantity: Quantity,
    /// Its name in the header, or its number from 1.
    pub name: String,
    /// Its unit, if given.
    pub unit: Option<String>,
}

/// Which signs are reversed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Flip {
    /// That of the displacement.
    Displacement,
    /// That of the force.
    Force,
    /// Both.
    Both,
    /// None: as they are.
    None,
}

/// The surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Zero {
    /// Where the force begins to rise.
    Contact,
    /// Where the file begins.
    First,
    /// An unknown of the fit, sought around where the force begins to rise.
    Fit,
    /// At this displacement (m), in the file's coordinate.
    At(f64),
}

/// The load cell's zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tare {
    /// The mean before contact.
    OffContact,
    /// The first sample.
    First,
    /// Nothing is taken off.
    None,
    /// An unknown of the fit, sought around the mean before contact.
    Fit,
    /// This force (N), in the file's sign.
    At(f64),
}

impl Reading {
    /// The option that asks for an unknown of a fit, where there is one.
    pub fn fitted(&self) -> Option<&'static str> {
        match (self.zero, self.tare) {
            (Some(Zero::Fit), _) => Some("--zero fit"),
            (_, Some(Tare::Fit)) => Some("--tare fit"),
            _ => None,
        }
    }
}

impl FromStr for ColumnChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "write time=NAME, displacement=NAME or force=NAME, with :UNIT after it if need be";
        let (quantity, rest) = text.split_once('=').ok_or(FORM)?;
        let (quantity, dimension) = match quantity.trim() {
            "time" => (Quantity::Time, Dimension::Time),
            "displacement" => (Quantity::Displacement, Dimension::Length),
            "force" => (Quantity::Force, Dimension::Force),
            other => return Err(format!("`{other}` is no quantity; {FORM}")),
        };
        let is_unit = |unit: &str| {
            let clock = quantity == Quantity::Time && ["h:m:s", "m:s"].contains(&unit);
            clock || Unit::parse(unit).is_some_and(|u| u.dimension == dimension)
        };
        // Names may hold colons: only what is a unit is one.
        let split = rest.match_indices(':').find(|(at, _)| is_unit(rest[at + 1..].trim()));
        let (name, unit) = match split {
            Some((at, _)) => (&rest[..at], Some(rest[at + 1..].trim().to_owned())),
            None => (rest, None),
        };
        if name.trim().is_empty() {
            return Err(FORM.to_owned());
        }
        Ok(Self { quantity, name: name.trim().to_owned(), unit })
    }
}

impl FromStr for Zero {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "contact" => Ok(Self::Contact),
            "first" => Ok(Self::First),
            "fit" => Ok(Self::Fit),
            value => with_unit(value, Dimension::Length, "12.34mm").map(Self::At),
        }
    }
}

impl FromStr for Tare {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "off-contact" => Ok(Self::OffContact),
            "first" => Ok(Self::First),
            "none" => Ok(Self::None),
            "fit" => Ok(Self::Fit),
            value => with_unit(value, Dimension::Force, "1.2mN").map(Self::At),
        }
    }
}

fn with_unit(text: &str, dimension: Dimension, example: &str) -> Result<f64, String> {
    let value = parse_quantity(text, Some(dimension)).map_err(|e| e.to_string())?;
    if value != 0.0 && text.trim().parse::<f64>().is_ok() {
        return Err(format!("`{text}` has no unit; write for example {example}"));
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_named_with_or_without_a_unit() {
        let choice = |text: &str| ColumnChoice::from_str(text);
        let one = choice("force=Fz:N").unwrap();
        assert_eq!(
            (one.quantity, one.name.as_str(), one.unit.as_deref()),
            (Quantity::Force, "Fz", Some("N"))
        );
        assert_eq!(choice("time=Clock:h:m:s").unwrap().unit.as_deref(), Some("h:m:s"));
        let colon = choice("displacement=Ch 1: Position").unwrap();
        assert_eq!((colon.name.as_str(), colon.unit), ("Ch 1: Position", None));
        for bad in ["force", "mood=x", "force=", "force=:N"] {
            assert!(choice(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn zeros_and_tares_need_units() {
        assert_eq!("contact".parse(), Ok(Zero::Contact));
        assert_eq!("-2.5mm".parse(), Ok(Zero::At(-2.5e-3)));
        assert!("12.34".parse::<Zero>().unwrap_err().contains("has no unit"));
        assert!("3mN".parse::<Zero>().is_err());
        assert_eq!("2gf".parse(), Ok(Tare::At(2.0 * 9.806_65e-3)));
    }
}
