//! The variables from what the user asked for and what the data say.

use super::{EITHER_WAY, Group, Role, Unknowns};
use crate::fit::FitError;
use crate::inference::parameter::{FitParameter, Unit, internal_problem};
use crate::inference::requests::{
    Defaults, ParameterError, Tie, display_unit, holding, identification, symbol,
};
use crate::pool::Wiring;
use crate::setting::variable_named;
use poropunch::variables;
use std::collections::BTreeMap;

pub(super) fn free_names(
    wiring: &Wiring,
    own: bool,
    asked: &[String],
) -> Result<Vec<String>, ParameterError> {
    if asked.is_empty() && own {
        let free = variables::identifiable().filter(|(_, i)| i.free);
        return Ok(free.map(|(v, _)| v.name.to_owned()).collect());
    }
    asked.iter().map(|name| Ok(variable_named(wiring, name)?.name.clone())).collect()
}

/// Number of the branch that a parameter belongs to.
fn branch_of(name: &str) -> Option<usize> {
    name.strip_prefix("material.branch[")?.split_once(']')?.0.parse().ok()
}

/// What the variables are made from.
pub(super) struct Builder<'a> {
    pub(super) wiring: &'a Wiring,
    pub(super) own: bool,
    pub(super) fixed: &'a BTreeMap<String, f64>,
    pub(super) ties: &'a [Tie],
    pub(super) bounds: &'a BTreeMap<String, [f64; 2]>,
    pub(super) starts: &'a BTreeMap<String, f64>,
    pub(super) defaults: &'a Defaults,
}

/// A branch's number or `inf`, as in symbols.
pub(super) fn label(prefix: &str) -> String {
    branch_of(prefix).map_or_else(|| "inf".to_owned(), |i| i.to_string())
}

impl Builder<'_> {
    /// What the user gave, what the data say, or the FMU's own value.
    fn start_of(&self, name: &str) -> Option<f64> {
        let told = || self.defaults.start.get(name).map(|(start, _)| *start);
        let own = || self.wiring.parameters.get(name).and_then(|v| v.start_number());
        self.starts.get(name).copied().or_else(told).or_else(own)
    }

    fn start(&self, name: &str) -> Result<f64, ParameterError> {
        self.start_of(name).ok_or_else(|| ParameterError::NoStart(name.to_owned()))
    }

    fn value(&self, name: &str) -> Option<f64> {
        self.fixed.get(name).copied().or_else(|| self.start_of(name))
    }

    /// A variable for the parameter itself.
    fn parameter(&self, name: &str) -> Result<FitParameter, ParameterError> {
        // A further branch is sought where the first one is.
        let like =
            branch_of(name).map_or_else(|| name.to_owned(), |i| name.replace(&format!("[{i}]"), "[1]"));
        let known = || {
            let found = identification(self.own, name).or_else(|| identification(self.own, &like));
            found.map(|i| [i.lower, i.upper])
        };
        let (given, told) = (self.starts.get(name), self.defaults.start.get(name));
        let limits = match (self.bounds.get(name), told) {
            (Some(bounds), _) => Some(*bounds),
            (None, Some((_, bounds))) => Some(given.map_or(*bounds, |start| holding(*bounds, *start))),
            (None, None) => known(),
        };
        let limits = limits.ok_or_else(|| ParameterError::NoBounds(name.to_owned()))?;
        let unit = display_unit(variable_named(self.wiring, name)?);
        let start = match given {
            Some(start) => *start,
            // What the data say gives way to the user's bounds.
            None if told.is_some() => self.start(name)?.max(limits[0]).min(limits[1]),
            None => self.start(name)?,
        };
        Ok(FitParameter::new(name, &symbol(name), unit, start, limits)?)
    }

    /// Modulus, exponent and time of the group at the start, where its parameters are fitted through them.
    fn group(&self, prefix: &str, free: &[String]) -> Option<(f64, f64, Option<f64>)> {
        let is_branch = branch_of(prefix).is_some();
        let (mu, alpha, eta) = (format!("{prefix}.mu"), format!("{prefix}.alpha"), format!("{prefix}.eta"));
        let untied = |name: &String| !self.ties.iter().any(|t| t.name == *name || t.of == *name);
        let through = |name: &String| free.contains(name) && !self.bounds.contains_key(name) && untied(name);
        let told = self.defaults.start.get(&alpha).map(|(_, bounds)| *bounds);
        let sign = self.bounds.get(&alpha).copied().or(told).unwrap_or([-1.0, -1.0]);
        if !(self.own && through(&mu) && (!is_branch || through(&eta)))
            || !untied(&alpha)
            || sign[0] * sign[1] <= 0.0
        {
            return None;
        }
        let exponent = self.value(&alpha)?;
        let modulus = 0.5 * self.start(&mu).ok()? * exponent;
        let time = is_branch.then(|| self.start(&eta).ok().map(|eta| eta / modulus));
        let time = match time {
            Some(time) => Some(time?),
            None => None,
        };
        (modulus > 0.0 && time.is_none_or(|t| t > 0.0)).then_some((modulus, exponent, time))
    }

    pub(super) fn build(&self, free: &[String]) -> Result<Unknowns, ParameterError> {
        let place = |name: String| free.iter().position(|f| *f == name);
        let mut groups: Vec<(Group, [f64; 2])> = Vec::new();
        for name in free {
            let Some(prefix) = name.strip_suffix(".mu") else { continue };
            let (Some((modulus_pa, exponent, time_s)), Some(modulus)) =
                (self.group(prefix, free), place(name.clone()))
            else {
                continue;
            };
            let alpha = place(format!("{prefix}.alpha")).ok_or(exponent);
            let time = time_s.and_then(|_| place(format!("{prefix}.eta")));
            let group = Group { prefix: prefix.to_owned(), modulus, alpha, time, faster: None };
            groups.push((group, [modulus_pa, time_s.unwrap_or(0.0)]));
        }
        // From the fastest to the slowest; the equilibrium response, which has no time, comes first.
        groups.sort_by(|(_, a), (_, b)| a[1].total_cmp(&b[1]));
        for k in 1..groups.len() {
            groups[k].0.faster = groups[k - 1].0.time.map(|_| k - 1);
        }
        let (mut variables, mut roles) = (Vec::new(), Vec::new());
        for (j, name) in free.iter().enumerate() {
            let modulus = groups.iter().position(|(g, _)| g.modulus == j);
            let time = groups.iter().position(|(g, _)| g.time == Some(j));
            let (variable, role) = match (modulus, time) {
                (Some(k), _) => (modulus_variable(&groups, k)?, Role::Modulus(k)),
                (_, Some(k)) => (time_variable(&groups, k, self.defaults.times_s)?, Role::Time(k)),
                _ => (self.parameter(name)?, Role::Parameter),
            };
            variables.push(variable);
            roles.push(role);
        }
        let (start, bounds) = internal_problem(&variables)?;
        let (fixed, ties) = (BTreeMap::new(), vec![]);
        let groups = groups.into_iter().map(|(g, _)| g).collect();
        let mut unknowns = Unknowns { variables, roles, groups, free: vec![], fixed, ties, bounds, start };
        unknowns.free =
            free.iter().enumerate().map(|(j, n)| self.reported(&unknowns, j, n)).collect::<Result<_, _>>()?;
        Ok(unknowns)
    }

    /// A fitted parameter under the FMU's name, with the range that the variables leave it.
    fn reported(&self, unknowns: &Unknowns, j: usize, name: &str) -> Result<FitParameter, ParameterError> {
        if unknowns.roles[j] == Role::Parameter {
            return Ok(unknowns.variables[j].clone());
        }
        let (lower, upper) = unknowns.bounds();
        let start = unknowns.settings(&unknowns.start)[name];
        // All of them act on the logarithm of the size, one by one.
        let (mut low, mut high) = (start, start);
        for (k, slope) in unknowns.gradient(&unknowns.start, name) {
            let rate = slope / start;
            let ends = [lower[k], upper[k]].map(|x| rate * (x - unknowns.start[k]));
            low *= ends[0].min(ends[1]).exp();
            high *= ends[0].max(ends[1]).exp();
        }
        let unit = display_unit(variable_named(self.wiring, name)?);
        let limits = [low.min(high), low.max(high)];
        Ok(FitParameter::new(name, &symbol(name), unit, start.clamp(limits[0], limits[1]), limits)?)
    }
}

