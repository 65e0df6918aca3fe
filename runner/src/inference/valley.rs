//! Where the floor of chi^2's valley lies along the directions that the data hardly determine.
//!
//! The linearised fit goes straight; other values that it holds for known change along a valley that bends. Along each principal direction of
//! the covariance with a deviation beyond what counts as determined, the model is computed with its derivatives one deviation to either
//! side, and everything across the direction takes one Gauss-Newton step from there.

use super::fit::Fit;
use super::problem::ForceProblem;
use super::setup::Setup;
use super::statistics::{Bend, DETERMINED_HALF_WIDTH, Statistics};
use crate::fit::subproblem::Decomposition;
use crate::fit::{EvaluationFailure, Problem};
use crate::pool::{Priority, Run, side_by_side};
use nalgebra::{DMatrix, DVector};

/// Deviations of an interval's end.
const ENDS: f64 = 1.96;
/// Directions at most, those of the largest deviation.
const MOST: usize = 6;
/// Where chi^2 has risen by more than this beside the straight path's own rise, the step is halved: the valley bends within it.
const STEEP: f64 = 2.0;
/// Halvings at most.
const HALVINGS: usize = 2;
/// A shorter part of a deviation, where a bound cuts it, tells nothing of the bend.
const SHORT: f64 = 0.2;

/// The bends around a fit.
///
/// # Errors
/// When the user asked to stop.
pub fn bends(setup: Setup, fit: &Fit, statistics: &Statistics) -> Result<Vec<Bend>, EvaluationFailure> {
    if !setup.is_differentiable() {
        return Ok(vec![]);
    }
    let directions = directions(statistics);
    let _under_way: Vec<Run> = directions
        .iter()
        .flat_map(|deviation| [1.0, -1.0].map(|z| moved(setup, fit, deviation, z)))
        .flat_map(|x| setup.submit(&x, &[], true, Priority::Speculative))
        .collect();
    let side = |deviation: &DVector<f64>, z: f64| side(setup, fit, statistics, deviation, z);
    let found = side_by_side(directions.iter().flat_map(|d| [1.0, -1.0].map(|z| move || side(d, z))));
    let mut floors = found.into_iter();
    let mut of = |deviation: DVector<f64>| {
        let floor = floors.by_ref().take(2).filter_map(Result::transpose).collect::<Result<_, _>>()?;
        Ok(Bend { deviation, floor })
    };
    directions.iter().cloned().map(&mut of).collect()
}

/// A point of the floor to one side of a direction, at most one deviation away: how many deviations, and where; none too near to tell anything.
fn side(
    setup: Setup,
    fit: &Fit,
    statistics: &Statistics,
    deviation: &DVector<f64>,
    side: f64,
) -> Result<Option<(f64, DVector<f64>)>, EvaluationFailure> {
    let mut z = side;
    for _ in 0..=HALVINGS {
        match at(setup, fit, statistics, deviation, z)? {
            Some(Floor { along, rise, by }) if rise <= STEEP + along * along => {
                return Ok((along.abs() >= SHORT).then_some((along, by)));
            }
            _ => z *= 0.5,
        }
    }
    Ok(None)
}

/// One deviation along each principal direction that the data hardly determine.
fn directions(statistics: &Statistics) -> Vec<DVector<f64>> {
    let eigen = statistics.of_what_a_fit_sees().symmetric_eigen();
    let mut all: Vec<(f64, DVector<f64>)> = eigen
        .eigenvalues
        .iter()
        .map(|variance| variance.max(0.0).sqrt())
        .zip(eigen.eigenvectors.column_iter())
        .filter(|(deviation, _)| ENDS * deviation > DETERMINED_HALF_WIDTH)
        .map(|(deviation, direction)| (deviation, direction * deviation))
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().take(MOST).map(|(_, direction)| direction).collect()
}

/// So many deviations along a direction, within the bounds.
fn moved(setup: Setup, fit: &Fit, deviation: &DVector<f64>, z: f64) -> Vec<f64> {
    let (lower, upper) = setup.unknowns.bounds();
    let x = &fit.solution.x;
    (0..x.len()).map(|j| (x[j] + z * deviation[j]).clamp(lower[j], upper[j])).collect()
}

/// A point of the floor.
struct Floor {
    /// Deviations along the direction.
    along: f64,
    /// Rise of chi^2.
    rise: f64,
    /// From the optimum.
    by: DVector<f64>,
}

/// The floor so many deviations along a direction; none where the model cannot be computed.
fn at(
    setup: Setup,
    fit: &Fit,
    statistics: &Statistics,
    deviation: &DVector<f64>,
    z: f64,
) -> Result<Option<Floor>, EvaluationFailure> {
    let start = DVector::from_column_slice(&fit.solution.x);
    let x = DVector::from_vec(moved(setup, fit, deviation, z));
    let mut problem = ForceProblem::new(setup, &[]);
    let Some((residual, jacobian_mn)) = EvaluationFailure::or_none(problem.with_jacobian(x.as_slice()))?
    else {
        return Ok(None);
    };
    let stacked = |x: &DVector<f64>, rows: (&DMatrix<f64>, &DVector<f64>)| {
        statistics.stacked(&fit.prior, x, rows, &|_| true)
    };
    let least = stacked(&start, (&fit.jacobian_mn, &fit.gap_mn)).1.norm_squared();
    let (all, rest) = stacked(&x, (&jacobian_mn, &-DVector::from_vec(residual)));
    let unit = deviation.normalize();
    let step = across(&all, &rest, &unit);
    let (lower, upper) = setup.unknowns.bounds();
    let there = DVector::from_fn(x.len(), |j, _| (x[j] + step[j]).clamp(lower[j], upper[j]));
    let rise = (&rest - &all * (&there - &x)).norm_squared() - least;
    let by = there - start;
    Ok(Some(Floor { along: unit.dot(&by) / deviation.norm(), rise, by }))
}

/// The least-squares step at right angles to a direction; along what nothing is felt there is none.
fn across(design: &DMatrix<f64>, rest: &DVector<f64>, unit: &DVector<f64>) -> DVector<f64> {
    let projected = design - (design * unit) * unit.transpose();
    let step = Decomposition::linear(projected, rest).whole_step();
    &step - unit * unit.dot(&step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Across the diagonal of `(x - 1, 2 (y - 3))` the best point is where the gradient lies along it: 4 (y - 3) = x - 1 with x + y = 0.
    #[test]
    fn a_step_across_stays_at_right_angles() {
        let design = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 2.0]);
        let rest = DVector::from_vec(vec![1.0, 6.0]);
        let unit = DVector::from_vec(vec![1.0, 1.0]).normalize();
        let step = across(&design, &rest, &unit);
        let (x, y) = (step[0], step[1]);
        assert!((x + y).abs() < 1e-12, "{step}");
        assert!(((x - 1.0) - 4.0 * (y - 3.0)).abs() < 1e-9, "{step}");
    }
}
