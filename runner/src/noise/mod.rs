//! How uncertain the difference between a measured and a computed curve is.
//!
//! ```text
//! Observation -> white part of a point, from neighbouring samples
//!             -> common errors: height of the specimens, their shapes and drifts, slow noise, error of the simulation
//!             -> Covariance (low rank + diagonal), its inverse root
//! ```
//! With white noise alone hundreds of points would make any slow error significant.

pub mod common_factor;
pub mod correlated;
mod low_rank;
mod motion;
mod neighbours;
mod numerical;
pub mod observation;
pub mod odd_specimen;
mod slow;
mod specimens;
mod spikes;
#[cfg(test)]
mod tests;
pub mod weights;

pub use low_rank::{Common, Covariance, UncertainSize};
pub use numerical::{PER_DECADE, hats, hats_after_kinks, refinement};
pub use observation::{Observation, ObservationError};
pub use specimens::{TestNoise, check};
pub use weights::{Uncertainty, Weights};

use common_factor::FEWEST_SPECIMENS;
use low_rank::{Estimated, Group};
use motion::ZeroOfDepth;
use nalgebra::DVector;
use numerical::{contact_errors, slow_errors, timing};
use observation::same_specimens;
use specimens::test_noise;

/// The covariance of several tests, and what it is made of.
#[derive(Debug, Clone)]
pub struct NoiseModel {
    /// Of all points of all tests, test by test.
    pub covariance: Covariance,
    /// Noise of each test.
    pub tests: Vec<TestNoise>,
    /// Whether the tests were made on the same specimens.
    pub same_specimens: bool,
}

/// From the specimens of each test; `reference_mn` is the force that relative errors are relative to, test by test;
/// `refined` are differences of the model's force between its mesh and time steps and finer ones (mN).
///
/// The reference must be a computed force, and errors in proportion to it grow with what a fit computes
/// ([`Covariance::at`]). Otherwise a fit could shrink its own misfit: with an error of shape `h f` and `u` of it,
/// `f - u h f - c g = c (f - g)` for `c = 1 - u h`, so a model of half the height misses by half (Peelle's puzzle).
///
/// # Errors
/// When the uncertainty asked for needs what a file does not have.
pub fn noise_model(
    observations: &[Observation],
    reference_mn: &[f64],
    refined: Vec<Common>,
    weights: &Weights,
) -> Result<NoiseModel, ObservationError> {
    let references = by_test(observations, reference_mn);
    let pairs = || observations.iter().zip(&references);
    let tests: Vec<TestNoise> = pairs().map(|(o, f)| test_noise(o, f, weights)).collect::<Result<_, _>>()?;
    let white = DVector::from_iterator(
        reference_mn.len(),
        tests.iter().flat_map(|noise| noise.white_mn.iter().copied()),
    );
    let same = observations.windows(2).all(|w| same_specimens(&w[0], &w[1])) && observations.len() > 1;
    if weights.uncertainty == Uncertainty::None {
        return Ok(NoiseModel {
            covariance: Covariance::of_unknown_size(white),
            tests,
            same_specimens: same,
        });
    }
    let (mut common, mut absorbed) = (refined, vec![]);
    let mut before = 0;
    for ((observation, force), noise) in pairs().zip(&tests) {
        let slow = slow_errors(observation, force).into_iter().chain(contact_errors(observation, force));
        let numerical = slow.chain(timing(observation, force));
        let zero = ZeroOfDepth::of(observation, force, &noise.white_mn);
        let shape = zero.iter().map(|zero| zero.shape.clone());
        let local = noise.common.iter().cloned().chain(numerical).chain(shape);
        common.extend(local.map(|c| embed(c, before, reference_mn.len())));
        absorbed.extend(zero.map(|zero| embed(zero.height, before, reference_mn.len())));
        before += observation.len();
    }
    let force = DVector::from_row_slice(reference_mn);
    // What the user weighs by the spread has the heights in it already.
    if weights.uncertainty != Uncertainty::Spread {
        let heights = heights(observations, &references, same);
        // Those of all tests differ in the same way: one variance, of all degrees of freedom.
        let group = Some(Group { of: Estimated::Heights, degrees: heights.iter().map(|c| c.degrees).sum() });
        common.extend(heights.into_iter().map(|c| Common { group, ..c }));
        absorbed.extend(shared_height(observations, &force, same));
    }
    let covariance = Covariance::new(white, common).relative_to(force).absorbing(absorbed);
    Ok(NoiseModel { covariance, tests, same_specimens: same })
}

