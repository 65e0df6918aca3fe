//! Implicit exponential update of one viscous branch (Eq. 12).
//!
//! In principal logarithmic strains the flow rule becomes `eps = eps_trial - k beta(eps)` with
//! `k = dt / (2 eta)`. It is the stationarity condition of a strictly convex function of the
//! deviatoric strain, so the solution is unique and a damped Newton iteration finds it.

use super::eyring::{self, Linearised};
use super::ogden::Ogden;
use super::parameters::BranchParameters;
use super::relaxation::{Iterate, Relaxation, apply, line_search, square, sum};
use super::spectral::deviator;
use crate::number::{Real, closure, each};

const MAX_ITERATIONS: usize = 100;
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
pub struct Relaxed<T = f64> {
    /// Deviatoric elastic logarithmic strains.
    pub strain: [T; 3],
    /// Powers of the elastic isochoric stretches.
    pub powers: [T; 3],
}

/// How the result of an update changes.
#[derive(Debug, Clone, Copy, Default)]
pub struct BranchSensitivity<T = f64> {
    /// `d eps / d eps_trial` on deviatoric strains [-].
    pub strain_slope: [[T; 3]; 3],
    /// `d eps` by mu (1/Pa), alpha [-] and eta (1/(Pa s)) at fixed trial strain.
    pub strain: [[T; 3]; 3],
    /// `d beta` by mu [-], alpha (Pa) and eta (1/s) at fixed trial strain.
    pub stress: [[T; 3]; 3],
}

impl Branch {
    /// The branch of a parameter set.
    pub fn new(p: &BranchParameters) -> Self {
        Self::extended(p, 1.0, 0.0)
    }

    /// The branch with `scale` times the stress at the same flow, and the inverse stress `1 / tau_0` (1/Pa)
    /// of Eyring flow; its derivatives are still those by the parameters.
    pub fn extended(p: &BranchParameters, scale: f64, inverse_stress: f64) -> Self {
        Self {
            spring: Ogden::scaled(&p.ogden, scale),
            eta: scale * p.eta,
            scale,
            eyring: inverse_stress * std::f64::consts::FRAC_1_SQRT_2 / scale,
        }
    }

    /// Whether its dashpot is linear.
    #[inline(always)]
    pub fn is_linear(&self) -> bool {
        self.eyring == 0.0
    }

    /// Eyring flow over `dt`, where the dashpot is not linear.
    #[inline(always)]
    fn eyring(&self, dt: f64) -> Option<eyring::EyringFlow> {
        (!self.is_linear()).then(|| eyring::EyringFlow { k: self.fluidity(dt), c: self.eyring })
    }

    /// `dt / (2 eta)` (1/Pa).
    #[inline(always)]
    pub fn fluidity(&self, dt: f64) -> f64 {
        0.5 * dt / self.eta
    }

    /// Relaxes the deviatoric trial strain `trial` over `dt`, in all lanes together until the last has converged.
    ///
    /// # Errors
    /// `None` when the strain is too large for the exponentials or the iteration stalls.
    #[inline(always)]
    pub fn relax<T: Real>(&self, trial: &[T; 3], dt: f64) -> Option<Relaxed<T>> {
        if let Some(flow) = self.eyring(dt) {
            let relaxed = flow.relax(&self.spring, trial);
            return relaxed.or_else(|| lane_by_lane(trial, |trial| flow.relax_damped(&self.spring, trial)));
        }
        let mut now = Iterate::start(&self.spring, trial, self.fluidity(dt));
        for _ in 0..MAX_ITERATIONS {
            let de = now.correction();
            if now.last.all_greater(now.square) {
                // Newton's method squares this error; the exponentials' series are as good as new ones.
                return Some(now.moved(&de));
            }
            let next = now.after(&de, trial);
            if !now.square.max(now.last).all_greater(next.square) {
                break;
            }
            now = next;
        }
        lane_by_lane(trial, |trial| self.relax_damped(trial, dt))
    }

