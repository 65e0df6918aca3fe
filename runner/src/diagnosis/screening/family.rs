//! How large the largest of many scores gets by chance.
//!
//! Scores are not independent: signatures overlap. So the noise is drawn, as it is after the refit, its uncertain sizes first, and the
//! largest score of each draw is kept.

use super::super::unsure_noise::UnsureNoise;
use crate::data::random::Random;
use crate::inference::Signature;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution};
use rayon::prelude::*;

/// Distribution of the largest score under noise alone.
#[derive(Debug, Clone)]
pub struct Family {
    /// Largest score of each draw, ascending.
    largest: Vec<f64>,
}

/// Draws: the 95 % threshold is then known to 1 % or so.
pub const DRAWS: usize = 4000;

impl Family {
    /// Of some signatures; `one_sided[k]` are scores of which only positive values count.
    pub fn new(signatures: &[&Signature], one_sided: &[bool], noise: &UnsureNoise, seed: u64) -> Self {
        let k = signatures.len();
        let mut known =
            DMatrix::from_fn(k, k, |i, j| if i == j { 1.0 } else { signatures[i].cosine(signatures[j]) });
        let unit = |s: &&Signature| &s.s / s.s.norm().max(f64::MIN_POSITIVE);
        let units: Vec<DVector<f64>> = signatures.iter().map(unit).collect();
        let unsure = if k > 0 { noise.covariances(&DMatrix::from_columns(&units)) } else { vec![] };
        unsure.iter().for_each(|(covariance, _)| known -= covariance);
        let known = root(known);
        let mut sizes = ChaCha8Rng::seed_from_u64(seed);
        let unsure: Vec<_> = unsure
            .into_iter()
            .filter_map(|(covariance, size)| {
                Some((root(covariance), ChiSquared::new(size.degrees).ok()?, size.scale))
            })
            .collect();
        let mut random = Random::new(seed);
        // Drawn one after the other, so that a seed gives the same numbers on any number of cores.
        let mut normal = || DVector::from_fn(k, |_, _| random.normal());
        let mut draw = || {
            let parts = unsure.iter().map(|(_, likely, scale)| (scale / likely.sample(&mut sizes)).sqrt());
            let factors: Vec<f64> = parts.collect();
            let own: Vec<DVector<f64>> = (0..=unsure.len()).map(|_| normal()).collect();
            (factors, own)
        };
        let noises: Vec<_> = (0..DRAWS).map(|_| draw()).collect();
        let largest_of = |(factors, own): &(Vec<f64>, Vec<DVector<f64>>)| {
            let mut scores = &known * &own[0];
            for ((factor, (root, ..)), own) in factors.iter().zip(&unsure).zip(&own[1..]) {
                scores.gemv(*factor, root, own, 1.0);
            }
            let counted = scores.iter().zip(one_sided).map(|(z, one)| if *one { *z } else { z.abs() });
            counted.fold(0.0, f64::max)
        };
        let mut largest: Vec<f64> = noises.par_iter().map(largest_of).collect();
        largest.sort_by(f64::total_cmp);
        Self { largest }
    }

    /// Score that noise alone passes in this part of all cases.
    pub fn threshold(&self, part: f64) -> f64 {
        let at = ((1.0 - part) * self.largest.len() as f64).ceil() as usize;
        self.largest[at.min(self.largest.len() - 1)]
    }

    /// Part of all cases in which noise alone gives such a largest score or a larger one.
    pub fn probability(&self, score: f64) -> f64 {
        let above = self.largest.len() - self.largest.partition_point(|z| *z < score);
        (above as f64 + 1.0) / (self.largest.len() as f64 + 1.0)
    }
}

/// A matrix whose product with its own transpose is a covariance.
fn root(covariance: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = covariance.symmetric_eigen();
    let deviations = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
    &eigen.eigenvectors * DMatrix::from_diagonal(&deviations)
}
