//! Implicit exponential update of one viscous branch (Eq. 12).
//!
//! In principal logarithmic strains the flow rule becomes `eps = eps_trial - k beta(eps)` with
//! `k = dt / (2 eta)`. It is the stationarity condition of a strictly convex function of the
//! deviatoric strain, so the solution is unique and a damped Newton iteration finds it.

use super::ogden::Ogden;
use crate::effect::eyring::{self, Linearised};
use crate::parameters::BranchParameters;

const MAX_ITERATIONS: usize = 100;
/// Residuals of the strain below this are rounding.
const ROUNDING: f64 = 1e-14;
/// A residual from which one more iteration leads to rounding.
const LAST: f64 = 3e-8;
/// The line search gives up here: the function is convex, so only numbers out of range lead here.
const MIN_STEP: f64 = 1e-4;

/// One spring and dashpot in series.
#[derive(Debug, Clone, Copy)]
pub struct Branch {
    /// The spring.
    pub spring: Ogden,
    eta: f64,
    /// Factor on the parameter eta that is part of `eta` already.
    scale: f64,
    /// `1 / (sqrt 2 tau_0)` of Eyring flow (1/Pa); 0: a linear dashpot.
    eyring: f64,
}

/// Result of one update.
#[derive(Debug, Clone, Copy, Default)]
pub struct Relaxed {
    /// Deviatoric elastic logarithmic strains.
    pub strain: [f64; 3],
    /// Powers of the elastic isochoric stretches.
    pub powers: [f64; 3],
}

/// How the result of an update changes.
#[derive(Debug, Clone, Copy, Default)]
pub struct BranchSensitivity {
    /// `d eps / d eps_trial` on deviatoric strains [-].
    pub strain_slope: [[f64; 3]; 3],
    /// `d eps` by mu (1/Pa), alpha [-] and eta (1/(Pa s)) at fixed trial strain.
    pub strain: [[f64; 3]; 3],
    /// `d beta` by mu [-], alpha (Pa) and eta (1/s) at fixed trial strain.
    pub stress: [[f64; 3]; 3],
}

impl Branch {
    /// The branch of a parameter set.
    pub fn new(p: &BranchParameters) -> Self {
        Self::with_effects(p, 1.0, 0.0)
    }

    /// The branch with `scale` times the stress at the same flow, and the inverse stress `1 / tau_0` (1/Pa)
    /// of Eyring flow; its derivatives are still those by the parameters.
    pub fn with_effects(p: &BranchParameters, scale: f64, inverse_stress: f64) -> Self {
        Self {
            spring: Ogden::scaled(&p.ogden, scale),
            eta: scale * p.eta,
            scale,
            eyring: inverse_stress * std::f64::consts::FRAC_1_SQRT_2 / scale,
        }
    }

    /// Eyring flow over `dt`, where the dashpot is not linear.
    #[inline(always)]
    fn eyring(&self, dt: f64) -> Option<eyring::Flow> {
        (self.eyring != 0.0).then(|| eyring::Flow { k: self.fluidity(dt), c: self.eyring })
    }

    /// `dt / (2 eta)` (1/Pa).
    #[inline(always)]
    pub fn fluidity(&self, dt: f64) -> f64 {
        0.5 * dt / self.eta
    }

