//! From an identification to the report of it.

use super::profiles::{prefetch, profiles};
use super::{Identification, IdentificationError, curves};
use crate::assumption::{Assumption, assumptions};
use crate::fit::EvaluationFailure;
use crate::fmi::VariableKind;
use crate::inference::derived::material_quantities;
use crate::inference::posterior::{PosteriorError, SamplePlan, posterior};
use crate::inference::problem::ForceProblem;
use crate::inference::requests::{display_unit, symbol};
use crate::inference::rough::Twin;
use crate::inference::valley::bends;
use crate::inference::{Resolution, Setup, Statistics, Values};
use crate::noise::{Covariance, Observation, Weights, noise_model};
use crate::pool::ForceCurve;
use crate::report::{
    Assembly, FitReport, FixedRow, Given, MeasuredCurve, NuisanceRow, PosteriorReport, Role, RunStatistics,
    Setting, SpecimenCurve,
};
use crate::score::chi_square;
use std::collections::BTreeMap;
use std::time::SystemTime;

/// What a report needs beside the identification itself.
pub struct Context<'a> {
    /// What evaluated the runs, what was fitted, and to what.
    pub setup: Setup<'a>,
    /// Measurements that are predicted.
    pub validation: &'a [Observation],
    /// How the points are weighed.
    pub weights: &'a Weights,
    /// Values whose interval is to be taken from a profile.
    pub profile: &'a [String],
    /// How the posterior is to be sampled, where it is.
    pub posterior: Option<SamplePlan>,
    /// Largest number of evaluations of a fit.
    pub evaluations: usize,
    /// The command line.
    pub command: String,
    /// Settings worth keeping.
    pub settings: Vec<Setting>,
    /// Contact points and load cells' zeros that were fitted.
    pub nuisances: Vec<NuisanceRow>,
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
pub fn report(
    context: &Context,
    identification: &Identification,
) -> Result<(FitReport, Vec<String>), IdentificationError> {
    let c = context;
    let (fit, values) = (&identification.found.fit, &identification.values);
    // The fit's own runs have the derivatives, but where a rough model stands for them; those of other tests need none.
    let twin = identification.found.twin.as_ref();
    let derivatives = twin.is_none() && ForceProblem::new(c.setup, &[]).exact_columns() > 0;
    let around = Twin::setup_or(twin, c.setup);
    let fitted = c.setup.observations;
    let (mut missing, mut measured, mut descriptions) = (Vec::new(), Vec::new(), Vec::new());
    let mut before = 0;
    for ((o, curve), noise) in fitted
        .iter()
        .zip(curves(c.setup.engine, fitted, values, derivatives))
        .zip(&identification.noise.tests)
    {
        let points: Vec<usize> = (before..before + o.len()).collect();
        before += o.len();
        descriptions.push((o.name(), noise.description.clone()));
        match curve {
            Ok(curve) => measured.push(measured_curve(o, &curve, Role::Fit, &fit.covariance.part(&points))),
            Err(reason) => missing.push(format!("{}: no curve: {reason}", o.name())),
        }
    }
    for (o, curve) in c.validation.iter().zip(curves(c.setup.engine, c.validation, values, false)) {
        match curve {
            Ok(curve) => {
                let force: Vec<f64> = curve.force_n().iter().map(|f| f * MILLI).collect();
                let noise = noise_model(std::slice::from_ref(o), &force, vec![], c.weights)?;
                descriptions.extend(noise.tests.iter().map(|t| (o.name(), t.description.clone())));
                measured.push(measured_curve(o, &curve, Role::Validation, &noise.covariance));
            }
            Err(reason) => missing.push(format!("{}: no curve: {reason}", o.name())),
        }
    }
    let names: Vec<&str> = fitted.iter().map(Observation::name).collect();
    let complete = |values: &mut Values| complete(c, values);
    let stretches: Vec<usize> = fitted.iter().map(Observation::len).collect();
    let linear = Statistics::new(c.setup.unknowns, fit, &stretches)?;
    let resolution = Resolution::of(around, fit, &linear);
    let own = c.setup.engine.is_own();
    let derived = if own { material_quantities(branches(c, values), &resolution) } else { Vec::new() };
    let mut statistics = linear.resolved(resolution);
    let mut profiled = vec![];
    if fit.solution.stop.converged() {
        let _under_way = prefetch(around, fit, &statistics, c.profile);
        // What a stop leaves undone is told by the exit code; the linearised intervals stand.
        let bends = bends(around, fit, &statistics).unwrap_or_default();
        statistics = statistics.along(c.setup.unknowns, &fit.solution.x, bends);
        profiled = profiles(around, fit, &statistics, c.evaluations, c.profile).unwrap_or_default();
    }
    let sampled = match c.posterior.filter(|_| fit.solution.stop.converged()) {
        Some(plan) => match posterior(around, fit, &statistics, &plan) {
            Ok(found) => Some(PosteriorReport::from(&found)),
            Err(PosteriorError::Evaluation(EvaluationFailure::Interrupted)) => None,
            Err(error) => {
                missing.push(format!("no posterior: {error}"));
                None
            }
        },
        None => None,
    };
    let given = Given {
        title: format!("Parameters identified from {}", names.join(", ")),
        created: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        command: c.command.clone(),
        model: c.setup.engine.model_name().to_owned(),
        fixed: fixed_rows(c, values),
        assumptions: rests_on(c, values),
        nuisances: c.nuisances.clone(),
        runs: run_statistics(c, identification),
        starts: identification.found.starts.clone(),
        settings: settings(c, &descriptions),
    };
    let assembly = Assembly {
        given,
        unknowns: c.setup.unknowns,
        fit,
        statistics,
        stretches: &stretches,
        profiles: profiled,
        far_points: identification.far_points,
        derived: &derived,
        complete: &complete,
        first_holds: first_holds(fitted),
        curves: measured,
    };
    Ok((FitReport { posterior: sampled, ..assembly.build()? }, missing))
}

