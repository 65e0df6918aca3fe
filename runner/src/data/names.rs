//! What laboratories call their columns: stems of names, and the unit in a name.

use super::header::Quantity;
use crate::units::{Dimension, Unit};

/// How sure a name is: of two columns for one quantity the surer one is taken, of two equally sure ones none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// In this project's own spelling.
    Own,
    /// Says what it is.
    Plain,
    /// May be something beside it.
    Loose,
}

use Quantity::{Displacement, Force, Time};
use Rank::{Loose, Plain};

const NAMES: &[(&str, Quantity, Rank)] = &[
    ("time", Time, Plain),
    ("elapsed time", Time, Plain),
    ("test time", Time, Plain),
    ("zeit", Time, Plain),
    ("prüfzeit", Time, Plain),
    ("temps", Time, Plain),
    ("t", Time, Loose),
    ("run time", Time, Loose),
    ("step time", Time, Loose),
    ("scan time", Time, Loose),
    ("total time", Time, Loose),
    ("displacement", Displacement, Plain),
    ("axial displacement", Displacement, Plain),
    ("indentation", Displacement, Plain),
    ("indentation depth", Displacement, Plain),
    ("depth", Displacement, Plain),
    ("disp", Displacement, Plain),
    ("axial disp", Displacement, Plain),
    ("extension", Displacement, Plain),
    ("position", Displacement, Plain),
    ("standardweg", Displacement, Plain),
    ("weg", Displacement, Plain),
    ("traversenweg", Displacement, Loose),
    ("deformation", Displacement, Loose),
    ("crosshead", Displacement, Loose),
    ("pos", Displacement, Loose),
    ("stroke", Displacement, Loose),
    ("gap", Displacement, Loose),
    ("piezo", Displacement, Loose),
    ("z", Displacement, Loose),
    ("force", Force, Plain),
    ("load", Force, Plain),
    ("axial force", Force, Plain),
    ("normal force", Force, Plain),
    ("standardkraft", Force, Plain),
    ("prüfkraft", Force, Plain),
    ("kraft", Force, Plain),
    ("fz", Force, Plain),
    ("fn", Force, Loose),
    ("f", Force, Loose),
];

/// What a name of a column means, with its unit as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Meaning {
    /// What it holds.
    pub quantity: Quantity,
    /// How sure that is.
    pub rank: Rank,
    /// The unit in the name.
    pub unit: Option<String>,
}

/// The meaning of a name that a laboratory's program wrote.
pub fn meaning(name: &str) -> Option<Meaning> {
    splits(name).into_iter().find_map(|(stem, unit)| {
        let stem = plain(stem);
        let (_, quantity, rank) = *NAMES.iter().find(|(known, ..)| *known == stem)?;
        Some(Meaning { quantity, rank, unit: unit.map(|u| u.trim().to_owned()) })
    })
}

/// The dimension of a quantity's unit.
pub fn dimension(quantity: Quantity) -> Option<Dimension> {
    match quantity {
        Time => Some(Dimension::Time),
        Displacement => Some(Dimension::Length),
        Quantity::Specimen | Quantity::Unused => None,
        _ => Some(Dimension::Force),
    }
}

/// A unit as machines spell it: `Sec`, `(mm)`, `[N]`, `g` for gram-force.
pub fn unit(text: &str, dimension: Dimension) -> Option<Unit> {
    let text = text.trim().trim_matches(['(', ')', '[', ']']).trim();
    let text = match (text.to_lowercase().as_str(), dimension) {
        ("sec" | "secs" | "seconds" | "sek" | "sekunden", Dimension::Time) => "s",
        ("minutes" | "minuten", Dimension::Time) => "min",
        ("hours" | "std", Dimension::Time) => "h",
        ("micron" | "microns", Dimension::Length) => "um",
        ("g" | "gram-force" | "grams", Dimension::Force) => "gf",
        ("newton" | "newtons", Dimension::Force) => "N",
        _ => text,
    };
    Unit::parse(text).filter(|u| u.dimension == dimension)
}

/// Whether a field is a unit of anything: what a row of units is made of.
pub fn is_unit(text: &str) -> bool {
    let bare = text.trim().trim_matches(['(', ')', '[', ']']).trim();
    let known =
        [Dimension::Time, Dimension::Length, Dimension::Force].iter().any(|d| unit(bare, *d).is_some());
    known
        || Unit::parse(bare).is_some()
        || ["h:m:s", "hh:mm:ss", "m:s", "°c", "°"].contains(&bare.to_lowercase().as_str())
}

/// Ways to part a name from its unit, and the whole name.
fn splits(name: &str) -> Vec<(&str, Option<&str>)> {
    let name = name.trim().trim_matches('"').trim();
    let mut all = Vec::new();
    let closed = name.strip_suffix([')', ']']);
    if let Some((stem, unit)) = closed.and_then(|n| n.rsplit_once(['(', '['])) {
        all.push((stem, Some(unit)));
    }
    for mark in [", ", ",", " in ", "/", "_", " "] {
        if let Some((stem, unit)) = name.rsplit_once(mark)
            && is_unit(unit)
        {
            all.push((stem, Some(unit)));
        }
    }
    all.push((name, None));
    all
}

/// A stem in lower case, without underscores, a channel's number or the axis in brackets.
fn plain(stem: &str) -> String {
    let lower = stem.to_lowercase().replace(['_', '-', '.'], " ");
    let without_axis = ["(z)", "[z]", "(axial)"].iter().fold(lower, |text, axis| text.replace(axis, ""));
    let words = without_axis.split_whitespace().collect::<Vec<_>>().join(" ");
    words.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_machines_are_understood() {
        for (name, quantity, unit) in [
            ("Position (z), mm", Displacement, Some("mm")),
            ("Fz, gf", Force, Some("gf")),
            ("Kraft in N", Force, Some("N")),
            ("Standardweg [mm]", Displacement, Some("mm")),
            ("Time/s", Time, Some("s")),
            ("Elapsed Time ( Sec )", Time, Some("Sec")),
            ("Load1 (N)", Force, Some("N")),
            ("Extension", Displacement, None),
            ("t_s", Time, Some("s")),
            ("pos_mm", Displacement, Some("mm")),
        ] {
            let found = meaning(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((found.quantity, found.unit.as_deref()), (quantity, unit), "{name}");
        }
        assert!(meaning("Temperature (C)").is_none() && meaning("force_stdd_mN").is_none());
    }

    #[test]
    fn units_of_machines_are_understood() {
        let factor = |text: &str, dimension| unit(text, dimension).map(|u| u.factor);
        assert_eq!(factor("(Sec)", Dimension::Time), Some(1.0));
        assert_eq!(factor("[µm]", Dimension::Length), Some(1e-6));
        assert_eq!(factor("g", Dimension::Force), Some(9.806_65e-3));
        assert_eq!(factor("g", Dimension::Length), None);
    }
}
