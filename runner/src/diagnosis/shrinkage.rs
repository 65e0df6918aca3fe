//! How much of the gap an effect removes from data that were not fitted, with an interval from a parametric
//! bootstrap of the linearised models.
//!
//! What is drawn is the distance of both predictions from the force without noise, the model with the effect taken to be true. Nature's
//! form of the effect is not the catalogue's, which no such draw knows; what was found does. The interval covers both: where the draws
//! lie, and as wide a range around what was found.

use super::baseline::Fit;
use super::held_out::{Predictor, Split, gap_mn};
use crate::data::random::Random;
use nalgebra::DVector;

/// Gap before and after (mN) and the part of it that went.
#[derive(Debug, Clone, PartialEq)]
pub struct Shrinkage {
    /// Gap of the plain model (mN).
    pub before_mn: f64,
    /// Gap with the effect (mN).
    pub after_mn: f64,
    /// `1 - after / before`; none where there was no gap.
    pub value: Option<f64>,
    /// 90 % interval.
    pub interval: Option<(f64, f64)>,
}

/// Draws of the bootstrap.
const DRAWS: usize = 400;
/// Share of the draws left out at each end.
const TAIL: f64 = 0.05;

/// How both models do on a split's predicted points.
pub struct Comparison {
    plain: Predictor,
    extended: Predictor,
    plain_gap_mn: DVector<f64>,
    extended_gap_mn: DVector<f64>,
    white_mn: DVector<f64>,
    common: nalgebra::DMatrix<f64>,
    /// Twice the gain in log predictive density by the effects.
    pub score: f64,
    /// Whether the fitted points determine the effects: of none more than this share of the prior's variance is left.
    pub informative: bool,
}

/// A magnitude of which more of the prior's variance is left was not learned.
const LEARNED: f64 = 0.5;

impl Comparison {
    /// `None` where a model cannot be fitted to the split.
    pub fn new(plain: &Fit, extended: &Fit, split: &Split) -> Option<Self> {
        let (p, e) = (Predictor::new(plain, split)?, Predictor::new(extended, split)?);
        // Noise of the bootstrap: that of the model taken to be true.
        let covariance = &extended.covariance;
        let scores = [(&p, plain), (&e, extended)].map(|(m, f)| m.log_score(&m.error_mn(&f.gap_mn)));
        let informative = e.left[extended.parameters..].iter().all(|left| *left < LEARNED);
        Some(Self {
            plain: p,
            extended: e,
            plain_gap_mn: plain.gap_mn.clone(),
            extended_gap_mn: extended.gap_mn.clone(),
            white_mn: covariance.white_mn().clone(),
            common: covariance.common_columns(),
            score: scores[1] - scores[0],
            informative,
        })
    }

    /// Predictions (mN) at the split's points with or without the effect, from what was measured at all points (mN).
    pub fn predicted_mn(&self, measured_mn: &[f64], with_effect: bool) -> Vec<f64> {
        let (model, gap) = match with_effect {
            true => (&self.extended, &self.extended_gap_mn),
            false => (&self.plain, &self.plain_gap_mn),
        };
        let error = model.error_mn(gap);
        model.points().iter().zip(error.iter()).map(|(&i, e)| measured_mn[i] - e).collect()
    }

    /// Distances of both predictions from the force without `noise` (mN, all points), for the gaps that both models have with it.
    fn distances(
        &self,
        plain: &DVector<f64>,
        extended: &DVector<f64>,
        noise: &DVector<f64>,
        points: &[usize],
    ) -> (f64, f64) {
        let noise = noise.select_rows(self.plain.points());
        let distance = |m: &Predictor, gap: &DVector<f64>| {
            let off = m.error_mn(gap) - &noise;
            points.iter().map(|&i| off[i].powi(2)).sum::<f64>().sqrt()
        };
        (distance(&self.plain, plain), distance(&self.extended, extended))
    }

    /// Over some of the predicted points, given by their places among them; with an interval if asked for.
    pub fn shrinkage(&self, points: &[usize], with_interval: bool) -> Shrinkage {
        let gap = |m: &Predictor, gap: &DVector<f64>| gap_mn(&m.error_mn(gap), &m.deviation_mn, points);
        let before_mn = gap(&self.plain, &self.plain_gap_mn);
        let after_mn = gap(&self.extended, &self.extended_gap_mn);
        let ratio = |(before, after): (f64, f64)| (before > 0.0).then(|| 1.0 - after / before);
        let mut draws: Vec<f64> = Vec::new();
        if with_interval && before_mn > 0.0 {
            // What the plain fit misses if the model with the effect is true.
            let systematic = &self.plain_gap_mn - &self.extended_gap_mn;
            let mut random = Random::new(17);
            for _ in 0..DRAWS {
                let shared = DVector::from_fn(self.common.ncols(), |_, _| random.normal());
                let white = self.white_mn.map(|s| s * random.normal());
                let noise = &self.common * shared + white;
                draws.extend(ratio(self.distances(&(&systematic + &noise), &noise, &noise, points)));
            }
            draws.sort_by(f64::total_cmp);
        }
        let value = ratio((before_mn, after_mn));
        let at = |part: f64| draws[((draws.len() - 1) as f64 * part).round() as usize];
        // Where most draws have no gap to shrink there is no interval either.
        let interval = value.filter(|_| draws.len() > DRAWS / 2).map(|value| {
            let (low, middle, high) = (at(TAIL), at(0.5), at(1.0 - TAIL));
            (low.min(value + low - middle), high.max(value + high - middle).min(1.0))
        });
        Shrinkage { before_mn, after_mn, value, interval }
    }
}
