//! Which effects could explain the gap, told from how each would look after a refit.
//!
//! ```text
//! run with the effect - run without -> d -> inv(L) -> projector -> signature s
//! s against the residual: score, expected magnitude, gain; s against each other: groups
//! ```

mod family;
mod groups;
#[cfg(test)]
mod tests;

pub use family::{DRAWS, Family};
pub use groups::groups;

use crate::fit::{EvaluationFailure, Whitening};
use crate::inference::effect::is_continuous;
use crate::inference::effect::{Candidate, Sign};
use crate::inference::rough::Twin;
use crate::inference::{Linearised, Setup, Signature};
use crate::pool::{Priority, Run};
use nalgebra::DVector;

/// An effect as screening sees it.
#[derive(Debug, Clone)]
pub struct Screened {
    /// Index of the candidate.
    pub candidate: usize,
    /// Change of the force at magnitude `probe` divided by it (mN); empty where the run failed.
    pub change_mn: DVector<f64>,
    /// What of it no refit absorbs.
    pub signature: Signature,
    /// The signature at another magnitude, where it was computed: the family of scores has both.
    pub other: Option<Signature>,
}

/// An effect that could not be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Failed {
    /// Index of the candidate.
    pub candidate: usize,
    /// Why.
    pub reason: String,
}

/// A model, around which signatures are computed.
pub struct Screening<'a, W> {
    /// Engine, measurements, parameters.
    pub setup: Setup<'a>,
    /// What may be asked about.
    pub candidates: &'a [Candidate],
    /// Parameters (optimiser's variables).
    pub x: &'a [f64],
    /// Effects that the model has already.
    pub present: &'a [(&'a Candidate, f64)],
    /// The model, linearised.
    pub fit: &'a Linearised,
    /// Of its noise.
    pub whitening: &'a W,
}

impl<W: Whitening> Screening<'_, W> {
    /// Runs without and with an effect of some size, of a rougher model where that shows the change as well.
    fn submit(&self, candidate: &Candidate, size: f64) -> Change {
        let twin = Twin::leading(self.setup, &[candidate]);
        let setup = Twin::setup_or(twin.as_ref(), self.setup);
        let submit = |active: &[(&Candidate, f64)]| {
            setup.submit(self.x, &[self.present, active].concat(), false, Priority::Speculative)
        };
        Change { without: submit(&[]), with: submit(&[(candidate, size)]), size }
    }

    /// Signatures of these candidates.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn screen(
        &self,
        wanted: impl Iterator<Item = usize>,
    ) -> Result<(Vec<Screened>, Vec<Failed>), EvaluationFailure> {
        let runs: Vec<_> = wanted.map(|k| (k, self.submit(&self.candidates[k], 1.0))).collect();
        let (mut screened, mut failed) = (Vec::new(), Vec::new());
        for (candidate, change) in runs {
            match change.per_size_mn() {
                Ok(change_mn) => {
                    let signature = self.fit.signature(self.whitening, &change_mn);
                    screened.push(Screened { candidate, change_mn, signature, other: None });
                }
                Err(EvaluationFailure::Interrupted) => return Err(EvaluationFailure::Interrupted),
                Err(EvaluationFailure::Failed(reason)) => failed.push(Failed { candidate, reason }),
            }
        }
        self.refine(&mut screened)?;
        Ok((screened, failed))
    }

    /// Effects that would be seen at a small part of their plausible scale may look different there (a surface that is
    /// higher by micrometres, against one that is higher by tenths of a millimetre): they are computed there too, and
    /// the signature that fits the residual better is kept.
    fn refine(&self, screened: &mut [Screened]) -> Result<(), EvaluationFailure> {
        let y = &self.fit.residual;
        let mut runs = Vec::new();
        let score = |s: &Screened| self.candidates[s.candidate].one_sided(s.signature.score(y));
        let highest = screened.iter().map(score).fold(0.0, f64::max);
        for (k, s) in screened.iter().enumerate() {
            let candidate = &self.candidates[s.candidate];
            let part = VISIBLE / s.signature.strength();
            // Another magnitude may look up to some times better, not more.
            if is_continuous(candidate) && part < 0.5 && score(s) > RIVAL * highest {
                let side =
                    if candidate.effect.sign == Sign::Either { s.signature.score(y).signum() } else { 1.0 };
                let m = side * part.max(0.02);
                runs.push((k, self.submit(candidate, m)));
            }
        }
        for (k, change) in runs {
            let Some(change_mn) = EvaluationFailure::or_none(change.per_size_mn())? else { continue };
            let small = self.fit.signature(self.whitening, &change_mn);
            let s = &mut screened[k];
            let candidate = &self.candidates[s.candidate];
            if candidate.one_sided(small.score(y)) > candidate.one_sided(s.signature.score(y)) {
                s.change_mn = change_mn;
                s.other = Some(std::mem::replace(&mut s.signature, small));
            } else {
                s.other = Some(small);
            }
        }
        Ok(())
    }
}

/// Runs without an effect and with it.
struct Change {
    without: Vec<Run>,
    with: Vec<Run>,
    size: f64,
}

impl Change {
    /// What the effect changes of the force, divided by its size (mN).
    fn per_size_mn(&self) -> Result<DVector<f64>, EvaluationFailure> {
        let [without, with] =
            [&self.without, &self.with].map(|runs| Setup::forces_mn(runs).map(DVector::from_vec));
        Ok((with? - without?) / self.size)
    }
}

/// An effect with a smaller part of the highest score is no rival.
const RIVAL: f64 = 0.1;
/// A score that any gap worth explaining has.
const VISIBLE: f64 = 8.0;
