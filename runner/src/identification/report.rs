//! From an identification to the report of it.

use super::{Identification, curves, noise_of};
use crate::assumption::{Assumption, assumptions};
use crate::data::Phase;
use crate::engine::Engine;
use crate::fit::derived::material_quantities;
use crate::fit::{FitError, Values};
use crate::fmi::VariableKind;
use crate::objective::parameters::{display_unit, symbol};
use crate::objective::{Dataset, ParameterMap};
use crate::pool::ForceCurve;
use crate::report::{Assembly, FitReport, FixedRow, MeasuredCurve, Role, RunStatistics, Setting};
use std::collections::BTreeMap;
use std::time::SystemTime;

/// What a report needs beside the identification itself.
pub struct Context<'a> {
    /// What evaluated the runs.
    pub engine: &'a Engine,
    /// What was fitted and what was not.
    pub parameters: &'a ParameterMap,
    /// Measurements that were fitted.
    pub fitted: &'a [Dataset],
    /// Measurements that are predicted.
    pub validation: &'a [Dataset],
    /// The command line.
    pub command: String,
    /// Settings worth keeping.
    pub settings: Vec<Setting>,
    /// Wall time (s).
    pub seconds: f64,
}

/// Viscous branches that derived quantities are computed for.
const BRANCHES: usize = 4;
const MILLI: f64 = 1e3;

/// Makes the report. Measurements whose run failed are left out; the reasons are the second result.
///
/// # Errors
/// When there are not more points than parameters.
pub fn report(context: &Context, found: &Identification) -> Result<(FitReport, Vec<String>), FitError> {
    let c = context;
    let mut missing = Vec::new();
    let mut measured = Vec::new();
    for (datasets, role) in [(c.fitted, Role::Fit), (c.validation, Role::Validation)] {
        for (dataset, curve) in datasets.iter().zip(curves(c.engine, datasets, &found.values)) {
            match curve {
                Ok(curve) => measured.push(measured_curve(dataset, &curve, role)),
                Err(reason) => missing.push(format!("{}: no curve: {reason}", dataset.measurement.name)),
            }
        }
    }
    let names: Vec<&str> = c.fitted.iter().map(|d| d.measurement.name.as_str()).collect();
    let fixed = fixed_rows(c, &found.values);
    let complete = |values: &mut Values| complete(c, values);
    let noise = noise_of(c.fitted);
    let derived =
        if c.engine.is_own() { material_quantities(branches(c, &found.values)) } else { Vec::new() };
    let assembly = Assembly {
        title: format!("Parameters identified from {}", names.join(", ")),
        created: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        command: c.command.clone(),
        model: c.engine.model_name().to_owned(),
        parameters: c.parameters.free(),
        fixed,
        solution: &found.search.best,
        noise: &noise,
        derived: &derived,
        complete: &complete,
        first_holds: first_holds(c.fitted),
        curves: measured,
        runs: run_statistics(c, found),
        starts: found.search.records.clone(),
        settings: settings(c),
        assumptions: rests_on(c, &found.values),
    };
    Ok((assembly.build()?, missing))
}

/// Parameters that were not fitted, where the FMU is known to mean what it says.
fn rests_on(c: &Context, values: &BTreeMap<String, f64>) -> Vec<Assumption> {
    let fitted: Vec<&str> = c.parameters.free().iter().map(|p| p.name.as_str()).collect();
    assumptions(c.engine.wiring(), values, &fitted)
}

/// Points of the first loading and hold of each test, among those of all tests.
fn first_holds(datasets: &[Dataset]) -> Vec<usize> {
    let mut points = Vec::new();
    let mut before = 0;
    for d in datasets {
        let after_hold = |phase: &Phase| matches!(phase, Phase::Unload | Phase::Recovery);
        let end = d.phases.iter().position(after_hold).unwrap_or(d.phases.len());
        points.extend(before..before + end);
        before += d.phases.len();
    }
    points
}

