//! Identification: fits parameters to measurements by runs of an FMU, and says what the result is worth.
//!
//! ```text
//! Settings -> Datasets + ParameterMap -> Objective -> multi-start trust region -> Identification -> FitReport
//! ```

pub mod report;
pub mod rough;
pub mod settings;

pub use settings::{FitSettings, JacobianSource, Settings, SettingsError, Source};

use crate::engine::Engine;
use crate::fit::multi_start::minimise_from_many;
use crate::fit::{
    CommonError, FitError, IterationRecord, MultiStart, MultiStartOptions, Noise, Options, Problem,
};
use crate::noise::{Common, Observation, hat_at, test_noise};
use crate::objective::{Dataset, JacobianLoad, Objective, ParameterMap};
use crate::pool::{ForceCurve, Priority, Run};
use nalgebra::DVector;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

/// How the fit is made.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// Starts in all.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Finite-difference step in the optimiser's variables.
    pub step: f64,
    /// Largest number of evaluations per start.
    pub max_evaluations: usize,
    /// An iteration that lowers chi^2 by a smaller part ends the fit; what the Jacobian is worth, where absent.
    pub least_gain: Option<f64>,
}

/// What a fit gives.
#[derive(Debug)]
pub struct Identification {
    /// Best solution and the fate of each start.
    pub search: MultiStart,
    /// Values of all parameters that were set, at the solution [FMU's units].
    pub values: BTreeMap<String, f64>,
    /// How busy the pool was while Jacobians were formed.
    pub load: JacobianLoad,
    /// Points at which the model failed.
    pub failed_points: u64,
    /// Number of parameters whose derivatives came from the FMU instead of finite differences.
    pub exact_derivatives: usize,
}

/// Drawn starts that are refined to the end; the others are only screened.
const REFINED: usize = 8;
/// An iteration that lowers chi^2 by a smaller part ends the fit. By finite differences: with some hundred points that
/// is a hundredth of a unit of chi^2, far below the noise, and spares the slide along directions that the data do not
/// feel. With the FMU's derivatives that slide leads somewhere, and is cheap.
const CHI_SQUARE_TOLERANCE: [f64; 2] = [1e-4, 1e-6];
/// A Jacobian is not more accurate than this part of its largest singular value: by finite differences, and
/// from the FMU's derivatives.
const JACOBIAN_ACCURACY: [f64; 2] = [1e-4, 1e-6];