    /// Relaxes the deviatoric trial strain `trial` over `dt`.
    ///
    /// # Errors
    /// `None` when the strain is too large for the exponentials or the iteration stalls.
    #[inline(always)]
    pub fn relax(&self, trial: &[f64; 3], dt: f64) -> Option<Relaxed> {
        if let Some(flow) = self.eyring(dt) {
            return flow.relax(&self.spring, trial);
        }
        let k = self.fluidity(dt);
        // Exact at small strain.
        let share = 1.0 / (1.0 + k * self.spring.small_strain_stiffness());
        let mut e = trial.map(|t| share * t);
        let mut q = self.spring.powers(&e);
        let mut r = self.residual(&e, &q, trial, k);
        let mut norm = norm(&r);
        let size = 1.0 + trial.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
        for _ in 0..MAX_ITERATIONS {
            if !norm.is_finite() {
                return None;
            }
            if norm <= ROUNDING * size {
                return Some(Relaxed { strain: e, powers: q });
            }
            let inverse = relaxation(&self.spring.stiffness(&q), k);
            let de = apply(&inverse, &r);
            if norm <= LAST * size {
                // Newton's method squares this error; the exponentials' series are as good as new ones.
                return Some(self.moved(&e, &q, &de));
            }
            let mut step = 1.0;
            loop {
                let next = [e[0] - step * de[0], e[1] - step * de[1], e[2] - step * de[2]];
                let q_next = self.spring.powers(&next);
                let r_next = self.residual(&next, &q_next, trial, k);
                let norm_next = self::norm(&r_next);
                if norm_next < norm {
                    (e, q, r, norm) = (next, q_next, r_next, norm_next);
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

    /// The strain `e - de` for a small `de`.
    #[inline(always)]
    fn moved(&self, e: &[f64; 3], q: &[f64; 3], de: &[f64; 3]) -> Relaxed {
        let strain = std::array::from_fn(|a| e[a] - de[a]);
        let powers = std::array::from_fn(|a| q[a] * self.spring.power_of_small(-de[a]));
        Relaxed { strain, powers }
    }

    /// Algorithmic tangent `d beta / d eps_trial` (Pa), symmetric.
    #[inline(always)]
    pub fn tangent(&self, q: &[f64; 3], dt: f64) -> [[f64; 3]; 3] {
        let tangent = self.spring.tangent(q);
        let inverse = match self.eyring(dt) {
            None => relaxation(&self.spring.stiffness(q), self.fluidity(dt)),
            Some(flow) => flow.linearise(&self.spring, q).slope,
        };
        let mut t = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                t[i][j] = (0..3).map(|m| tangent[i][m] * inverse[m][j]).sum();
            }
        }
        // Trial strains enter through their deviator only.
        for row in &mut t {
            let mean = (row[0] + row[1] + row[2]) / 3.0;
            row.iter_mut().for_each(|v| *v -= mean);
        }
        t
    }

    /// Derivatives of an update by the trial strain and by the branch's parameters.
    #[inline(always)]
    pub fn sensitivity(&self, relaxed: &Relaxed, dt: f64) -> BranchSensitivity {
        let Relaxed { strain, powers } = relaxed;
        let k = self.fluidity(dt);
        let stress_tangent = self.spring.tangent(powers);
        let [by_mu, by_alpha] = self.spring.sensitivity(strain, powers);
        let Linearised { inverse, slope: strain_slope, drive } = match self.eyring(dt) {
            Some(flow) => flow.linearise(&self.spring, powers),
            None => {
                let inverse = relaxation(&self.spring.stiffness(powers), k);
                Linearised { inverse, slope: inverse, drive: self.spring.stress(powers) }
            }
        };
        let scaled = |v: &[f64; 3], factor: f64| apply(&inverse, &v.map(|x| factor * x));
        // `eta` holds the scale already.
        let by_eta = scaled(&drive, k / self.eta * self.scale);
        let strain = [scaled(&by_mu, -k), scaled(&by_alpha, -k), by_eta];
        let mut stress = strain.map(|e| apply(&stress_tangent, &e));
        for (total, explicit) in stress.iter_mut().zip([by_mu, by_alpha]) {
            (0..3).for_each(|a| total[a] += explicit[a]);
        }
        BranchSensitivity { strain_slope, strain, stress }
    }

    /// Dissipation rate `sum beta^2 / (2 eta)` (W/m^3) (Eq. 13), times `sinh(x) / x` of Eyring flow.
    #[inline(always)]
    pub fn dissipation(&self, beta: &[f64; 3]) -> f64 {
        let linear = beta.iter().map(|b| b * b).sum::<f64>() / (2.0 * self.eta);
        self.eyring(0.0).map_or(linear, |flow| linear * flow.acceleration(beta))
    }

    #[inline(always)]
    fn residual(&self, e: &[f64; 3], q: &[f64; 3], trial: &[f64; 3], k: f64) -> [f64; 3] {
        let beta = self.spring.stress(q);
        std::array::from_fn(|i| e[i] - trial[i] + k * beta[i])
    }
}

/// `(I + k P diag(a))^-1` by the Sherman–Morrison formula.
#[inline(always)]
pub fn relaxation(a: &[f64; 3], k: f64) -> [[f64; 3]; 3] {
    let d = a.map(|a_i| 1.0 / (1.0 + k * a_i));
    let w: [f64; 3] = std::array::from_fn(|i| a[i] * d[i]);
    let factor = (k / 3.0) / (1.0 - (k / 3.0) * (w[0] + w[1] + w[2]));
    let mut m = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] = d[i] * factor * w[j];
        }
        m[i][i] += d[i];
    }
    m
}

#[inline(always)]
fn apply(m: &[[f64; 3]; 3], v: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

#[inline(always)]
fn norm(v: &[f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::OgdenParameters;

    fn branch() -> Branch {
        Branch::new(&BranchParameters { ogden: OgdenParameters { mu: -418.0, alpha: -13.5 }, eta: 50.6 })
    }

    #[test]
    fn update_satisfies_the_flow_rule() {
        for trial in [[0.3, -0.1, -0.2], [-0.9, 0.5, 0.4], [1e-9, 0.0, -1e-9]] {
            for dt in [1e-6, 1e-2, 1.0, 1e4] {
                let b = branch();
                let relaxed = b.relax(&trial, dt).unwrap();
                let beta = b.spring.stress(&b.spring.powers(&relaxed.strain));
                for a in 0..3 {
                    let residual = relaxed.strain[a] - trial[a] + dt / (2.0 * 50.6) * beta[a];
                    assert!(residual.abs() < 1e-12 * (1.0 + dt), "{trial:?} {dt}: {residual}");
                    let power = b.spring.powers(&relaxed.strain)[a];
                    approx::assert_relative_eq!(relaxed.powers[a], power, max_relative = 1e-14);
                }
            }
        }
    }

    #[test]
    fn tangent_matches_finite_differences() {
        let (b, dt, h) = (branch(), 5e-3, 1e-6);
        let trial = [0.2, -0.15, -0.05];
        let stress = |eps: [f64; 3]| {
            let mean = (eps[0] + eps[1] + eps[2]) / 3.0;
            b.spring.stress(&b.relax(&eps.map(|x| x - mean), dt).unwrap().powers)
        };
        let tangent = b.tangent(&b.relax(&trial, dt).unwrap().powers, dt);
        for j in 0..3 {
            let (mut up, mut down) = (trial, trial);
            up[j] += h;
            down[j] -= h;
            let (up, down) = (stress(up), stress(down));
            for i in 0..3 {
                let slope = (up[i] - down[i]) / (2.0 * h);
                approx::assert_relative_eq!(tangent[i][j], slope, max_relative = 1e-6, epsilon = 1e-4);
            }
        }
    }
}
