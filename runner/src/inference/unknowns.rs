//! What is fitted besides the effects, and how the values of the FMU's parameters follow from it.
//!
//! The force feels `mu alpha / 2` and `eta / G` of a branch, hardly `mu` and `alpha` one by one. So the optimiser's variables are
//! `ln G`, `ln tau` and `ln |alpha|` of the equilibrium response and of each branch; `mu = 2 G / alpha` and `eta = G tau` follow.
//! Branches are ordered by time: but for the fastest one the variable is `ln (tau / tau of the next faster one) > 0`, so that they
//! cannot exchange. A parameter that the user bounds, fixes or ties under the FMU's name is a variable (or none) under that name,
//! and so is every parameter of another FMU.

mod builder;

use super::parameter::FitParameter;
#[cfg(test)]
use super::parameter::internal_problem;
use super::requests::{ParameterError, Requests, Tie, conflict, parse_bounds, parse_ties};
use crate::fit::{Bounds, Prior};
use crate::pool::Wiring;
use crate::setting::{assignment, number_in, split_assignment, variable_named};
use builder::{Builder, free_names, label};
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// What a variable of the optimiser is.
#[derive(Debug, Clone, PartialEq)]
enum Role {
    /// The parameter of the same name.
    Parameter,
    /// Shear modulus of a group.
    Modulus(usize),
    /// Relaxation time of a group, over that of the next faster one where there is one.
    Time(usize),
}

/// `mu`, `alpha` and, of a branch, `eta`.
#[derive(Debug, Clone, PartialEq)]
struct Group {
    /// `material.equilibrium` or `material.branch[i]`.
    prefix: String,
    /// Place of the modulus among the variables.
    modulus: usize,
    /// Place of the exponent, or its value.
    alpha: Result<usize, f64>,
    /// Place of the time, of a branch.
    time: Option<usize>,
    /// The group of the next faster branch.
    faster: Option<usize>,
}

/// From the optimiser's variables to the values of all parameters that are set.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknowns {
    variables: Vec<FitParameter>,
    roles: Vec<Role>,
    groups: Vec<Group>,
    free: Vec<FitParameter>,
    fixed: BTreeMap<String, f64>,
    ties: Vec<Tie>,
    bounds: Bounds,
    start: Vec<f64>,
}

/// Times are sought this factor either way of the start where no data tell it, moduli that much above and its square below their
/// sum at the start.
const EITHER_WAY: f64 = 316.227_766_016_837_9;
/// Width of a variable's bounds in deviations of its prior: the bounds are where nobody expects it, and a truth ten times away
/// from the centre costs less than one unit of chi^2.
const BOUNDS_IN_DEVIATIONS: f64 = 4.0;

