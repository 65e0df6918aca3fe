//! Which parameters are fitted, which are fixed, which follow others.

use crate::fit::parameter::{FitParameter, Unit as FitUnit, internal_problem, values_at};
use crate::fit::{Bounds, FitError};
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
    /// Starts, each with its bounds.
    pub start: BTreeMap<String, (f64, [f64; 2])>,
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

/// From the optimiser's variables to the values of all parameters that are set.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterMap {
    free: Vec<FitParameter>,
    fixed: BTreeMap<String, f64>,
    ties: Vec<Tie>,
    bounds: Bounds,
    start: Vec<f64>,
}

impl ParameterMap {
    /// Resolves the requests against an FMU's parameters. `own` FMUs have defaults for what is fitted.
    ///
    /// # Errors
    /// When a name, value, bound or tie is not usable.
    pub fn new(wiring: &Wiring, own: bool, requests: &Requests) -> Result<Self, ParameterError> {
        let ties = parse_ties(wiring, &requests.tie)?;
        let defaults = &requests.defaults;
        let mut fixed = defaults.fixed.clone();
        for text in &requests.set {
            let (variable, value) = assignment(wiring, text)?;
            fixed.insert(variable.name.clone(), value);
        }
        let asked = if requests.free.is_empty() { &defaults.free } else { &requests.free };
        let mut free = free_names(wiring, own, asked)?;
        for text in &requests.fix {
            let (name, value) = split_assignment(text).map_or((text.as_str(), None), |(n, v)| (n, Some(v)));
            let variable = variable_named(wiring, name)?;
            if requests.free.iter().any(|f| f == name) {
                return Err(conflict(name, "free", "fixed"));
            }
            free.retain(|f| f != name);
            if let Some(value) = value {
                fixed.insert(name.to_owned(), number_in(variable, value)?);
            }
        }
        for tie in &ties {
            let name = &tie.name;
            if requests.free.contains(name) || fixed.contains_key(name) {
                return Err(conflict(name, "tied", if fixed.contains_key(name) { "fixed" } else { "free" }));
            }
            free.retain(|f| f != name);
        }
        if let Some(name) = free.iter().find(|f| requests.set.iter().any(|s| s.starts_with(&format!("{f}="))))
        {
            return Err(conflict(name, "set", "free (use --start for its start, or --fix)"));
        }
        let bounds = parse_bounds(wiring, &requests.bounds)?;
        let starts = requests.start.iter().map(|text| assignment(wiring, text));
        let starts: Vec<(&ScalarVariable, f64)> = starts.collect::<Result<_, _>>()?;
        let mut parameters = Vec::with_capacity(free.len());
        for name in &free {
            let variable = variable_named(wiring, name)?;
            let given = starts.iter().find(|(v, _)| v.name == *name).map(|(_, value)| *value);
            let told = defaults.start.get(name);
            let known = || identification(own, name).map(|i| [i.lower, i.upper]);
            let limits = match (bounds.get(name), told) {
                (Some(bounds), _) => Some(*bounds),
                (None, Some((_, bounds))) => Some(given.map_or(*bounds, |start| holding(*bounds, start))),
                (None, None) => known(),
            };
            let limits = limits.ok_or_else(|| ParameterError::NoBounds(name.clone()))?;
            let told = told.map(|(start, _)| start.max(limits[0]).min(limits[1]));
            let start = given.or(told).or(variable.start_number());
            let start = start.ok_or_else(|| ParameterError::NoStart(name.clone()))?;
            parameters.push(FitParameter::new(name, &symbol(name), display_unit(variable), start, limits)?);
        }
        if parameters.is_empty() {
            return Err(ParameterError::NothingFree);
        }
        for tie in &ties {
            // A tie to a parameter that nobody sets follows its start value.
            if !free.contains(&tie.of) && !fixed.contains_key(&tie.of) {
                let start = variable_named(wiring, &tie.of)?.start_number();
                let start = start.ok_or_else(|| ParameterError::NoStart(tie.of.clone()))?;
                fixed.insert(tie.of.clone(), start);
            }
        }
        let (start, bounds) = internal_problem(&parameters)?;
        Ok(Self { free: parameters, fixed, ties, bounds, start })
    }

