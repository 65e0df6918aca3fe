//! What an effect promises before it is refitted, and where its refit may begin.

use super::confirming::excess;
use super::round::{Elsewhere, linear_evidence};
use super::screening::Screened;
use super::search::Search;
use crate::inference::Linearised;
use crate::noise::Covariance;

/// A signature is not linear, but what promises less than this part of the largest gain seldom gains most.
pub(super) const PROMISING: f64 = 0.5;
/// A refit often gains twice what its effect promised, some gain nearly four times as much: what promises less than this part of another's gain
/// is not the one that gains most.
pub(super) const OUTDONE: f64 = 0.25;

/// What an effect would do for a fit, by its signature.
#[derive(Clone)]
pub(super) struct Promise {
    pub candidate: usize,
    pub magnitude: f64,
    /// Fall of chi^2.
    pub gain: f64,
    /// Twice the logarithm of the evidence.
    pub evidence: f64,
    /// Change of the fit's variables with the magnitude (of a switch, with it).
    pub giving_way: Vec<f64>,
}

/// What an effect promises, and the parameters around which it does.
#[derive(Clone)]
pub(super) struct Beginning<'a> {
    pub promise: Promise,
    /// Number of effects that promise more there.
    pub rank: usize,
    /// Whether that is the plain model's fit.
    pub is_at_fit: bool,
    pub x: &'a [f64],
    /// chi^2 of the plain model there.
    pub chi_square: f64,
}

/// Where an effect's refit may begin, the best place first.
pub(super) type Beginnings<'a> = Vec<Beginning<'a>>;

/// What promises most first.
pub(super) fn most_promising_first(mut beginnings: Vec<Beginning>) -> Vec<Beginning> {
    beginnings.sort_by(|a, b| b.promise.evidence.total_cmp(&a.promise.evidence));
    beginnings
}

impl Search<'_> {
    /// Where each effect's refit begins, first where it ranks highest among the effects; those that rank highest come first. A plain
    /// fit that misses much has moved its parameters to imitate what it lacks, and leaves of it what some other effect may explain
    /// better; at the other starts nothing is imitated, but what is promised there is farther from the truth.
    pub(super) fn beginnings(&self) -> Vec<Beginnings<'_>> {
        let plain = self.plain;
        let fit = (plain.x(), plain.solution.chi_square);
        let at_fit = |s: &&Screened| Beginning {
            is_at_fit: true,
            ..self.beginning(s, fit, (&plain.linear, &plain.covariance))
        };
        let mut points = vec![most_promising_first(self.shown.iter().map(at_fit).collect())];
        points.extend(self.elsewhere.iter().map(|there| self.beginnings_at(there)));
        for point in &mut points {
            point.iter_mut().enumerate().for_each(|(rank, beginning)| beginning.rank = rank);
        }
        // Stable: of equal ranks that at the plain fit comes first.
        let mut ranked: Vec<Beginning> = points.concat();
        ranked.sort_by_key(|beginning| beginning.rank);
        let mut all: Vec<Beginnings> = Vec::new();
        for beginning in ranked {
            let same = |b: &&mut Beginnings| b[0].promise.candidate == beginning.promise.candidate;
            match all.iter_mut().find(same) {
                Some(beginnings) => beginnings.push(beginning),
                None => all.push(vec![beginning]),
            }
        }
        all
    }

    /// Where each effect's refit may begin elsewhere than at the plain fit, what promises most there first.
    pub(super) fn beginnings_at<'b>(&self, there: &Elsewhere<'b>) -> Vec<Beginning<'b>> {
        most_promising_first(self.shown.iter().map(|s| self.beginning_at(there, s)).collect())
    }

    /// Where an effect's refit may begin elsewhere than at the plain fit.
    pub(super) fn beginning_at<'b>(&self, there: &Elsewhere<'b>, s: &Screened) -> Beginning<'b> {
        let Elsewhere { x, chi_square, tangent } = there;
        self.beginning(s, (x, *chi_square), (&tangent.linear, &tangent.covariance))
    }

    /// Where an effect's refit may begin: at parameters where the plain model has a chi^2, and is linearised with a covariance.
    fn beginning<'b>(
        &self,
        s: &Screened,
        (x, chi_square): (&'b [f64], f64),
        (linear, covariance): (&Linearised, &Covariance),
    ) -> Beginning<'b> {
        let promise = self.promise(s, linear, covariance);
        // More than the whole gap cannot be gained.
        let promise = Promise { gain: promise.gain.min(excess(self.plain)), ..promise };
        Beginning { promise, rank: 0, is_at_fit: false, x, chi_square }
    }

    /// What an effect promises around a linearised model.
    pub(super) fn promise(&self, s: &Screened, linear: &Linearised, covariance: &Covariance) -> Promise {
        let signature = linear.signature(covariance, &s.change_mn);
        let rest = &linear.residual;
        Promise {
            candidate: s.candidate,
            magnitude: signature.magnitude(rest).0,
            gain: signature.score(rest).powi(2),
            evidence: linear_evidence(&self.candidates[s.candidate], &signature, rest),
            giving_way: linear.giving_way(covariance, &s.change_mn).as_slice().to_vec(),
        }
    }
}
