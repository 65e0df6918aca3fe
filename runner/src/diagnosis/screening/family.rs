//! How large the largest of many scores gets by chance.
//!
//! Scores are not independent: signatures overlap. So the noise is drawn, as it is after the refit, and the largest
//! score of each draw is kept.

use crate::data::random::Random;
use crate::inference::Signature;
use nalgebra::{DMatrix, DVector};
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
    pub fn new(signatures: &[&Signature], one_sided: &[bool], seed: u64) -> Self {
        let k = signatures.len();
        let cosine =
            DMatrix::from_fn(k, k, |i, j| if i == j { 1.0 } else { signatures[i].cosine(signatures[j]) });
        let eigen = cosine.symmetric_eigen();
        let root = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
        let factor = &eigen.eigenvectors * DMatrix::from_diagonal(&root);
        let mut random = Random::new(seed);
        // Drawn one after the other, so that a seed gives the same numbers on any number of cores.
        let noises: Vec<_> = (0..DRAWS).map(|_| DVector::from_fn(k, |_, _| random.normal())).collect();
        let largest_of = |noise: &DVector<f64>| {
            let scores = &factor * noise;
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