fn measured_curve(dataset: &Dataset, curve: &ForceCurve, role: Role) -> MeasuredCurve {
    let m = &dataset.measurement;
    let milli = |values: &[f64]| values.iter().map(|v| v * MILLI).collect::<Vec<f64>>();
    MeasuredCurve {
        name: m.name.clone(),
        file: m.file.display().to_string(),
        role,
        provenance: (!m.comments.is_empty()).then(|| m.comments.join(" ")),
        time_s: m.time_s.clone(),
        displacement_mm: milli(&m.displacement_m),
        measured_mn: milli(&m.force_n),
        spread_mn: m.spread_n.as_deref().map(milli),
        sigma_mn: milli(&dataset.noise.sigma_n),
        model_mn: milli(curve.force_n()),
        model_solid_mn: curve.output("force_solid").map(milli),
        model_fluid_mn: curve.output("force_fluid").map(milli),
    }
}

/// Parameters that were given a value, and the material's that were left at theirs.
fn fixed_rows(c: &Context, values: &BTreeMap<String, f64>) -> Vec<FixedRow> {
    let free = |name: &str| c.parameters.free().iter().any(|p| p.name == name);
    let mut rows = Vec::new();
    for (name, variable) in &c.engine.wiring().parameters {
        let set = values.get(name).copied();
        let absent_branch = || !has_branch(c, name, values);
        if free(name) || (set.is_none() && (!name.starts_with("material.") || absent_branch())) {
            continue;
        }
        let tie = c.parameters.ties().iter().find(|t| t.name == *name);
        let number = set.or_else(|| variable.start_number()).filter(|_| variable.kind == VariableKind::Real);
        // Switches and presets are among the settings: they are no numbers.
        let Some(value) = number else { continue };
        let unit = display_unit(variable);
        rows.push(FixedRow {
            name: name.clone(),
            symbol: symbol(name),
            unit: unit.name.clone(),
            value: unit.from_si(value),
            how: tie.map_or_else(|| "fixed".to_owned(), |t| format!("{} * {}", symbol(&t.of), t.factor)),
        });
    }
    rows
}

/// Whether the branch that a parameter belongs to (if any) is present: its mu is not 0.
fn has_branch(c: &Context, name: &str, values: &BTreeMap<String, f64>) -> bool {
    let Some((branch, _)) = name.strip_prefix("material.branch[").and_then(|rest| rest.split_once(']'))
    else {
        return true;
    };
    let mu = format!("material.branch[{branch}].mu");
    let start = || c.engine.wiring().parameters.get(&mu).and_then(|v| v.start_number());
    values.get(&mu).copied().or_else(start).is_some_and(|mu| mu != 0.0)
}

fn branches(c: &Context, values: &BTreeMap<String, f64>) -> usize {
    (1..=BRANCHES).take_while(|i| has_branch(c, &format!("material.branch[{i}].mu"), values)).count()
}

/// Adds what is not fitted: start values first, then what was set, then what is tied.
fn complete(c: &Context, values: &mut Values) {
    for (name, variable) in &c.engine.wiring().parameters {
        let value = c.parameters.fixed().get(name).copied().or_else(|| variable.start_number());
        if let (None, Some(value)) = (values.get(name), value) {
            values.set(name, value);
        }
    }
    for tie in c.parameters.ties() {
        if let Some(value) = values.get(&tie.of) {
            values.set(&tie.name, tie.factor * value);
        }
    }
}

fn run_statistics(c: &Context, found: &Identification) -> RunStatistics {
    let s = c.engine.cache().statistics();
    let count = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let mut failures = found.search.best.failures.clone();
    failures.extend(found.search.records.iter().filter_map(|r| r.failure.clone()));
    failures.sort();
    failures.dedup();
    RunStatistics {
        runs: count(s.runs),
        cache_hits: count(s.memory_hits + s.disk_hits),
        failed: count(s.failed),
        cancelled: count(c.engine.pool().cancelled()),
        mean_in_flight: found.load.mean().unwrap_or(0.0),
        wall_time_s: c.seconds,
        failures,
    }
}

fn settings(c: &Context) -> Vec<Setting> {
    let mut settings = c.settings.clone();
    for d in c.fitted.iter().chain(c.validation) {
        settings.push(Setting {
            name: format!("noise of {}", d.measurement.name),
            value: d.noise.description.clone(),
        });
    }
    settings
}