impl Unknowns {
    /// Variables that are parameters themselves.
    #[cfg(test)]
    pub fn of(parameters: Vec<FitParameter>) -> Self {
        let (start, bounds) = internal_problem(&parameters).expect("bounds");
        Self {
            roles: vec![Role::Parameter; parameters.len()],
            free: parameters.clone(),
            variables: parameters,
            groups: vec![],
            fixed: BTreeMap::new(),
            ties: vec![],
            bounds,
            start,
        }
    }

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
        let mut starts = BTreeMap::new();
        for text in &requests.start {
            let (variable, value) = assignment(wiring, text)?;
            starts.insert(variable.name.clone(), value);
        }
        if free.is_empty() {
            return Err(ParameterError::NothingFree);
        }
        let mut built =
            Builder { wiring, own, fixed: &fixed, ties: &ties, bounds: &bounds, starts: &starts, defaults }
                .build(&free)?;
        for tie in &ties {
            // A tie to a parameter that nobody sets follows its start value.
            if !free.contains(&tie.of) && !fixed.contains_key(&tie.of) {
                let value = variable_named(wiring, &tie.of)?.start_number();
                let value = value.ok_or_else(|| ParameterError::NoStart(tie.of.clone()))?;
                fixed.insert(tie.of.clone(), value);
            }
        }
        (built.fixed, built.ties) = (fixed, ties);
        Ok(built)
    }

    /// The same with further values that stay.
    #[must_use]
    pub fn with_fixed(mut self, values: &[(&str, f64)]) -> Self {
        self.fixed.extend(values.iter().map(|(name, value)| ((*name).to_owned(), *value)));
        self
    }

    /// The same, sought from another point within the bounds; what is known before stays.
    #[must_use]
    pub fn starting_at(mut self, x: &[f64]) -> Self {
        self.start = self.within_bounds(x);
        self
    }

    /// The point within the bounds that is nearest to `x`.
    pub fn within_bounds(&self, x: &[f64]) -> Vec<f64> {
        let bounds = self.bounds.lower().iter().zip(self.bounds.upper());
        x.iter().zip(bounds).map(|(x, (lower, upper))| x.clamp(*lower, *upper)).collect()
    }

    /// The optimiser's variables.
    pub fn variables(&self) -> &[FitParameter] {
        &self.variables
    }

    /// The fitted parameters under the FMU's names.
    pub fn free(&self) -> &[FitParameter] {
        &self.free
    }

    /// Number of variables.
    pub fn len(&self) -> usize {
        self.variables.len()
    }

    /// Whether nothing is fitted.
    pub fn is_empty(&self) -> bool {
        self.variables.is_empty()
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

    /// Normal knowledge of the variables before the measurement: in the middle of the bounds, a quarter of them wide.
    pub fn prior(&self) -> Prior {
        let (lower, upper) = self.bounds();
        let bounds = || lower.iter().zip(upper);
        Prior {
            mean: bounds().map(|(l, u)| 0.5 * (l + u)).collect(),
            deviation: bounds().map(|(l, u)| (u - l) / BOUNDS_IN_DEVIATIONS).collect(),
        }
    }

    /// Modulus, exponent and, of a branch, relaxation time of a group.
    fn group(&self, k: usize, x: &[f64]) -> (f64, f64, Option<f64>) {
        let g = &self.groups[k];
        let alpha = g.alpha.map_or_else(|value| value, |j| self.variables[j].to_value(x[j]));
        (x[g.modulus].exp(), alpha, g.time.map(|_| self.time(k, x)))
    }

    fn time(&self, k: usize, x: &[f64]) -> f64 {
        let g = &self.groups[k];
        let own = g.time.map_or(1.0, |j| x[j].exp());
        g.faster.map_or(own, |faster| own * self.time(faster, x))
    }

    /// Values of every parameter that is set, at a point of the optimiser.
    pub fn settings(&self, x: &[f64]) -> BTreeMap<String, f64> {
        let mut values = self.fixed.clone();
        for ((variable, role), &x) in self.variables.iter().zip(&self.roles).zip(x) {
            if *role == Role::Parameter {
                values.insert(variable.name.clone(), variable.to_value(x));
            }
        }
        for (k, group) in self.groups.iter().enumerate() {
            let (modulus, alpha, time) = self.group(k, x);
            values.insert(format!("{}.mu", group.prefix), 2.0 * modulus / alpha);
            if let Some(time) = time {
                values.insert(format!("{}.eta", group.prefix), modulus * time);
            }
        }
        for tie in &self.ties {
            if let Some(value) = values.get(&tie.of) {
                values.insert(tie.name.clone(), tie.factor * value);
            }
        }
        values
    }

    /// Every parameter that follows the optimiser's variable `j`, with its change per unit of it at `x`.
    pub fn slopes(&self, x: &[f64], j: usize) -> Vec<(String, f64)> {
        let mu = |k: usize| format!("{}.mu", self.groups[k].prefix);
        let eta = |k: usize| format!("{}.eta", self.groups[k].prefix);
        let mut slopes = match self.roles[j] {
            Role::Parameter => {
                let variable = &self.variables[j];
                let slope = variable.slope(x[j]);
                let exponent_of = (0..self.groups.len()).filter(|&k| self.groups[k].alpha == Ok(j));
                let through = exponent_of.map(|k| {
                    let (modulus, alpha, _) = self.group(k, x);
                    (mu(k), -2.0 * modulus / (alpha * alpha) * slope)
                });
                std::iter::once((variable.name.clone(), slope)).chain(through).collect::<Vec<_>>()
            }
            Role::Modulus(k) => {
                let (modulus, alpha, time) = self.group(k, x);
                let viscosity = time.map(|time| (eta(k), modulus * time));
                std::iter::once((mu(k), 2.0 * modulus / alpha)).chain(viscosity).collect()
            }
            Role::Time(k) => {
                let slower = (0..self.groups.len()).filter(|&g| self.is_as_slow(g, k));
                slower.map(|g| (eta(g), x[self.groups[g].modulus].exp() * self.time(g, x))).collect()
            }
        };
        let tied = |tie: &Tie| {
            let of = slopes.iter().find(|(name, _)| *name == tie.of)?;
            Some((tie.name.clone(), tie.factor * of.1))
        };
        let tied: Vec<(String, f64)> = self.ties.iter().filter_map(tied).collect();
        slopes.extend(tied);
        slopes
    }

    /// Whether the time of group `g` is counted from that of group `k`, or is it.
    fn is_as_slow(&self, g: usize, k: usize) -> bool {
        g == k || self.groups[g].faster.is_some_and(|faster| self.is_as_slow(faster, k))
    }

    /// The variables as people count them, with the change of each per unit of the optimiser's variables (rows): every relaxation time
    /// by itself instead of its ratio to the next faster one.
    pub fn terms(&self) -> (Vec<FitParameter>, DMatrix<f64>) {
        let mut rows = DMatrix::identity(self.len(), self.len());
        let mut terms = self.variables.clone();
        for (j, role) in self.roles.iter().enumerate() {
            let Role::Time(k) = *role else { continue };
            let mut faster = self.groups[k].faster;
            while let Some(g) = faster {
                if let Some(time) = self.groups[g].time {
                    rows[(j, time)] = 1.0;
                    terms[j] = product(&terms[j], &self.variables[time]);
                }
                faster = self.groups[g].faster;
            }
            if self.groups[k].faster.is_some() {
                let label = label(&self.groups[k].prefix);
                terms[j].name = format!("relaxation_time[{label}]");
                terms[j].symbol = format!("tau_{label}");
            }
        }
        (terms, rows)
    }

    /// Variables that a fitted parameter follows, with its change per unit of each.
    pub fn gradient(&self, x: &[f64], name: &str) -> Vec<(usize, f64)> {
        let of = |j: usize| self.slopes(x, j).into_iter().find(|(n, _)| n == name).map(|(_, s)| (j, s));
        (0..self.len()).filter_map(of).collect()
    }
}

/// Product of two positive variables.
fn product(a: &FitParameter, b: &FitParameter) -> FitParameter {
    FitParameter {
        unit: b.unit.clone(),
        start: a.start * b.start,
        lower: a.lower * b.lower,
        upper: a.upper * b.upper,
        ..a.clone()
    }
}

#[cfg(test)]
#[path = "unknowns_tests.rs"]
mod tests;
