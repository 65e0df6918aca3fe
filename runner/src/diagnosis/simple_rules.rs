//! What simpler methods would answer, as a yardstick: white noise and the Bayesian information criterion, always the
//! same effect, and the phase of the largest residual.

use super::location::{Pattern, Spot};
use super::result::SimpleRule;
use super::screening::Screened;
use crate::data::Phase;
use crate::inference::effect::{Candidate, Sign};
use crate::inference::fit::{Fit, linearised};
use crate::noise::Covariance;

/// All of them.
pub fn simple_rules(
    plain: &Fit,
    screened: &[Screened],
    candidates: &[Candidate],
    spots: &[Spot],
) -> Vec<SimpleRule> {
    vec![
        SimpleRule { rule: "white-noise BIC".to_owned(), effect: white_bic(plain, screened, candidates) },
        SimpleRule { rule: "always a slow branch".to_owned(), effect: Some("third_branch".to_owned()) },
        SimpleRule { rule: "phase of the largest residual".to_owned(), effect: largest_phase(plain, spots) },
    ]
}

/// The effect of the largest gain in chi^2 with white noise alone, if it is worth a parameter (ln of the number of
/// points).
fn white_bic(plain: &Fit, screened: &[Screened], candidates: &[Candidate]) -> Option<String> {
    let white = Covariance::new(plain.covariance.white_mn().clone(), vec![]);
    let linear = linearised(&plain.jacobian_mn, &plain.gap_mn, &white, &plain.prior, &plain.solution.x);
    let worth = |s: &Screened| {
        let candidate = &candidates[s.candidate];
        let signature = linear.signature(&white, &s.change_mn);
        let score = signature.score(&linear.residual);
        let gain = match candidate.effect.sign {
            Sign::Switch => signature.gain_of_one(&linear.residual),
            _ => candidate.one_sided(score).powi(2),
        };
        (gain - (plain.gap_mn.len() as f64).ln(), candidate.effect.family.clone())
    };
    let best = screened.iter().map(worth).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > 0.0).then_some(best.1)
}

/// What a rule of thumb makes of the phase with the largest mean residual.
fn largest_phase(plain: &Fit, spots: &[Spot]) -> Option<String> {
    let level = |s: &&Spot| s.pattern == Pattern::Level;
    let mean = |s: &Spot| {
        let sum: f64 = s.points.iter().map(|&i| plain.gap_mn[i]).sum();
        (sum / s.points.len().max(1) as f64).abs()
    };
    let worst = spots.iter().filter(level).max_by(|a, b| mean(a).total_cmp(&mean(b)))?;
    let effect = match worst.phase? {
        Phase::Approach => "offset",
        Phase::Ramp => "compliance",
        Phase::HoldEarly => "load_cell_lag",
        Phase::HoldMiddle => "eyring",
        Phase::HoldLate => "third_branch",
        Phase::Unload => "softening",
        Phase::Recovery => "load_cell_drift",
    };
    Some(effect.to_owned())
}