/// Sought where any group's modulus may lie: how the start shares the sum among them is the least certain of it.
fn modulus_variable(groups: &[(Group, [f64; 2])], k: usize) -> Result<FitParameter, FitError> {
    let (group, [modulus_pa, _]) = &groups[k];
    let sum: f64 = groups.iter().map(|(_, [modulus, _])| modulus).sum();
    let limits = [modulus_pa.min(sum / EITHER_WAY / EITHER_WAY), sum * EITHER_WAY];
    let label = label(&group.prefix);
    let (name, symbol) = (format!("shear_modulus[{label}]"), format!("G_{label}"));
    FitParameter::new(&name, &symbol, Unit::new("Pa", 1.0), *modulus_pa, limits)
}

/// Sought where any branch's time may lie, for the same reason.
fn time_variable(
    groups: &[(Group, [f64; 2])],
    k: usize,
    shown_s: Option<[f64; 2]>,
) -> Result<FitParameter, FitError> {
    let (group, [_, time_s]) = &groups[k];
    let times = || groups.iter().filter(|(g, _)| g.time.is_some()).map(|(_, [_, time])| *time);
    let (fastest, slowest) = (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
    let [shortest, longest] = shown_s.unwrap_or([fastest / EITHER_WAY, slowest * EITHER_WAY]);
    let (shortest, longest) = (shortest.min(fastest), longest.max(slowest));
    let own = label(&group.prefix);
    let Some(faster) = group.faster else {
        let (name, symbol) = (format!("relaxation_time[{own}]"), format!("tau_{own}"));
        return FitParameter::new(&name, &symbol, Unit::new("s", 1.0), *time_s, [shortest, longest]);
    };
    let (other, ratio) = (label(&groups[faster].0.prefix), time_s / groups[faster].1[1]);
    let name = format!("relaxation_time[{own}] / relaxation_time[{other}]");
    let symbol = format!("tau_{own} / tau_{other}");
    FitParameter::new(&name, &symbol, Unit::new("", 1.0), ratio, [1.0, longest / shortest])
}
