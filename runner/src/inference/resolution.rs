//! Which branches the data tell apart, and how finely.
//!
//! A branch's force `Q` follows `dQ/dt = dF/dt - Q / tau`. With `g = dQ/d ln tau` the second derivative `h` follows from both,
//! `dh/dt = (2 g - Q - h) / tau`. Two branches of half the modulus each, a factor `exp(2 d)` apart about `tau`, have the force
//! `Q + h d^2 / 2` to the second order. Where what a refit of everything else leaves of that is below the noise, they look like the one
//! branch that was fitted: its modulus is that of all that relaxes within this factor.

use super::fit::Fit;
use super::linearised::Linearised;
use super::setup::Setup;
use super::statistics::Statistics;
use crate::data::Cycle;
use nalgebra::{DMatrix, DVector};

/// What is left of a difference must be so many deviations to be seen: 97.5 % quantile of the normal distribution.
const SEEN: f64 = 1.96;

/// How a branch stands beside the others and in the time of the test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The data tell it from the others.
    Apart,
    /// Nearer to its neighbour than two branches can be to look like two.
    Close,
    /// Slower than the longest hold: how much of it would relax after its end is not in the data.
    Slow,
}

/// A fitted branch.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedBranch {
    /// Its number, as in `G_1`.
    pub label: String,
    /// Relaxation time (s).
    pub tau_s: f64,
    /// Two branches nearer than this factor look like one.
    pub factor: f64,
    /// How it stands.
    pub standing: Standing,
}

impl ResolvedBranch {
    /// Relaxation times (s) that look like this branch's.
    pub fn times_s(&self) -> [f64; 2] {
        let half = self.factor.sqrt();
        [self.tau_s / half, self.tau_s * half]
    }
}

/// The branches of a fit whose modulus and time are variables, the fastest first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Resolution {
    /// The branches.
    pub branches: Vec<ResolvedBranch>,
    /// Longest hold (s).
    pub hold_s: f64,
    /// Times (s) at which the relaxation modulus is told: decades from the shortest ramp to the longest hold, and that.
    pub told_s: Vec<f64>,
}

impl Resolution {
    /// Of a fit.
    pub fn of(setup: Setup, fit: &Fit, statistics: &Statistics) -> Self {
        let Some(back) = setup.unknowns.terms().1.try_inverse() else { return Self::default() };
        let cycles = || setup.observations.iter().flat_map(|o| &o.cycles);
        let hold_s = cycles().map(Cycle::hold_s).fold(0.0, f64::max);
        let ramp_s = cycles().map(|c| c.times.ramp_end_s - c.times.ramp_start_s).fold(hold_s, f64::min);
        let times: Vec<&[f64]> = setup.observations.iter().map(|o| &*o.time_s).collect();
        let by_terms = &fit.jacobian_mn * back;
        let x = DVector::from_column_slice(&fit.solution.x);
        let (design, rest) = statistics.stacked(&fit.prior, &x, (&fit.jacobian_mn, &fit.gap_mn), &|_| true);
        let linear = Linearised::new(design, &rest);
        let place = |name: &str| statistics.terms.iter().position(|t| t.parameter.name == name);
        let one = |(modulus, term): (usize, &super::ParameterEstimate)| {
            let label = term.parameter.name.strip_prefix("shear_modulus[")?.strip_suffix(']')?;
            let time = place(&format!("relaxation_time[{label}]"))?;
            let tau_s = statistics.terms[time].value;
            let h = second(&times, &by_terms, (modulus, time), tau_s);
            let strength = 0.5 * linear.signature(&statistics.covariance, &h).strength();
            let factor = (2.0 * (SEEN / strength.max(f64::MIN_POSITIVE)).sqrt()).exp();
            Some(ResolvedBranch { label: label.to_owned(), tau_s, factor, standing: Standing::Apart })
        };
        let mut branches: Vec<ResolvedBranch> = statistics.terms.iter().enumerate().filter_map(one).collect();
        branches.sort_by(|a, b| a.tau_s.total_cmp(&b.tau_s));
        Self { branches, hold_s, told_s: decades(ramp_s, hold_s) }.judged()
    }

    /// With how each branch stands.
    fn judged(mut self) -> Self {
        for k in 1..self.branches.len() {
            if self.is_near(k - 1) {
                self.branches[k - 1].standing = Standing::Close;
                self.branches[k].standing = Standing::Close;
            }
        }
        for branch in self.branches.iter_mut().filter(|b| b.tau_s > self.hold_s) {
            branch.standing = Standing::Slow;
        }
        self
    }

    /// Whether a branch and the next slower one are too near to look like two.
    fn is_near(&self, k: usize) -> bool {
        let (faster, slower) = (&self.branches[k], &self.branches[k + 1]);
        slower.tau_s < faster.tau_s * faster.factor.min(slower.factor)
    }

    /// Neighbours that are too near to look like two.
    pub fn close_pairs(&self) -> impl Iterator<Item = [&ResolvedBranch; 2]> {
        let near = |k: &usize| self.is_near(*k);
        (0..self.branches.len().saturating_sub(1))
            .filter(near)
            .map(|k| [&self.branches[k], &self.branches[k + 1]])
    }

    /// Relaxation times (s) that a modulus stands for; none for other quantities.
    pub fn scope_s(&self, name: &str) -> Option<[f64; 2]> {
        let label = name.strip_prefix("shear_modulus[")?.strip_suffix(']')?;
        let (first, last) = (self.branches.first()?, self.branches.last()?);
        match label {
            "0" => Some([first.times_s()[0], f64::INFINITY]),
            "inf" => Some([last.times_s()[1], f64::INFINITY]),
            _ => {
                let branch = |label: &str| self.branches.iter().find(|b| b.label == label);
                let (from, to) = label.split_once('+').unwrap_or((label, label));
                Some([branch(from)?.times_s()[0], branch(to)?.times_s()[1]])
            }
        }
    }