/// Fits; `observe` sees each accepted step with the index of its start. A stop asked of the engine ends the
/// fit at its best point.
///
/// # Errors
/// When no start can be evaluated.
pub fn identify(
    engine: &Engine,
    datasets: &[Dataset],
    parameters: &ParameterMap,
    options: &FitOptions,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Identification, FitError> {
    if rough::applies(engine, parameters) {
        return rough::identify(engine, datasets, parameters, options, observe);
    }
    directly(engine, datasets, parameters, options, observe)
}

/// The same by runs of the model as it is, alone.
fn directly(
    engine: &Engine,
    datasets: &[Dataset],
    parameters: &ParameterMap,
    options: &FitOptions,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Identification, FitError> {
    let mut objective = Objective::new(engine, datasets, parameters, options.step);
    let many = MultiStartOptions { starts: options.starts.max(1), refined: REFINED, seed: options.seed };
    let trust = trust_region(&objective, options);
    let mut watch = |start: usize, record: &IterationRecord| {
        observe(start, record);
        if engine.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let (start, bounds) = (parameters.start(), parameters.optimiser_bounds());
    let search = minimise_from_many(&mut objective, start, bounds, &trust, &many, &mut watch)?;
    let values = parameters.settings(&search.best.x);
    let (load, failed_points) = (objective.load(), objective.failed());
    let exact_derivatives = objective.exact_columns();
    Ok(Identification { search, values, load, failed_points, exact_derivatives })
}

/// Options of the optimiser.
fn trust_region(objective: &Objective, options: &FitOptions) -> Options {
    let exact = usize::from(objective.exact_columns() == objective.dimension());
    Options {
        max_evaluations: options.max_evaluations,
        chi_square_tolerance: options.least_gain.unwrap_or(CHI_SQUARE_TOLERANCE[exact]),
        ..Options::for_log_parameters(JACOBIAN_ACCURACY[exact])
    }
}

/// What is known about the noise in the residuals of all datasets.
fn noise_of(datasets: &[Dataset]) -> Noise {
    let points = |d: &Dataset| d.measurement.len();
    let total: usize = datasets.iter().map(points).sum();
    let mut common = Vec::new();
    let mut before = 0;
    for dataset in datasets {
        if let Some(factor) = dataset.noise.common_factor {
            let mut residual = vec![0.0; total];
            let forces = dataset.measurement.force_n.iter().zip(dataset.scale_n());
            for (r, (force, scale)) in residual[before..].iter_mut().zip(forces) {
                *r = factor * force / scale;
            }
            common.push(CommonError { name: format!("height of {}", dataset.measurement.name), residual });
        }
        common.extend(numerical_errors(dataset, before, total));
        common.extend(slow_noise(dataset, before, total));
        before += points(dataset);
    }
    Noise {
        known: datasets.iter().all(|d| !d.noise.sigma_n.is_empty()),
        common,
        stretches: datasets.iter().map(points).collect(),
    }
}

/// Relative numerical error of the model's force that varies along the curve: the difference of its presets
/// from the converged force changes by this much between the peak and the end of the hold.
const NUMERICAL_ERROR: f64 = 1e-3;

/// The numerical error as one independent error per decade of time: slow against the sampling, so it does not
/// average out over the points as white noise does. Without it hundreds of points would claim a relaxation
/// time more precisely than the model computes it.
fn numerical_errors(dataset: &Dataset, before: usize, total: usize) -> Vec<CommonError> {
    let time_s = &dataset.measurement.time_s;
    let scale_n = dataset.scale_n();
    let decade = |k: usize| (time_s[k] - time_s[0]).max(1e-2).log10();
    let last = decade(time_s.len() - 1).ceil() as i32;
    (-2..=last)
        .map(|knot| {
            let mut residual = vec![0.0; total];
            for (k, (force, scale)) in dataset.measurement.force_n.iter().zip(scale_n).enumerate() {
                let share = hat_at(decade(k), knot);
                residual[before + k] = NUMERICAL_ERROR * share * force / scale;
            }
            CommonError {
                name: format!("numerical error of {} at 1e{knot} s", dataset.measurement.name),
                residual,
            }
        })
        .collect()
}

/// Slow noise of the load cell and differences in shape between the specimens, where the measurement tells them.
fn slow_noise(dataset: &Dataset, before: usize, total: usize) -> Vec<CommonError> {
    // A motion without a loading has no cycles and tells nothing of the kind.
    let Ok(observation) = Observation::new(&dataset.measurement, None) else { return vec![] };
    let force_mn = DVector::from_vec(observation.force_mn());
    let one = |common: Common| {
        let mut residual = vec![0.0; total];
        for (r, (shape_mn, scale_n)) in
            residual[before..].iter_mut().zip(common.shape_mn.iter().zip(dataset.scale_n()))
        {
            *r = 1e-3 * shape_mn / scale_n;
        }
        CommonError { name: common.name, residual }
    };
    test_noise(&observation, &force_mn).common.into_iter().map(one).collect()
}

/// Curves of the datasets with given parameter values; those that failed say why.
pub fn curves(
    engine: &Engine,
    datasets: &[Dataset],
    values: &BTreeMap<String, f64>,
) -> Vec<Result<Arc<ForceCurve>, String>> {
    let runs: Vec<Run> = datasets.iter().map(|d| engine.submit(&d.job(values), Priority::Urgent)).collect();
    runs.iter().map(|run| run.wait().map_err(|e| e.to_string())).collect()
}