    /// The same of one trial strain with a line search, where the plain iteration fails.
    #[cold]
    #[inline(never)]
    fn relax_damped(&self, trial: &[f64; 3], dt: f64) -> Option<Relaxed> {
        let mut now = Iterate::start(&self.spring, trial, self.fluidity(dt));
        for _ in 0..MAX_ITERATIONS {
            if !now.square.is_finite() {
                return None;
            }
            let de = now.correction();
            if now.square < now.last {
                return Some(now.moved(&de));
            }
            now = line_search(MIN_STEP, |step| {
                let next = now.after(&de.map(|x| step * x), trial);
                (next.square < now.square).then_some(next)
            })?;
        }
        None
    }

    /// Algorithmic tangent `d beta / d eps_trial` (Pa), symmetric.
    #[inline(always)]
    pub fn tangent<T: Real>(&self, q: &[T; 3], dt: f64) -> [[T; 3]; 3] {
        if let Some(flow) = self.eyring(dt) {
            return self.eyring_tangent(q, &flow);
        }
        // P (diag(a)^-1 + k P)^-1 P, the inverse by the Sherman–Morrison formula.
        let a = self.spring.stiffness(q);
        let Relaxation { pulls: u, mean, inverse, k, .. } = Relaxation::new(&a, self.fluidity(dt));
        let sum = u[0] + u[1] + u[2];
        let share = sum.mul_add(k, mean) * inverse * (1.0 / 3.0);
        let rows = each(&u, closure!(|u: T| u * share));
        let whole = (rows[0] + rows[1] + rows[2]) * (1.0 / 3.0);
        let scaled = each(&u, closure!(|u: T| u * inverse));
        let off = closure!(|i: usize, j: usize| scaled[i].mul_add(k * u[j], whole - rows[i] - rows[j]));
        let (t01, t02, t12) = (off(0, 1), off(0, 2), off(1, 2));
        let on = closure!(|i: usize| scaled[i].mul_add(mean, off(i, i)));
        [[on(0), t01, t02], [t01, on(1), t12], [t02, t12, on(2)]]
    }

    #[inline(always)]
    fn eyring_tangent<T: Real>(&self, q: &[T; 3], flow: &eyring::EyringFlow) -> [[T; 3]; 3] {
        let tangent = self.spring.tangent(q);
        let slope = flow.linearise(&self.spring, q).slope;
        let mut t = eyring::product(&tangent, &slope);
        // Trial strains enter through their deviator only.
        for row in &mut t {
            *row = deviator(row);
        }
        t
    }

    /// Derivatives of an update by the trial strain and by the branch's parameters.
    #[inline(always)]
    pub fn sensitivity<T: Real>(&self, relaxed: &Relaxed<T>, dt: f64) -> BranchSensitivity<T> {
        let Relaxed { strain, powers } = relaxed;
        let k = self.fluidity(dt);
        let stress_tangent = self.spring.tangent(powers);
        let [by_mu, by_alpha] = self.spring.sensitivity(strain, powers);
        let Linearised { inverse, slope: strain_slope, drive } = match self.eyring(dt) {
            Some(flow) => flow.linearise(&self.spring, powers),
            None => {
                let inverse = Relaxation::new(&self.spring.stiffness(powers), k).matrix();
                Linearised { inverse, slope: inverse, drive: self.spring.stress(powers) }
            }
        };
        let scaled =
            closure!(|v: &[T; 3], factor: f64| apply(&inverse, &each(v, closure!(|x: T| x * factor))));
        // `eta` holds the scale already.
        let by_eta = scaled(&drive, k / self.eta * self.scale);
        let strain = [scaled(&by_mu, -k), scaled(&by_alpha, -k), by_eta];
        let mut stress = each(&strain, closure!(|e: [T; 3]| apply(&stress_tangent, &e)));
        for (total, explicit) in stress.iter_mut().zip([by_mu, by_alpha]) {
            *total = sum(total, &explicit);
        }
        BranchSensitivity { strain_slope, strain, stress }
    }

