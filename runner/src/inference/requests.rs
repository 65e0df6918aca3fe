//! What the user asks of the parameters, as written on the command line, and what it means for an FMU.

use super::parameter::Unit as FitUnit;
use crate::fit::FitError;
use crate::fmi::ScalarVariable;
use crate::pool::Wiring;
use crate::setting::{SettingError, number_in, split_assignment, variable_named};
use poropunch::variables;
use std::collections::BTreeMap;
use thiserror::Error;

/// What the user asked for, as written.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Requests {
    /// `NAME=VALUE[UNIT]` of parameters that are not fitted.
    pub set: Vec<String>,
    /// Exactly these are fitted; the variable table's choice when empty.
    pub free: Vec<String>,
    /// `NAME` or `NAME=VALUE[UNIT]`, taken out of the fitted ones.
    pub fix: Vec<String>,
    /// `NAME=OTHER`, `NAME=OTHER*FACTOR` or `NAME=OTHER/FACTOR`.
    pub tie: Vec<String>,
    /// `NAME=LOWER:UPPER`, each with an optional unit.
    pub bounds: Vec<String>,
    /// `NAME=VALUE[UNIT]`.
    pub start: Vec<String>,
    /// What holds where nothing was asked for.
    pub defaults: Defaults,
}

/// What holds where the user said nothing, told by the data; empty: the variable table's.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Defaults {
    /// What is fitted; the variable table's choice when empty.
    pub free: Vec<String>,
    /// Values that stay.
    pub fixed: BTreeMap<String, f64>,
    /// Starts, each with its bounds; those of moduli and times follow from their own start.
    pub start: BTreeMap<String, (f64, [f64; 2])>,
    /// Shortest and longest relaxation time (s) that the data can show.
    pub times_s: Option<[f64; 2]>,
}

/// Bounds of one sign stretched to a decade beyond a start of that sign: what the user says wins over what the data say.
pub(super) fn holding([lower, upper]: [f64; 2], start: f64) -> [f64; 2] {
    const DECADE: f64 = 10.0;
    if start * lower <= 0.0 || (lower..=upper).contains(&start) {
        return [lower, upper];
    }
    let (near, far) =
        if start < 0.0 { (start / DECADE, start * DECADE) } else { (start * DECADE, start / DECADE) };
    [lower.min(far), upper.max(near)]
}

/// A request that cannot be met.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ParameterError {
    /// A name or value.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Start or bounds.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A fitted parameter whose bounds nobody knows.
    #[error("{0} has no bounds: give them with --bounds {0}=LOWER:UPPER")]
    NoBounds(String),
    /// A start value that nobody knows.
    #[error("{0} has no start value: give one with --start {0}=VALUE")]
    NoStart(String),
    /// Bounds that cannot be read.
    #[error("--bounds {0}: write NAME=LOWER:UPPER")]
    BadBounds(String),
    /// A tie that cannot be read, or to something that is tied itself.
    #[error("--tie {0}: write NAME=OTHER*FACTOR, where OTHER is not tied itself")]
    BadTie(String),
    /// Two requests for one parameter that exclude each other.
    #[error("{name} is both {first} and {second}: keep one of the two")]
    Conflict {
        /// Name of the parameter.
        name: String,
        /// The one request.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// Nothing to do.
    #[error("no parameter is left to fit: name at least one with --free")]
    NothingFree,
}

/// Value of one parameter as a multiple of another's.
#[derive(Debug, Clone, PartialEq)]
pub struct Tie {
    /// The one that follows.
    pub name: String,
    /// The one that it follows.
    pub of: String,
    /// value = factor * value of the other.
    pub factor: f64,
}

pub(super) fn conflict(name: &str, first: &'static str, second: &'static str) -> ParameterError {
    ParameterError::Conflict { name: name.to_owned(), first, second }
}

pub(super) fn identification(own: bool, name: &str) -> Option<variables::Identification> {
    variables::by_name(name).filter(|_| own).and_then(|(_, v)| v.identification)
}

pub(super) fn parse_bounds(
    wiring: &Wiring,
    texts: &[String],
) -> Result<BTreeMap<String, [f64; 2]>, ParameterError> {
    let one = |text: &String| {
        let bad = || ParameterError::BadBounds(text.clone());
        let (name, range) = split_assignment(text).ok_or_else(bad)?;
        let (lower, upper) = range.split_once(':').ok_or_else(bad)?;
        let variable = variable_named(wiring, name)?;
        let upper_value = number_in(variable, upper)?;
        // `100:1e5Pa.s`: a unit after the upper end is that of both.
        let unit = upper.trim_start_matches(|c: char| c.is_ascii_digit() || "+-.eE ".contains(c));
        let bare = lower.trim().parse::<f64>().is_ok();
        let lower = if bare { format!("{}{unit}", lower.trim()) } else { lower.to_owned() };
        Ok((name.to_owned(), [number_in(variable, &lower)?, upper_value]))
    };
    texts.iter().map(one).collect()
}

pub(super) fn parse_ties(wiring: &Wiring, texts: &[String]) -> Result<Vec<Tie>, ParameterError> {
    let mut ties: Vec<Tie> = Vec::new();
    for text in texts {
        let bad = || ParameterError::BadTie(text.clone());
        let (name, expression) = split_assignment(text).ok_or_else(bad)?;
        let number = |t: &str| t.trim().parse::<f64>().ok().filter(|f| f.is_finite() && *f != 0.0);
        let (of, factor) = match (expression.split_once('*'), expression.split_once('/')) {
            (Some((of, factor)), _) => (of, number(factor).ok_or_else(bad)?),
            (None, Some((of, factor))) => (of, 1.0 / number(factor).ok_or_else(bad)?),
            (None, None) => (expression, 1.0),
        };
        let (name, of) =
            (variable_named(wiring, name)?.name.clone(), variable_named(wiring, of.trim())?.name.clone());
        ties.push(Tie { name, of, factor });
    }
    let tied_twice = ties.iter().position(|t| ties.iter().any(|o| o.name == t.of));
    tied_twice.map_or(Ok(()), |i| Err(ParameterError::BadTie(texts[i].clone())))?;
    Ok(ties)
}

/// Unit in which people read a parameter.
pub fn display_unit(variable: &ScalarVariable) -> FitUnit {
    match (&variable.display_unit, &variable.unit) {
        (Some(display), _) if display != "1" => FitUnit::new(display, 1.0 / variable.display_factor),
        (None, Some(unit)) if unit != "1" => FitUnit::new(unit, 1.0),
        _ => FitUnit::new("", 1.0),
    }
}

/// The paper's symbol: `material.branch[1].mu` is mu_1, `material.permeability` is K0.
pub fn symbol(name: &str) -> String {
    let leaf = name.rsplit('.').next().unwrap_or(name);
    if let Some(rest) = name.strip_prefix("material.branch[")
        && let Some((number, _)) = rest.split_once(']')
    {
        return format!("{leaf}_{number}");
    }
    match name {
        "material.equilibrium.mu" => "mu_inf".into(),
        "material.equilibrium.alpha" => "alpha_inf".into(),
        "material.permeability" => "K0".into(),
        "material.lambda_star" => "lambda*".into(),
        "material.fluid_viscosity" => "mu_FR".into(),
        "material.n0s" => "n0S".into(),
        _ => leaf.to_owned(),
    }
}
