//! Nonlinear (Eyring) viscosity: `gamma_dot = (tau_0 / eta) sinh(tau / tau_0)`, tau the shear stress
//! `sqrt(beta:beta / 2)` of a branch; eta is the viscosity at small stress.
//!
//! In principal logarithmic strains `eps = eps_trial - k phi beta`, `k = dt / (2 eta)`, `phi = sinh(x) / x`,
//! `x = c |beta|`, `c = 1 / (sqrt 2 tau_0)`. The iteration solves the inverse form
//! `beta(eps) = v / |v| asinh(c |v| / k) / c`, `v = eps_trial - eps`: both sides are gradients of convex
//! functions, and no exponential of a trial stress can overflow.

use super::descriptor::{Effect, Place, linear, one_sided};
use crate::material::branch::Relaxed;
use crate::material::ogden::Ogden;
use crate::variables::units::PER_PASCAL;
use crate::variables::{Variable, field, real};
use serde::{Deserialize, Serialize};

/// The stress that drives the flow out of proportion.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameters {
    /// `1 / tau_0` (1/Pa), of all branches.
    pub inverse_stress: f64,
}

impl Parameters {
    pub(crate) fn is_active(&self) -> bool {
        self.inverse_stress != 0.0
    }
}

type Matrix = [[f64; 3]; 3];

const MAX_ITERATIONS: usize = 100;
/// A correction (strain) after which one more is rounding: Newton's method squares it.
const LAST: f64 = 1e-9;
const MIN_STEP: f64 = 1e-6;

/// The flow rule of one branch over one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flow {
    /// `dt / (2 eta)` (1/Pa).
    pub k: f64,
    /// `1 / (sqrt 2 tau_0)` (1/Pa).
    pub c: f64,
}

/// The linearised update: changes of the strain follow from `inverse` and `slope`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linearised<T = f64> {
    /// `(k d beta/d eps + k d s/d v)^-1` [-].
    pub inverse: [[T; 3]; 3],
    /// `d eps / d eps_trial` [-].
    pub slope: [[T; 3]; 3],
    /// What drives a change with the fluidity: `d eps = -inverse drive dk` (Pa).
    pub drive: [T; 3],
}

impl Flow {
    /// Relaxes the deviatoric trial strain; as `Branch::relax`.
    #[inline(never)]
    pub fn relax(&self, spring: &Ogden, trial: &[f64; 3]) -> Option<Relaxed> {
        let Self { k, c } = *self;
        if k == 0.0 {
            // No time passes and nothing flows.
            return Some(Relaxed { strain: *trial, powers: spring.powers(trial) });
        }
        // The solution of the linear dashpot: its stress is too large, but finite.
        let share = 1.0 / (1.0 + k * spring.small_strain_stiffness());
        let mut e = trial.map(|t| share * t);
        let residual = |e: &[f64; 3]| -> ([f64; 3], [f64; 3]) {
            let v: [f64; 3] = std::array::from_fn(|a| trial[a] - e[a]);
            let ratio = ratio((c / k) * norm(&v));
            let beta = spring.stress(&spring.powers(e));
            (std::array::from_fn(|a| k * beta[a] - ratio * v[a]), v)
        };
        let (mut g, mut v) = residual(&e);
        for _ in 0..MAX_ITERATIONS {
            let y = (c / k) * norm(&v);
            let bow = rank_one(ratio(y), 1.0 / (1.0 + y * y).sqrt(), &v);
            let inverse = inverse(&sum(&scaled(&spring.tangent(&spring.powers(&e)), k), &bow))?;
            let de = apply(&inverse, &g);
            let size = norm(&de);
            if !size.is_finite() {
                return None;
            }
            let moved = |step: f64| std::array::from_fn(|a| e[a] - step * de[a]);
            if size <= LAST {
                let strain = moved(1.0);
                return Some(Relaxed { strain, powers: spring.powers(&strain) });
            }
            let mut step = 1.0;
            loop {
                let next = moved(step);
                let (g_next, v_next) = residual(&next);
                if norm(&g_next) < norm(&g) {
                    (e, g, v) = (next, g_next, v_next);
                    break;
                }
                step *= 0.5;
                if step < MIN_STEP {
                    return None;
                }
            }
        }
        None
    }

    /// The update linearised where it ended, from the powers of the elastic stretches.
    pub fn linearise(&self, spring: &Ogden, powers: &[f64; 3]) -> Linearised {
        let Self { k, c } = *self;
        let beta = spring.stress(powers);
        let x = c * norm(&beta);
        let (phi, cosh) = (phi(x), x.cosh());
        let bow = rank_one(1.0 / phi, 1.0 / cosh, &beta);
        let system = sum(&scaled(&spring.tangent(powers), k), &bow);
        // Positive definite: a stress beyond all numbers leaves the unit matrix.
        let inverse = inverse(&system).unwrap_or(IDENTITY);
        // For x beyond the range of cosh the ratio is its limit.
        let drive = beta.map(|b| b * (x.tanh() / x.max(f64::MIN_POSITIVE)));
        Linearised { inverse, slope: product(&inverse, &bow), drive: if x > 1e-4 { drive } else { beta } }
    }