    /// Changes of an update's strain (Pa) and stress (Pa^2) by the inverse stress of Eyring flow at fixed trial strain; a linear
    /// dashpot has none, since `sinh(x) / x` is even.
    #[inline(always)]
    pub fn by_inverse_stress<T: Real>(&self, relaxed: &Relaxed<T>, dt: f64) -> [[T; 3]; 2] {
        let powers = &relaxed.powers;
        let Some(flow) = self.eyring(dt) else { return [each(powers, closure!(|p: T| p.constant(0.0))); 2] };
        let factor = std::f64::consts::FRAC_1_SQRT_2 / self.scale;
        let strain = each(&flow.by_stress_factor(&self.spring, powers), closure!(|e: T| e * factor));
        [strain, apply(&self.spring.tangent(powers), &strain)]
    }

    /// Dissipation rate `sum beta^2 / (2 eta)` (W/m^3) (Eq. 13), times `sinh(x) / x` of Eyring flow.
    #[inline(always)]
    pub fn dissipation<T: Real>(&self, beta: &[T; 3]) -> T {
        let linear = square(beta) * (0.5 / self.eta);
        match self.eyring(0.0) {
            None => linear,
            Some(flow) => linear * flow.acceleration(beta),
        }
    }
}

/// A scalar update in every lane.
#[inline(always)]
fn lane_by_lane<T: Real>(trial: &[T; 3], relax: impl Fn(&[f64; 3]) -> Option<Relaxed>) -> Option<Relaxed<T>> {
    let [a, b, c, p, q, r] = T::lanewise(trial, |trial| {
        let Relaxed { strain: [a, b, c], powers: [p, q, r] } = relax(&trial)?;
        Some([a, b, c, p, q, r])
    })?;
    Some(Relaxed { strain: [a, b, c], powers: [p, q, r] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::parameters::OgdenParameters;
    use crate::number::{Lanes, on_every_machine};

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

    fn eyring() -> Branch {
        let parameters = BranchParameters { ogden: OgdenParameters { mu: -418.0, alpha: -13.5 }, eta: 50.6 };
        Branch::extended(&parameters, 1.0, 5e-3)
    }

    const STEPS: [f64; 5] = [0.0, 1e-6, 1e-2, 1.0, 1e4];

    /// Trial strains of very different size, together and one by one.
    struct RelaxLanes;

    impl pulp::WithSimd for RelaxLanes {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, simd: S) {
            let size = |lane: usize| [0.0, 1e-9, 1e-3, 0.1, 0.3, 1.0, 3.0, 7.0][7 - lane];
            let cases = [(branch(), [0.6, -0.1, -0.5]), (eyring(), [0.3, -0.05, -0.25])];
            for ((branch, direction), dt) in cases.into_iter().flat_map(|c| STEPS.map(|dt| (c, dt))) {
                let trial = each(&direction, |d: f64| Lanes::from_fn(simd, |lane| size(lane) * d));
                let relaxed = branch.relax(&trial, dt).unwrap();
                for lane in 0..Lanes::<S>::COUNT {
                    let exact = branch.relax(&direction.map(|d| size(lane) * d), dt).unwrap();
                    for a in 0..3 {
                        let (strain, power) = (relaxed.strain[a].as_slice(), relaxed.powers[a].as_slice());
                        // Over a long step the rounding of the stress counts.
                        let rounding = 1e-13 * (1.0 + dt);
                        assert!((strain[lane] - exact.strain[a]).abs() < rounding, "{dt} {lane}");
                        approx::assert_relative_eq!(
                            power[lane],
                            exact.powers[a],
                            max_relative = 10.0 * rounding
                        );
                    }
                }
                let too_large = each(&direction, |d: f64| Lanes::splat(simd, 1e3 * d));
                // Within a long step, or where the flow grows with the stress, even such a strain relaxes.
                assert!(dt > 1e-3 || branch.eyring != 0.0 || branch.relax(&too_large, dt).is_none());
            }
        }
    }

    #[test]
    fn lanes_relax_like_single_strains() {
        on_every_machine(&|| RelaxLanes);
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
