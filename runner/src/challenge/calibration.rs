//! What confidences are worth: the share of right answers beside them.

use super::binomial::Share;
use crate::report::plot::{Axis, Chart, Mark, palette};
use serde::{Deserialize, Serialize};

/// Confidences against what came of them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Calibration {
    /// Mean confidence and right answers of groups of equal size, from the least confident on.
    pub reliability: Vec<(f64, Share)>,
    /// Mean distance between the two, weighted by the groups' sizes.
    pub expected_error: f64,
    /// Mean square of confidence less outcome.
    pub brier: f64,
    /// The same of the best constant.
    pub brier_of_a_constant: f64,
}

/// Least answers in a group.
const LEAST: usize = 8;
/// Most groups.
const MOST: usize = 10;

impl Calibration {
    /// Of answers: confidence, and whether they are right.
    pub fn of(mut answers: Vec<(f64, bool)>) -> Self {
        if answers.is_empty() {
            return Self::default();
        }
        answers.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = answers.len() as f64;
        let outcome = |right: bool| if right { 1.0 } else { 0.0 };
        let brier = answers.iter().map(|(c, right)| (c - outcome(*right)).powi(2)).sum::<f64>() / n;
        let share = answers.iter().map(|a| outcome(a.1)).sum::<f64>() / n;
        let groups = (answers.len() / LEAST).clamp(1, MOST);
        let group = |part: &[(f64, bool)]| {
            let mean = part.iter().map(|p| p.0).sum::<f64>() / part.len() as f64;
            (mean, Share::of(part.iter().map(|p| p.1)))
        };
        let reliability: Vec<(f64, Share)> =
            answers.chunks(answers.len().div_ceil(groups)).map(group).collect();
        let off = |(mean, share): &(f64, Share)| {
            share.of as f64 / n * (mean - share.value().unwrap_or(*mean)).abs()
        };
        let expected_error = reliability.iter().map(off).sum();
        Self { reliability, expected_error, brier, brier_of_a_constant: share * (1.0 - share) }
    }

    /// The reliability diagram: right answers over the confidence with which they were told, with 90 % intervals.
    pub fn diagram(&self) -> Chart {
        let axis = |label| Axis::linear(label).with_range(0.0, 100.0);
        let percent = |x: f64| 100.0 * x;
        let blank = Chart::new("", axis("confidence (%)"), axis("right (%)"), (380.0, 340.0));
        let diagonal = [0.0, 100.0];
        let mut chart = blank.with(None, palette::GREY, Mark::Dashed, &diagonal, &diagonal);
        for (mean, share) in &self.reliability {
            let (low, high) = share.interval();
            let ends = [low, high].map(percent);
            chart = chart.with(None, palette::BLUE, Mark::Line, &[percent(*mean); 2], &ends);
        }
        let (means, shares): (Vec<f64>, Vec<f64>) = self
            .reliability
            .iter()
            .map(|(mean, s)| (percent(*mean), percent(s.value().unwrap_or(0.0))))
            .unzip();
        chart.with(None, palette::BLUE, Mark::Points, &means, &shares)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sixteen answers of 0.9 of which twelve are right, sixteen of 0.5 of which eight are.
    #[test]
    fn errors_and_scores_are_what_they_are_defined_as() {
        let part = |confidence: f64, right: usize| (0..16).map(move |k| (confidence, k < right));
        let found = Calibration::of(part(0.9, 12).chain(part(0.5, 8)).collect());
        // Groups of eight, in which the right ones stand together, are of unequal shares.
        assert_eq!(found.reliability.len(), 4);
        let brier = (12.0 * 0.01 + 4.0 * 0.81 + 16.0 * 0.25) / 32.0;
        approx::assert_relative_eq!(found.brier, brier, max_relative = 1e-12);
        approx::assert_relative_eq!(found.brier_of_a_constant, 0.625 * 0.375, max_relative = 1e-12);
        let expected = (0.5 + 0.5 + 0.1 + 0.4) / 4.0;
        approx::assert_relative_eq!(found.expected_error, expected, max_relative = 1e-12);
        assert_eq!(Calibration::of(vec![]), Calibration::default());
    }

    /// Ten answers of 0.8, of which five are right: one point 80 % to the right and half-way up.
    #[test]
    fn the_diagram_has_a_point_where_it_belongs() {
        let chart = Calibration::of((0..10).map(|k| (0.8, k < 5)).collect()).diagram();
        let [diagonal, interval, points] = &chart.series[..] else { panic!("{} series", chart.series.len()) };
        assert_eq!(diagonal.x, diagonal.y);
        assert!(interval.y[0] < 50.0 && 50.0 < interval.y[1], "{:?}", interval.y);
        approx::assert_relative_eq!(points.x[0], 80.0, max_relative = 1e-12);
        approx::assert_relative_eq!(points.y[0], 50.0, max_relative = 1e-12);
    }
}