    /// The branch that a quantity or parameter belongs to: `shear_modulus[1]`, `relaxation_time[1]`, `material.branch[1].eta`.
    pub fn branch_of(&self, name: &str) -> Option<&ResolvedBranch> {
        let of_branch = ["shear_modulus[", "relaxation_time[", "material.branch["];
        let rest = of_branch.iter().find_map(|prefix| name.strip_prefix(prefix))?;
        let (label, _) = rest.split_once(']')?;
        self.branches.iter().find(|b| b.label == label)
    }

    /// Whether a value holds for this division into branches only, which the data do not tell from others.
    pub fn is_arbitrary(&self, name: &str) -> bool {
        let is_slow = || self.branches.iter().any(|b| b.standing == Standing::Slow);
        let is_equilibrium = name == "shear_modulus[inf]" || name.starts_with("material.equilibrium.");
        self.branch_of(name).is_some_and(|b| b.standing != Standing::Apart) || (is_equilibrium && is_slow())
    }
}

/// Second derivative of the force by the logarithm of a branch's time (mN): from the derivatives by those of its modulus, which is its force,
/// and of its time.
fn second(
    tests: &[&[f64]],
    by_terms: &DMatrix<f64>,
    (modulus, time): (usize, usize),
    tau_s: f64,
) -> DVector<f64> {
    let mut h = DVector::zeros(by_terms.nrows());
    let drive = |i: usize| 2.0 * by_terms[(i, time)] - by_terms[(i, modulus)];
    let mut first = 0;
    for time_s in tests {
        for i in 1..time_s.len() {
            let part = (time_s[i] - time_s[i - 1]) / tau_s;
            let (now, next) = weights(part);
            let i = first + i;
            h[i] = h[i - 1] * (-part).exp() + now * drive(i - 1) + next * drive(i);
        }
        first += time_s.len();
    }
    h
}

/// Powers of ten between two times (s), and the second of them.
fn decades(from_s: f64, to_s: f64) -> Vec<f64> {
    if from_s <= 0.0 || to_s <= from_s {
        return vec![];
    }
    let powers = from_s.log10().ceil() as i32..to_s.log10().ceil() as i32;
    powers.map(|k| 10f64.powi(k)).chain([to_s]).collect()
}

/// Weights of both ends of an interval in the integral of `exp(-(t - s) / tau) / tau` times what is linear in between; `x` is the interval
/// over `tau`.
fn weights(x: f64) -> (f64, f64) {
    /// Below it the closed form cancels.
    const SMALL: f64 = 1e-4;
    if x < SMALL {
        return (0.5 * x, 0.5 * x);
    }
    let mean = -(-x).exp_m1() / x;
    (mean - (-x).exp(), 1.0 - mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn branch(label: &str, tau_s: f64, factor: f64) -> ResolvedBranch {
        ResolvedBranch { label: label.to_owned(), tau_s, factor, standing: Standing::Apart }
    }

    /// In a hold from t = 0 on, `Q = exp(-x)`, `g = x Q` and `h = (x^2 - x) Q`, with `x = t / tau`.
    #[test]
    fn the_second_derivative_of_a_step_is_found() {
        let tau = 7.0;
        let time_s: Vec<f64> = (0..400).map(|i| 0.1 * f64::from(i)).collect();
        let both = DMatrix::from_fn(time_s.len(), 2, |i, j| {
            let x = time_s[i] / tau;
            (-x).exp() * if j == 0 { 1.0 } else { x }
        });
        let h = second(&[&time_s], &both, (0, 1), tau);
        for (i, t) in time_s.iter().enumerate() {
            let x = t / tau;
            assert!((h[i] - (x * x - x) * (-x).exp()).abs() < 1e-4, "{t}: {}", h[i]);
        }
    }

    #[test]
    fn branches_nearer_than_the_data_resolve_or_slower_than_the_hold_are_not_claimed() {
        let branches = vec![branch("1", 1.0, 2.0), branch("2", 1.5, 3.0), branch("3", 500.0, 2.0)];
        let found = Resolution { branches, hold_s: 300.0, told_s: vec![] }.judged();
        let pairs: Vec<_> = found.close_pairs().map(|pair| pair.map(|b| b.label.as_str())).collect();
        assert_eq!(pairs, [["1", "2"]]);
        for (name, arbitrary) in [
            ("shear_modulus[1]", true),
            ("relaxation_time[2]", true),
            ("material.branch[3].eta", true),
            ("shear_modulus[inf]", true),
            ("shear_modulus[0]", false),
        ] {
            assert_eq!(found.is_arbitrary(name), arbitrary, "{name}");
        }
        let branches = vec![branch("1", 1.0, 2.0), branch("2", 5.0, 3.0)];
        let found = Resolution { branches, hold_s: 300.0, told_s: vec![] }.judged();
        assert!(found.branches.iter().all(|b| b.standing == Standing::Apart));
        assert!(!found.is_arbitrary("shear_modulus[inf]"));
        let scope = found.scope_s("shear_modulus[1+2]").unwrap();
        assert!((scope[0] - 1.0 / 2f64.sqrt()).abs() < 1e-12 && (scope[1] - 5.0 * 3f64.sqrt()).abs() < 1e-12);
        assert_eq!(decades(0.9, 300.0), [1.0, 10.0, 100.0, 300.0]);
    }
}