/// Errors of an effect's form: nature's change of the force has not the shape that the catalogue computes (`change_mn`, mN, all
/// points) but one that deviates by this part of it, otherwise in each half decade of the time since a kink, and by half as much more
/// between these: a smooth curve deviates from its chords by the less the shorter they are.
pub fn form_errors(observations: &[Observation], change_mn: &DVector<f64>, part: f64) -> Vec<Common> {
    let total = change_mn.len();
    let mut before = 0;
    let mut common = Vec::new();
    for (observation, own_mn) in observations.iter().zip(by_test(observations, change_mn.as_slice())) {
        for size in [(part, numerical::PER_DECADE), (0.5 * part, 2.0 * numerical::PER_DECADE)] {
            let errors = numerical::errors_after_kinks(observation, &own_mn, size, "form");
            common.extend(errors.map(|c| embed(c, before, total)));
        }
        before += observation.len();
    }
    common
}

/// What belongs to each test, of values at the points of all of them.
fn by_test(observations: &[Observation], values: &[f64]) -> Vec<DVector<f64>> {
    let mut rest = values;
    let own = |observation: &Observation| {
        let (first, others) = rest.split_at(observation.len());
        rest = others;
        DVector::from_row_slice(first)
    };
    observations.iter().map(own).collect()
}

/// A test's error among the points of all tests.
fn embed(common: Common, before: usize, total: usize) -> Common {
    let mut shape_mn = DVector::zeros(total);
    shape_mn.rows_mut(before, common.shape_mn.len()).copy_from(&common.shape_mn);
    let group = common.group.map(|group| match group.of {
        Estimated::Shapes { first_point } => {
            Group { of: Estimated::Shapes { first_point: before + first_point }, ..group }
        }
        Estimated::Heights => group,
    });
    Common { shape_mn, group, ..common }
}

/// What the mean of a few specimens leaves unknown of the height of a test (-), and its degrees of freedom.
fn relative_height(observation: &Observation) -> (f64, f64) {
    let n = observation.factors.len().max(1) as f64;
    (observation.log_scatter().map_or(0.0, |s| s / n.sqrt()), n - 1.0)
}

/// What the mean of a few specimens leaves unknown of the heights of the tests against each other: where the
/// specimens are different, each test's deviation from the mean of all.
fn heights(observations: &[Observation], references: &[DVector<f64>], same: bool) -> Vec<Common> {
    let total: usize = observations.iter().map(Observation::len).sum();
    let known = |c: &Common| c.shape_mn.amax() > 0.0;
    if same {
        return between_tests(observations, references, total).into_iter().filter(known).collect();
    }
    let all = references.iter().flat_map(|f| f.iter().copied());
    let mean = DVector::from_iterator(total, all) / observations.len() as f64;
    let mut before = 0;
    let mut common = Vec::new();
    for (observation, force) in observations.iter().zip(references) {
        let (relative, degrees) = relative_height(observation);
        let mut shape_mn = -mean.clone();
        let mut own = shape_mn.rows_mut(before, force.len());
        own += force;
        let name = format!("height of the specimens of {}", observation.name());
        common.push(Common { degrees, ..Common::proportional(name, shape_mn * relative) });
        before += observation.len();
    }
    common.into_iter().filter(known).collect()
}

/// The height that all tests share is the moduli's: a fit takes it up, so that it is no error of the comparison but one of the values.
/// (As an error in proportion to what is computed it would even do harm: a model a hundred times too high would miss by no more
/// than the inverse of the relative error.)
fn shared_height(observations: &[Observation], force_mn: &DVector<f64>, same: bool) -> Option<Common> {
    let all: Vec<(f64, f64)> = observations.iter().map(relative_height).collect();
    let (square, degrees) = match (same, all.first()) {
        (true, Some((relative, degrees))) => (relative * relative, *degrees),
        _ => {
            let squares = all.iter().map(|(r, _)| r * r).sum::<f64>() / (all.len() * all.len()).max(1) as f64;
            (squares, all.iter().map(|(_, degrees)| degrees).sum())
        }
    };
    let name = "height of the specimens".to_owned();
    let shape_mn = force_mn * square.sqrt();
    (square > 0.0).then(|| Common { degrees, ..Common::proportional(name, shape_mn) })
}

/// Specimens that were tested twice differ a little in how much: the scatter of the ratio of their factors.
fn between_tests(observations: &[Observation], references: &[DVector<f64>], total: usize) -> Vec<Common> {
    let Some((first, others)) = observations.split_first() else { return vec![] };
    let mut before = first.len();
    let mut common = Vec::new();
    for (other, force) in others.iter().zip(&references[1..]) {
        let ratios: Vec<f64> = other.factors.iter().zip(&first.factors).map(|(a, b)| (a / b).ln()).collect();
        let n = ratios.len().max(FEWEST_SPECIMENS) as f64;
        let scatter = crate::data::measurement::standard_deviation(&ratios);
        let shape_mn = force * (scatter / n.sqrt());
        let name = format!("height of {} against {} on the same specimens", other.name(), first.name());
        let height = Common { degrees: n - 1.0, ..Common::proportional(name, shape_mn) };
        common.push(embed(height, before, total));
        before += other.len();
    }
    common
}
