//! A spring, alone or in series with a dashpot (Eqs. 8, 9, 12), at finite strain.
//!
//! The state is `C = F^-1 b_e F^-T`, the inverse of the viscous right Cauchy-Green tensor; Eq. 12 is then the ordinary
//! differential equation `dC/dt = -F^-1 (tau b_e / eta) F^-T`. Any linear multistep formula
//! `C = C* + gamma dC/dt` becomes, in the principal axes of `F C* F^T`, three scalar equations
//! `(1 + gamma tau_a / eta) lambda_a^2 = lambda*_a^2`.

use super::ogden::principal;
use super::{Symmetric, Tensor};
use crate::error::Failure;
use crate::specimen::Ogden;
use nalgebra::{Matrix3, Vector3};

/// Carreau's law: the fluidity grows as `(1 + (s/stress)^2)^exponent`, `s^2 = tau:tau / 2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thinning {
    /// Shear stress at which it begins (Pa).
    pub stress: f64,
    /// Exponent [-]; a power law of index `1 / (1 + 2 exponent)`.
    pub exponent: f64,
}

/// Flow within a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow {
    /// `gamma / eta` (1/Pa); 0 for a spring alone.
    pub per_stress: f64,
    /// Nonlinear viscosity.
    pub thinning: Option<Thinning>,
}

/// Stress of the branch with its tangent.
pub(super) struct Stress {
    /// Kirchhoff stress (Pa).
    pub tau: Symmetric,
    /// `d tau / d l`, `l = dF F^-1` (Pa).
    pub tangent: [[f64; 5]; 4],
    /// b_e at the end of the step.
    pub elastic: Symmetric,
    /// Energy of the spring (J/m^3).
    pub energy: f64,
}

/// Solves the flow and returns `(tau, d tau / d trial strain, strain, energy)` in principal axes.
#[expect(clippy::type_complexity)]
fn relax(
    law: &Ogden,
    flow: &Flow,
    trial: &[f64; 3],
) -> Result<([f64; 3], Matrix3<f64>, [f64; 3], f64), Failure> {
    let c = flow.per_stress;
    if c == 0.0 {
        let p = principal(law, trial);
        return Ok((p.stress, Matrix3::from_fn(|a, b| p.stiffness[a][b]), *trial, p.energy));
    }
    // Residual c phi tau - (exp(2 (trial - strain)) - 1) and its derivative: for phi = 1 that of a convex function.
    let evaluate = |strain: &[f64; 3]| {
        let p = principal(law, strain);
        let tau = Vector3::from(p.stress);
        let stiffness = Matrix3::from_fn(|a, b| p.stiffness[a][b]);
        let shear2 = 0.5 * tau.norm_squared();
        let (phi, slope) = flow.thinning.map_or((1.0, 0.0), |t| {
            let base = 1.0 + shear2 / (t.stress * t.stress);
            (base.powf(t.exponent), t.exponent * base.powf(t.exponent - 1.0) / (t.stress * t.stress))
        });
        let e = Vector3::from_fn(|a, _| (2.0 * (trial[a] - strain[a])).exp());
        let residual = c * phi * tau - e.add_scalar(-1.0);
        let mut jacobian = c * phi * stiffness + Matrix3::from_diagonal(&(2.0 * e));
        if slope != 0.0 {
            jacobian += c * slope * tau * (stiffness * tau).transpose();
        }
        (residual, jacobian, e, p)
    };
    let mean = (trial[0] + trial[1] + trial[2]) / 3.0;
    let mut strain = *trial;
    let mut now = evaluate(&strain);
    // A stiff or thin dashpot relaxes nearly all within the step: then start there.
    let relaxed = evaluate(&[mean; 3]);
    if relaxed.0.norm() < now.0.norm() {
        strain = [mean; 3];
        now = relaxed;
    }
    for _ in 0..60 {
        let step = now.1.try_inverse().ok_or(Failure::Flow)? * now.0;
        let size = step.amax();
        if !size.is_finite() {
            return Err(Failure::Flow);
        }
        let mut part = (1.0 / size).min(1.0);
        let next = loop {
            let next = [0, 1, 2].map(|a| strain[a] - part * step[a]);
            let there = evaluate(&next);
            if there.0.norm() <= now.0.norm() * (1.0 - 1e-4 * part) || part * size < 1e-12 {
                break (next, there);
            }
            part *= 0.5;
        };
        (strain, now) = next;
        if size < 1e-7 {
            let (_, jacobian, e, p) = now;
            let by_trial = jacobian.try_inverse().ok_or(Failure::Flow)? * Matrix3::from_diagonal(&(2.0 * e));
            let stiffness = Matrix3::from_fn(|a, b| p.stiffness[a][b]);
            return Ok((p.stress, stiffness * by_trial, strain, p.energy));
        }
    }
    Err(Failure::Flow)
}