    /// The same with further values that stay.
    #[must_use]
    pub fn with_fixed(mut self, values: &[(&str, f64)]) -> Self {
        self.fixed.extend(values.iter().map(|(name, value)| ((*name).to_owned(), *value)));
        self
    }

    /// The same from another start of the optimiser's variables, within the bounds.
    #[must_use]
    pub fn starting_at(mut self, x: &[f64]) -> Self {
        let bounds = self.bounds.lower().iter().zip(self.bounds.upper());
        self.start = x.iter().zip(bounds).map(|(x, (lower, upper))| x.clamp(*lower, *upper)).collect();
        self
    }

    /// The fitted parameters.
    pub fn free(&self) -> &[FitParameter] {
        &self.free
    }

    /// Values that stay.
    pub fn fixed(&self) -> &BTreeMap<String, f64> {
        &self.fixed
    }

    /// Values that follow others.
    pub fn ties(&self) -> &[Tie] {
        &self.ties
    }

    /// Start of the optimiser's variables.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Bounds of the optimiser's variables.
    pub fn optimiser_bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Bounds of the optimiser's variables, lower and upper.
    pub fn bounds(&self) -> (&[f64], &[f64]) {
        (self.bounds.lower(), self.bounds.upper())
    }

    /// Every parameter that follows the optimiser's variable `j`, with its change per unit of it at `x`.
    pub fn slopes(&self, x: &[f64], j: usize) -> Vec<(&str, f64)> {
        let (free, slope) = (&self.free[j], self.free[j].slope(x[j]));
        let tied = self.ties.iter().filter(|tie| tie.of == free.name);
        let own = std::iter::once((free.name.as_str(), slope));
        own.chain(tied.map(|tie| (tie.name.as_str(), tie.factor * slope))).collect()
    }

    /// Values of every parameter that is set, at a point of the optimiser.
    pub fn settings(&self, x: &[f64]) -> BTreeMap<String, f64> {
        let mut values = self.fixed.clone();
        let names = self.free.iter().map(|p| p.name.clone());
        values.extend(names.zip(values_at(&self.free, x)));
        for tie in &self.ties {
            if let Some(value) = values.get(&tie.of) {
                values.insert(tie.name.clone(), tie.factor * value);
            }
        }
        values
    }
}

/// Bounds of one sign stretched to a decade beyond a start of that sign: what the user says wins over what the data say.
fn holding([lower, upper]: [f64; 2], start: f64) -> [f64; 2] {
    const DECADE: f64 = 10.0;
    if start * lower <= 0.0 || (lower..=upper).contains(&start) {
        return [lower, upper];
    }
    let (near, far) =
        if start < 0.0 { (start / DECADE, start * DECADE) } else { (start * DECADE, start / DECADE) };
    [lower.min(far), upper.max(near)]
}

fn conflict(name: &str, first: &'static str, second: &'static str) -> ParameterError {
    ParameterError::Conflict { name: name.to_owned(), first, second }
}

fn identification(own: bool, name: &str) -> Option<variables::Identification> {
    variables::by_name(name).filter(|_| own).and_then(|(_, v)| v.identification)
}

fn free_names(wiring: &Wiring, own: bool, asked: &[String]) -> Result<Vec<String>, SettingError> {
    if asked.is_empty() && own {
        let free = variables::identifiable().filter(|(_, i)| i.free);
        return Ok(free.map(|(v, _)| v.name.to_owned()).collect());
    }
    asked.iter().map(|name| variable_named(wiring, name).map(|v| v.name.clone())).collect()
}

fn assignment<'a>(wiring: &'a Wiring, text: &str) -> Result<(&'a ScalarVariable, f64), SettingError> {
    let (name, value) =
        split_assignment(text).ok_or_else(|| SettingError::NotAnAssignment(text.to_owned()))?;
    let variable = variable_named(wiring, name)?;
    Ok((variable, number_in(variable, value)?))
}

fn parse_bounds(wiring: &Wiring, texts: &[String]) -> Result<BTreeMap<String, [f64; 2]>, ParameterError> {
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

fn parse_ties(wiring: &Wiring, texts: &[String]) -> Result<Vec<Tie>, ParameterError> {
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
