//! How much better each value is known from everything that was fitted than from the first loading and hold of each
//! test alone: the same solution, with the rows of those points only.

use super::fit_report::GainRow;
use crate::inference::derived::{self, DerivedQuantity, Values};
use crate::inference::{Fit, Statistics, Unknowns};

/// One row per parameter and derived quantity; empty where nothing but first holds was fitted, or they alone do not
/// suffice. `points` are the rows of the first holds, `stretches` the numbers of points of each measurement.
pub fn gains(
    unknowns: &Unknowns,
    quantities: &[DerivedQuantity],
    fit: &Fit,
    stretches: &[usize],
    points: &[usize],
    complete: &dyn Fn(&mut Values),
) -> Vec<GainRow> {
    if points.is_empty() || points.len() == fit.gap_mn.len() {
        return vec![];
    }
    let mut before = 0;
    let first_stretches: Vec<usize> = stretches
        .iter()
        .map(|n| {
            before += n;
            points.iter().filter(|&&i| i >= before - n && i < before).count()
        })
        .collect();
    let first = Statistics::new(unknowns, &fit.part(points), &first_stretches);
    let (Ok(one), Ok(whole)) = (first, Statistics::new(unknowns, fit, stretches)) else {
        return vec![];
    };
    let direct = one.estimates.iter().zip(&whole.estimates).map(|(a, b)| GainRow {
        symbol: a.parameter.symbol.clone(),
        first_hold: a.half_width,
        all: b.half_width,
    });
    let of = |s: &Statistics| derived::estimate(quantities, unknowns, &fit.solution.x, s, complete);
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
    use crate::inference::cases::{fit_of, positive};
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn four_times_the_points_halve_the_interval() {
        let unknowns = positive(&[("m", 5.0, [1e-3, 1e4])]);
        let gap = DVector::from_fn(400, |i, _| if i % 2 == 0 { 1.0 } else { -1.0 });
        let fit = fit_of(&unknowns, DMatrix::from_element(400, 1, 5.0), gap, 1.0);
        let points: Vec<usize> = (0..100).collect();
        let found = gains(&unknowns, &[], &fit, &[400], &points, &|_| {});
        assert!((found[0].first_hold / found[0].all - 2.0).abs() < 0.1, "{found:?}");
        let everything: Vec<usize> = (0..400).collect();
        assert!(gains(&unknowns, &[], &fit, &[400], &everything, &|_| {}).is_empty());
    }
}
