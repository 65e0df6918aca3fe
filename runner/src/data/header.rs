//! Which column holds what, in which unit. Lenient in spelling, never silently: every reading that is not
//! the canonical one leaves a note.

use super::error::Problem;
use crate::units::{Dimension, Unit, known_units};
use poropunch::variables::{self, Causality};
use serde::{Deserialize, Serialize};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// Time.
    Time,
    /// Displacement of the punch, positive into the sample.
    Displacement,
    /// Force, or the median force of the specimens.
    Force,
    /// Standard deviation of the force among the specimens.
    ForceStd,
    /// Lower quartile of the force among the specimens.
    ForceQ25,
    /// Upper quartile of the force among the specimens.
    ForceQ75,
    /// Force of one specimen.
    SpecimenForce,
    /// Name of the specimen that the row belongs to.
    Specimen,
    /// Written by `simulate`, not needed from a measurement.
    Unused,
}

/// A column that was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// As the header spells it.
    pub name: String,
    /// What it holds.
    pub quantity: Quantity,
    /// Multiplies its values to make them SI.
    pub factor: f64,
    /// A clock instead of a number: `h:m:s`, or `m:s` where true.
    pub clock: Option<bool>,
    /// In this project's own spelling, which promises sign and zero.
    pub own: bool,
    /// How it was read, when that is not obvious.
    pub note: Option<String>,
}

/// Canonical stem, other accepted stems, what it is, its dimension, canonical name.
type Row = (&'static str, &'static [&'static str], Quantity, Dimension, &'static str);

const STEMS: &[Row] = &[
    ("time", &["t"], Quantity::Time, Dimension::Time, "time_s"),
    ("displacement", &["depth", "indentation"], Quantity::Displacement, Dimension::Length, "displacement_mm"),
    ("force", &["f", "load", "force_median"], Quantity::Force, Dimension::Force, "force_mN"),
    ("force_std", &["force_sd"], Quantity::ForceStd, Dimension::Force, "force_std_mN"),
    ("force_q25", &[], Quantity::ForceQ25, Dimension::Force, "force_q25_mN"),
    ("force_q75", &[], Quantity::ForceQ75, Dimension::Force, "force_q75_mN"),
    ("force_solid", &[], Quantity::Unused, Dimension::Force, "force_solid_mN"),
    ("force_fluid", &[], Quantity::Unused, Dimension::Force, "force_fluid_mN"),
];

/// Reads one column name.
///
/// # Errors
/// When the name, or its unit, is unknown, missing or of another quantity.
pub fn read_column(name: &str) -> Result<Column, Problem> {
    let trimmed = name.trim();
    let lower = trimmed.to_lowercase();
    let column = |quantity, factor, note| Column {
        name: trimmed.to_owned(),
        quantity,
        factor,
        clock: None,
        own: true,
        note,
    };
    if lower == "specimen" {
        return Ok(column(Quantity::Specimen, 1.0, None));
    }
    if is_specimen_name(&lower) {
        return Ok(column(Quantity::SpecimenForce, 1e-3, None));
    }
    if is_model_output(trimmed) {
        return Ok(column(Quantity::Unused, 1.0, None));
    }
    let (stem, unit) = split_unit(trimmed);
    let stem = stem.to_lowercase();
    let (row, unit) = match find(&stem) {
        Some(row) => (row, unit),
        // `force_mN`: what follows the last underscore is the unit.
        None => {
            let (head, tail) = stem_and_suffix(trimmed).ok_or(Problem::UnknownColumn)?;
            (find(&head.to_lowercase()).ok_or(Problem::UnknownColumn)?, Some(tail))
        }
    };
    let (canonical, _, quantity, dimension, example) = *row;
    let text = unit.ok_or(Problem::MissingUnit { example })?;
    let found = Unit::parse(text).filter(|u| u.dimension == dimension).ok_or_else(|| Problem::WrongUnit {
        unit: text.to_owned(),
        quantity: canonical,
        known: known_units(dimension),
    })?;
    let note = (trimmed != format!("{canonical}_{}", found.symbol))
        .then(|| format!("column `{trimmed}` read as {canonical} in {}", found.symbol));
    Ok(column(quantity, found.factor, note))
}

/// `s01`, `s2`, `specimen_3`: forces of single specimens, in mN.
fn is_specimen_name(lower: &str) -> bool {
    let digits = lower.strip_prefix("specimen_").or_else(|| lower.strip_prefix('s'));
    digits.is_some_and(|d| !d.is_empty() && d.chars().all(|c| c.is_ascii_digit()))
}

/// A diagnostic that `simulate --record` writes, e.g. `stored_energy_uJ`: its files can be read again.
fn is_model_output(name: &str) -> bool {
    let outputs = variables::table().iter().filter(|v| v.causality == Causality::Output);
    outputs.filter(|v| v.name != "force").filter_map(|v| Some((v.name, v.unit()?))).any(|(output, unit)| {
        name.strip_prefix(output).and_then(|rest| rest.strip_prefix('_')) == Some(unit.display)
    })
}

fn find(stem: &str) -> Option<&'static Row> {
    STEMS.iter().find(|(canonical, others, ..)| *canonical == stem || others.contains(&stem))
}

/// `force (mN)` and `force (mN)` into name and unit.
fn split_unit(name: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((stem, rest)) = name.split_once(open)
            && let Some(unit) = rest.trim_end().strip_suffix(close)
        {
            return (stem.trim().trim_end_matches('_'), Some(unit.trim()));
        }
    }
    (name, None)
}

fn stem_and_suffix(name: &str) -> Option<(&str, &str)> {
    name.rsplit_once('_').or_else(|| name.rsplit_once(' '))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_the_same_column() {
        for name in ["force_mN", "Force [mN]", "FORCE (mN)", "load_mN", "force_mn", " force mN "] {
            let column = read_column(name).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!((column.quantity, column.factor), (Quantity::Force, 1e-3), "{name}");
            assert_eq!(column.note.is_none(), name == "force_mN", "{name}: {:?}", column.note);
        }
        assert_eq!(read_column("displacement_um").map(|c| c.factor), Ok(1e-6));
        assert_eq!(read_column("t [ms]").map(|c| c.factor), Ok(1e-3));
        assert_eq!(read_column("force_std_N").map(|c| c.quantity), Ok(Quantity::ForceStd));
        assert_eq!(read_column("stored_energy_uJ").map(|c| c.quantity), Ok(Quantity::Unused));
        assert_eq!(read_column("s07").map(|c| c.quantity), Ok(Quantity::SpecimenForce));
    }

    #[test]
    fn what_is_not_understood_is_not_guessed() {
        assert_eq!(read_column("force"), Err(Problem::MissingUnit { example: "force_mN" }));
        assert_eq!(read_column("temperature_K"), Err(Problem::UnknownColumn));
        assert_eq!(read_column("stress"), Err(Problem::UnknownColumn));
        assert!(matches!(read_column("force_mm"), Err(Problem::WrongUnit { .. })));
        assert!(matches!(read_column("force_MN"), Err(Problem::WrongUnit { .. })));
        assert!(matches!(read_column("displacement [furlong]"), Err(Problem::WrongUnit { .. })));
    }
}