/// Parameters that were not fitted, where the FMU is known to mean what it says.
fn rests_on(c: &Context, values: &BTreeMap<String, f64>) -> Vec<Assumption> {
    let fitted: Vec<&str> = c.setup.unknowns.free().iter().map(|p| p.name.as_str()).collect();
    assumptions(c.setup.engine.wiring(), values, &fitted)
}

/// Points of the first loading and hold of each test, among those of all tests.
fn first_holds(observations: &[Observation]) -> Vec<usize> {
    let mut points = Vec::new();
    let mut before = 0;
    for o in observations {
        points.extend(before..before + o.first_hold_end());
        before += o.len();
    }
    points
}

fn measured_curve(o: &Observation, curve: &ForceCurve, role: Role, covariance: &Covariance) -> MeasuredCurve {
    let m = &o.measurement;
    let milli = |values: &[f64]| values.iter().map(|v| v * MILLI).collect::<Vec<f64>>();
    let total = || covariance.total_mn().as_slice().to_vec();
    let specimens = m.specimen_names.iter().zip(&m.specimens_n);
    MeasuredCurve {
        specimens: specimens.map(|(n, f)| SpecimenCurve { name: n.clone(), force_mn: milli(f) }).collect(),
        name: m.name.clone(),
        file: m.file.display().to_string(),
        role,
        provenance: (!m.comments.is_empty()).then(|| m.comments.join(" ")),
        time_s: m.time_s.clone(),
        displacement_mm: milli(&m.displacement_m),
        measured_mn: milli(&m.force_n),
        spread_mn: m.spread_n.as_deref().map(milli),
        sigma_mn: if covariance.is_known() { total() } else { vec![] },
        chi_square: chi_square(o, curve, covariance),
        model_mn: milli(curve.force_n()),
        model_solid_mn: curve.output("force_solid").map(milli),
        model_fluid_mn: curve.output("force_fluid").map(milli),
    }
}

/// Parameters that were given a value, and the material's that were left at theirs.
fn fixed_rows(c: &Context, values: &BTreeMap<String, f64>) -> Vec<FixedRow> {
    let free = |name: &str| c.setup.unknowns.free().iter().any(|p| p.name == name);
    let mut rows = Vec::new();
    for (name, variable) in &c.setup.engine.wiring().parameters {
        let set = values.get(name).copied();
        let is_material = name.starts_with("material.");
        if free(name) || (set.is_none() && !is_material) || !has_branch(c, name, values) {
            continue;
        }
        let tie = c.setup.unknowns.ties().iter().find(|t| t.name == *name);
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
    let start = || c.setup.engine.wiring().parameters.get(&mu).and_then(|v| v.start_number());
    values.get(&mu).copied().or_else(start).is_some_and(|mu| mu != 0.0)
}

fn branches(c: &Context, values: &BTreeMap<String, f64>) -> usize {
    (1..=BRANCHES).take_while(|i| has_branch(c, &format!("material.branch[{i}].mu"), values)).count()
}

/// Adds what is not fitted: start values first, then what was set, then what is tied.
fn complete(c: &Context, values: &mut Values) {
    for (name, variable) in &c.setup.engine.wiring().parameters {
        let value = c.setup.unknowns.fixed().get(name).copied().or_else(|| variable.start_number());
        if let (None, Some(value)) = (values.get(name), value) {
            values.set(name, value);
        }
    }
    for tie in c.setup.unknowns.ties() {
        if let Some(value) = values.get(&tie.of) {
            values.set(&tie.name, tie.factor * value);
        }
    }
}

fn run_statistics(c: &Context, identification: &Identification) -> RunStatistics {
    let found = &identification.found;
    let s = c.setup.engine.cache().statistics();
    let count = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let mut failures = found.fit.solution.failures.clone();
    failures.extend(found.starts.iter().filter_map(|r| r.failure.clone()));
    failures.sort();
    failures.dedup();
    RunStatistics {
        runs: count(s.runs),
        cache_hits: count(s.memory_hits + s.disk_hits),
        failed: count(s.failed),
        cancelled: count(c.setup.engine.pool().cancelled()),
        mean_in_flight: found.load.mean().unwrap_or(0.0),
        wall_time_s: c.seconds,
        failures,
    }
}

fn settings(c: &Context, noise: &[(&str, String)]) -> Vec<Setting> {
    let of =
        |(name, value): &(&str, String)| Setting { name: format!("noise of {name}"), value: value.clone() };
    c.settings.iter().cloned().chain(noise.iter().map(of)).collect()
}