    /// Factor on the rate of flow of the linear dashpot.
    pub fn acceleration(&self, beta: &[f64; 3]) -> f64 {
        phi(self.c * norm(beta))
    }
}

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `asinh(y) / y`.
fn ratio(y: f64) -> f64 {
    if y < 1e-4 { 1.0 - y * y / 6.0 } else { y.asinh() / y }
}

/// `sinh(x) / x`.
fn phi(x: f64) -> f64 {
    if x < 1e-4 { 1.0 + x * x / 6.0 } else { x.sinh() / x }
}

/// `across (I - n n) + along n n`, n the direction of `v`.
fn rank_one(across: f64, along: f64, v: &[f64; 3]) -> Matrix {
    let square = v.iter().map(|x| x * x).sum::<f64>();
    let factor = if square > 0.0 { (along - across) / square } else { 0.0 };
    std::array::from_fn(|i| std::array::from_fn(|j| across * IDENTITY[i][j] + factor * v[i] * v[j]))
}

fn norm(v: &[f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

fn apply(m: &Matrix, v: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

fn scaled(m: &Matrix, factor: f64) -> Matrix {
    m.map(|row| row.map(|x| factor * x))
}

fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|m| a[i][m] * b[m][j]).sum()))
}

fn inverse(m: &Matrix) -> Option<Matrix> {
    let minor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    (determinant > 0.0 && determinant.is_finite())
        .then(|| std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / determinant)))
}

pub(super) const VARIABLES: &[Variable] = &[real(
    "effect.eyring.inverse_stress",
    "1/tau_0 of the branches' flow, shear rate (tau_0/eta) sinh(stress/tau_0); 0: linear dashpots",
    &PER_PASCAL,
    (0.0, 10.0),
    field!(Real, padded.effect.eyring.inverse_stress),
)];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "eyring",
    title: "nonlinear (Eyring) viscosity",
    place: Place::Specimen,
    variants: &[one_sided("sinh flow", &[linear("effect.eyring.inverse_stress", 0.0, 5e-3)])],
    physics: "Stress helps the dashpots' units over their barriers, so that the rate of flow grows with the \
              hyperbolic sine of the stress. Peaks are cut the more the faster they are reached, and relaxation \
              begins fast and ends slowly.",
    revealed_by: "The ratio of peaks at two rates below that of linear dashpots; relaxation whose shape depends \
                  on the depth.",
    mimicked_by: "A spectrum of branches at one rate and depth; compliance or lag at the peak.",
    mimics: &["third_branch", "compliance", "load_cell_lag"],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::OgdenParameters;

    const TRIALS: [[f64; 3]; 3] = [[0.3, -0.1, -0.2], [-0.9, 0.5, 0.4], [1e-9, 0.0, -1e-9]];

    fn spring() -> Ogden {
        Ogden::new(&OgdenParameters { mu: -418.0, alpha: -13.5 })
    }

    /// From far below to far above the stress tau_0, for steps from tiny to beyond all relaxation.
    #[test]
    fn update_satisfies_the_flow_rule() {
        for trial in TRIALS {
            for dt in [1e-6, 1e-2, 1.0, 1e4] {
                for tau_0 in [1e-1, 1e2, 1e6] {
                    let flow = Flow { k: dt / 101.2, c: std::f64::consts::FRAC_1_SQRT_2 / tau_0 };
                    let relaxed = flow.relax(&spring(), &trial).unwrap();
                    let beta = spring().stress(&spring().powers(&relaxed.strain));
                    let v: [f64; 3] = std::array::from_fn(|a| trial[a] - relaxed.strain[a]);
                    // The inverse form, which has no large numbers.
                    let ratio = ratio(flow.c / flow.k * norm(&v));
                    for a in 0..3 {
                        let error = flow.k * beta[a] - ratio * v[a];
                        assert!(error.abs() < 1e-12 * (1.0 + dt), "{trial:?} {dt} {tau_0}: {error:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn linearisation_matches_finite_differences() {
        let (flow, trial, h) = (Flow { k: 5e-5, c: 7e-3 }, [0.2, -0.15, -0.05], 1e-6);
        let exact = flow.linearise(&spring(), &flow.relax(&spring(), &trial).unwrap().powers);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let at = |s: f64| {
                let mut moved = trial;
                moved[i] += s;
                moved[j] -= s;
                flow.relax(&spring(), &moved).unwrap().strain
            };
            let (up, down) = (at(h), at(-h));
            for a in 0..3 {
                let slope = (up[a] - down[a]) / (2.0 * h);
                let analytic = exact.slope[a][i] - exact.slope[a][j];
                approx::assert_relative_eq!(analytic, slope, max_relative = 1e-6, epsilon = 1e-8);
            }
        }
        let at = |s: f64| Flow { k: flow.k * (1.0 + s), ..flow }.relax(&spring(), &trial).unwrap().strain;
        let (up, down) = (at(1e-5), at(-1e-5));
        for a in 0..3 {
            let slope = (up[a] - down[a]) / (2e-5 * flow.k);
            let analytic = -apply(&exact.inverse, &exact.drive)[a];
            approx::assert_relative_eq!(analytic, slope, max_relative = 1e-6);
        }
    }
}