/// Response to `trial = F C* F^T`.
pub(super) fn respond(law: &Ogden, flow: &Flow, trial: &Symmetric) -> Result<Stress, Failure> {
    let (mid, half) = (0.5 * (trial[0] + trial[1]), 0.5 * (trial[0] - trial[1]));
    let radius = half.hypot(trial[2]);
    let first = mid + radius;
    let second = (trial[0] * trial[1] - trial[2] * trial[2]) / first;
    if !(first > 0.0 && second > 0.0 && trial[3] > 0.0) {
        return Err(Failure::Inverted);
    }
    // The first principal direction is (cos, sin).
    let (cos, sin) = match radius > 1e-14 * mid {
        true => {
            let double = half / radius;
            let cos = (0.5 * (1.0 + double)).sqrt();
            let sin = (0.5 * (1.0 - double)).sqrt().copysign(trial[2]);
            (cos, sin)
        }
        false => (1.0, 0.0),
    };
    let strain = [first, second, trial[3]].map(|b| 0.5 * b.ln());
    let (tau, by_strain, relaxed, energy) = relax(law, flow, &strain)?;
    // dtau_12 = turning (l_12 second + first l_21), from the rotation of the axes.
    let turning = match first - second > 1e-5 * mid {
        true => (tau[0] - tau[1]) / (first - second),
        false => {
            let d = &by_strain;
            (d[(0, 0)] - d[(0, 1)] - d[(1, 0)] + d[(1, 1)]) / (2.0 * (first + second))
        }
    };
    let (cc, ss, cs) = (cos * cos, sin * sin, cos * sin);
    let principal_rates: [[f64; 5]; 3] =
        [[cc, cs, cs, ss, 0.0], [ss, -cs, -cs, cc, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]];
    let l12 = [-cs, cc, -ss, cs, 0.0];
    let l21 = [-cs, -ss, cc, cs, 0.0];
    let mut tangent = [[0.0; 5]; 4];
    for k in 0..5 {
        let rate = [0, 1, 2].map(|a| principal_rates[a][k]);
        let d = [0, 1, 2]
            .map(|a| by_strain[(a, 0)] * rate[0] + by_strain[(a, 1)] * rate[1] + by_strain[(a, 2)] * rate[2]);
        let shear = turning * (l12[k] * second + first * l21[k]);
        tangent[0][k] = cc * d[0] + ss * d[1] - 2.0 * cs * shear;
        tangent[1][k] = ss * d[0] + cc * d[1] + 2.0 * cs * shear;
        tangent[2][k] = cs * (d[0] - d[1]) + (cc - ss) * shear;
        tangent[3][k] = d[2];
    }
    let turn = |v: [f64; 3]| [cc * v[0] + ss * v[1], ss * v[0] + cc * v[1], cs * (v[0] - v[1]), v[2]];
    Ok(Stress { tau: turn(tau), tangent, elastic: turn(relaxed.map(|e| (2.0 * e).exp())), energy })
}

/// `F^-1 b F^-T`, scaled to determinant one: the flow is isochoric.
pub(super) fn state(inverse: &Tensor, elastic: &Symmetric) -> Symmetric {
    let c = super::push(inverse, elastic);
    let det = (c[0] * c[1] - c[2] * c[2]) * c[3];
    let scale = det.cbrt().recip();
    c.map(|c| c * scale)
}
