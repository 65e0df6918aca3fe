//! How much better each value is known from everything that was fitted than from the first loading and hold of each
//! test alone: the same solution, with the rows of those points only.

use super::fit_report::GainRow;
use crate::fit::derived::{self, DerivedQuantity, Values};
use crate::fit::{CommonError, FitParameter, Noise, Solution, Statistics};

/// One row per parameter and derived quantity; empty where nothing but first holds was fitted, or they alone do not
/// suffice. `points` are the rows of the first holds.
pub fn gains(
    parameters: &[FitParameter],
    quantities: &[DerivedQuantity],
    solution: &Solution,
    noise: &Noise,
    points: &[usize],
    complete: &dyn Fn(&mut Values),
) -> Vec<GainRow> {
    let all = solution.residual.len();
    if points.is_empty() || points.len() == all {
        return vec![];
    }
    let part = |values: &[f64]| points.iter().map(|&i| values[i]).collect::<Vec<f64>>();
    let first = Solution {
        residual: part(&solution.residual),
        jacobian: solution.jacobian.select_rows(points),
        chi_square: points.iter().map(|&i| solution.residual[i].powi(2)).sum(),
        ..solution.clone()
    };
    let mut before = 0;
    let mut stretch = |n: &usize| {
        before += n;
        points.iter().filter(|&&i| i >= before - n && i < before).count()
    };
    let first_noise = Noise {
        known: noise.known,
        common: noise
            .common
            .iter()
            .map(|c| CommonError { name: c.name.clone(), residual: part(&c.residual) })
            .collect(),
        stretches: noise.stretches.iter().map(&mut stretch).collect(),
    };
    let (Ok(one), Ok(whole)) =
        (Statistics::new(parameters, &first, &first_noise), Statistics::new(parameters, solution, noise))
    else {
        return vec![];
    };
    let direct = one.estimates.iter().zip(&whole.estimates).map(|(a, b)| GainRow {
        symbol: a.parameter.symbol.clone(),
        first_hold: a.half_width,
        all: b.half_width,
    });
    let of = |s: &Statistics| derived::estimate(quantities, parameters, &solution.x, s, complete);
    let (a, b) = (of(&one), of(&whole));
    let combined = a.iter().zip(&b).map(|(a, b)| GainRow {
        symbol: a.symbol.clone(),
        first_hold: a.half_width,
        all: b.half_width,
    });
    direct.chain(combined).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Bounds, EvaluationFailure, Options, Problem, minimise};
    use nalgebra::DMatrix;
    use std::ops::ControlFlow;

    /// One value measured over and over.
    struct Mean(usize);

    impl Problem for Mean {
        fn dimension(&self) -> usize {
            1
        }
        fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
            Ok((0..self.0).map(|i| x[0] - if i % 2 == 0 { 6.0 } else { 4.0 }).collect())
        }
        fn jacobian(&mut self, _: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
            Ok(DMatrix::from_element(r.len(), 1, 1.0))
        }
    }

    #[test]
    fn four_times_the_points_halve_the_interval() {
        let go = &mut |_: &_| ControlFlow::Continue(());
        let solution = minimise(&mut Mean(400), &[1.0], &Bounds::none(1), &Options::default(), go).unwrap();
        let unit = crate::fit::parameter::Unit::new("", 1.0);
        let parameter = FitParameter::new("m", "m", unit, 1.0, [-100.0, 100.0]).unwrap();
        let noise = Noise { known: true, ..Noise::default() };
        let points: Vec<usize> = (0..100).collect();
        let found = gains(std::slice::from_ref(&parameter), &[], &solution, &noise, &points, &|_| {});
        assert!((found[0].first_hold / found[0].all - 2.0).abs() < 0.1, "{found:?}");
        let everything: Vec<usize> = (0..400).collect();
        assert!(gains(&[parameter], &[], &solution, &noise, &everything, &|_| {}).is_empty());
    }
}
