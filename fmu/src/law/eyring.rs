//! Nonlinear (Eyring) viscosity: `gamma_dot = (tau_0 / eta) sinh(tau / tau_0)`, tau the shear stress
//! `sqrt(beta:beta / 2)` of a branch; eta is the viscosity at small stress.
//!
//! In principal logarithmic strains `eps = eps_trial - k phi beta`, `k = dt / (2 eta)`, `phi = sinh(x) / x`,
//! `x = c |beta|`, `c = 1 / (sqrt 2 tau_0)`. The iteration solves the inverse form
//! `beta(eps) = v / |v| asinh(c |v| / k) / c`, `v = eps_trial - eps`: both sides are gradients of convex
//! functions, and no exponential of a trial stress can overflow.

use super::branch::Relaxed;
use super::ogden::Ogden;
use super::relaxation::{apply, difference, line_search, moved, square};
use crate::number::{Real, closure, each};

pub(crate) type Matrix<T> = [[T; 3]; 3];

const MAX_ITERATIONS: usize = 100;
/// A correction (strain) after which one more is rounding: Newton's method squares it.
const LAST: f64 = 1e-9;
const MIN_STEP: f64 = 1e-6;
/// Iterations of the start along the trial strain.
const START_ITERATIONS: usize = 2;

/// The flow rule of one branch over one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EyringFlow {
    /// `dt / (2 eta)` (1/Pa).
    pub k: f64,
    /// `1 / (sqrt 2 tau_0)` (1/Pa).
    pub c: f64,
}

/// The linearised update: changes of the strain follow from `inverse` and `slope`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linearised<T = f64> {
    /// `(k d beta/d eps + k d s/d v)^-1` [-].
    pub inverse: Matrix<T>,
    /// `d eps / d eps_trial` [-].
    pub slope: Matrix<T>,
    /// What drives a change with the fluidity: `d eps = -inverse drive dk` (Pa).
    pub drive: [T; 3],
}

/// A strain on the way to the solution.
#[derive(Clone, Copy)]
struct EyringIterate<T> {
    strain: [T; 3],
    powers: [T; 3],
    /// Strain that flows, `v`.
    flowing: [T; 3],
    /// `c |v| / k` and its [`ratio`].
    argument: T,
    ratio: T,
    /// `k beta - ratio v`.
    residual: [T; 3],
    /// Square of its size.
    square: T,
}

impl EyringFlow {
    /// Relaxes the deviatoric trial strain, in all lanes together until the last has converged.
    ///
    /// # Errors
    /// `None` where the plain iteration fails: see [`Self::relax_damped`].
    #[inline(always)]
    pub fn relax<T: Real>(&self, spring: &Ogden, trial: &[T; 3]) -> Option<Relaxed<T>> {
        if self.k == 0.0 {
            // No time passes and nothing flows.
            return Some(Relaxed { strain: *trial, powers: spring.powers(trial) });
        }
        let mut now = self.start(spring, trial);
        let (last, any) = (now.square.constant(LAST * LAST), now.square.constant(f64::INFINITY));
        for _ in 0..MAX_ITERATIONS {
            let de = self.correction(spring, &now);
            let size = square(&de);
            if last.all_greater(size) {
                return Some(moved(spring, &now.strain, &now.powers, &de));
            }
            let next = self.at(spring, trial, difference(&now.strain, &de));
            // Where the solution is reached, the residual is rounding.
            if !last.where_greater(size, any, now.square).all_greater(next.square) {
                return None;
            }
            now = next;
        }
        None
    }

    /// The same of one trial strain with a line search.
    ///
    /// # Errors
    /// `None` when the strain is too large for the exponentials.
    #[cold]
    #[inline(never)]
    pub fn relax_damped(&self, spring: &Ogden, trial: &[f64; 3]) -> Option<Relaxed> {
        let mut now = self.start(spring, trial);
        for _ in 0..MAX_ITERATIONS {
            let de = self.correction(spring, &now);
            let size = square(&de).sqrt();
            if !size.is_finite() {
                return None;
            }
            if size <= LAST {
                return Some(moved(spring, &now.strain, &now.powers, &de));
            }
            now = line_search(MIN_STEP, |step| {
                let next = self.at(spring, trial, difference(&now.strain, &de.map(|x| step * x)));
                (next.square < now.square).then_some(next)
            })?;
        }
        None
    }

    /// The solution of a linear spring, nearly: a part of the trial strain, `A s = asinh(B (1 - s))`. Newton's iteration
    /// from the linear dashpot's part comes down to it, since the difference of both sides is convex.
    #[inline(always)]
    fn start<T: Real>(&self, spring: &Ogden, trial: &[T; 3]) -> EyringIterate<T> {
        let Self { k, c } = *self;
        let size = square(trial).sqrt();
        let (a, b) = (size * (c * spring.small_strain_stiffness()), size * (c / k));
        let mut share = size.constant(1.0 / (1.0 + k * spring.small_strain_stiffness()));
        for _ in 0..START_ITERATIONS {
            let argument = b - b * share;
            let fall = argument.mul_add(ratio(argument), -(a * share));
            let slope = b / argument.mul_add(argument, one(b)).sqrt() + a;
            share += fall / slope.max(size.constant(f64::MIN_POSITIVE));
        }
        self.at(spring, trial, each(trial, closure!(|t: T| t * share)))
    }

    #[inline(always)]
    fn at<T: Real>(&self, spring: &Ogden, trial: &[T; 3], strain: [T; 3]) -> EyringIterate<T> {
        let powers = spring.powers(&strain);
        let beta = spring.stress(&powers);
        let flowing = difference(trial, &strain);
        let argument = square(&flowing).sqrt() * (self.c / self.k);
        let ratio = ratio(argument);
        let residual = difference(&each(&beta, closure!(|b: T| b * self.k)), &scaled(&flowing, ratio));
        let square = square(&residual);
        EyringIterate { strain, powers, flowing, argument, ratio, residual, square }
    }

    /// Newton's correction.
    #[inline(always)]
    fn correction<T: Real>(&self, spring: &Ogden, now: &EyringIterate<T>) -> [T; 3] {
        let EyringIterate { powers, flowing, argument: y, ratio, residual, .. } = now;
        let along = y.mul_add(*y, one(*y)).sqrt().recip();
        let bow = rank_one(*ratio, along, flowing);
        apply(&inverse(&self.system(spring, powers, &bow)), residual)
    }

    #[inline(always)]
    fn system<T: Real>(&self, spring: &Ogden, powers: &[T; 3], bow: &Matrix<T>) -> Matrix<T> {
        let tangent = spring.tangent(powers);
        let row = closure!(|i: usize| {
            let at = closure!(|j: usize| tangent[i][j] * self.k + bow[i][j]);
            [at(0), at(1), at(2)]
        });
        [row(0), row(1), row(2)]
    }

    /// The update linearised where it ended, from the powers of the elastic stretches.
    #[inline(always)]
    pub fn linearise<T: Real>(&self, spring: &Ogden, powers: &[T; 3]) -> Linearised<T> {
        let beta = spring.stress(powers);
        let x = square(&beta).sqrt() * self.c;
        let Hyperbolic { phi, cosh, decline } = Hyperbolic::of(x);
        let bow = rank_one(phi.recip(), cosh.recip(), &beta);
        let inverse = inverse(&self.system(spring, powers, &bow));
        Linearised { inverse, slope: product(&inverse, &bow), drive: scaled(&beta, decline) }
    }

    /// Change of the strain by `c` (Pa) at fixed trial strain, from the powers of the elastic stretches:
    /// `-inverse (k/c) (1 - tanh(x)/x) beta`.
    #[inline(always)]
    pub fn by_stress_factor<T: Real>(&self, spring: &Ogden, powers: &[T; 3]) -> [T; 3] {
        let beta = spring.stress(powers);
        let x = square(&beta).sqrt() * self.c;
        let inverse = self.linearise(spring, powers).inverse;
        apply(&inverse, &scaled(&beta, Hyperbolic::of(x).decline_lost(x) * (-self.k / self.c)))
    }

    /// Factor on the rate of flow of the linear dashpot.
    #[inline(always)]
    pub fn acceleration<T: Real>(&self, beta: &[T; 3]) -> T {
        Hyperbolic::of(square(beta).sqrt() * self.c).phi
    }
}

/// Hyperbolic functions of a number that is not negative.
struct Hyperbolic<T> {
    /// `sinh(x) / x`.
    phi: T,
    cosh: T,
    /// `tanh(x) / x`.
    decline: T,
}

impl<T: Real> Hyperbolic<T> {
    #[inline(always)]
    fn of(x: T) -> Self {
        /// Below, differences of exponentials lose digits; above, tanh is 1.
        const SMALL: f64 = 0.1;
        const LARGE: f64 = 20.0;
        let (up, square) = (x.exp(), x * x);
        let down = up.recip();
        let cosh = (up + down) * 0.5;
        let series =
            ((square * (1.0 / 72.0) + 1.0) * square * (1.0 / 42.0) + 1.0) * square * (1.0 / 20.0) + 1.0;
        let series = series * square * (1.0 / 6.0) + 1.0;
        // Divisors are kept from zero where the quotient is not taken: hosts may trap it.
        let (small, large) = (x.constant(SMALL), x.constant(LARGE));
        let phi = small.where_greater(x, series, (up - down) * 0.5 / x.max(small));
        Self { phi, cosh, decline: x.where_greater(large, x.max(large).recip(), phi / cosh) }
    }

    /// `1 - tanh(x) / x`, to rounding.
    #[inline(always)]
    fn decline_lost(&self, x: T) -> T {
        /// Below, the difference loses digits.
        const SMALL: f64 = 0.1;
        let square = x * x;
        let series = (square * (1382.0 / 155_925.0) - 62.0 / 2835.0) * square + 17.0 / 315.0;
        let series = ((series * square - 2.0 / 15.0) * square + 1.0 / 3.0) * square;
        x.constant(SMALL).where_greater(x, series, -self.decline + 1.0)
    }
}

/// `asinh(y) / y`.
#[inline(always)]
fn ratio<T: Real>(y: T) -> T {
    /// Below, the logarithm is that of nearly 1.
    const SMALL: f64 = 0.02;
    let square = y * y;
    let series = ((square * (-15.0 / 336.0) + 3.0 / 40.0) * square - 1.0 / 6.0) * square + 1.0;
    let asinh = ((square + 1.0).sqrt() + y).ln();
    let small = y.constant(SMALL);
    small.where_greater(y, series, asinh / y.max(small))
}

/// `across (I - n n) + along n n`, n the direction of `v`.
#[inline(always)]
fn rank_one<T: Real>(across: T, along: T, v: &[T; 3]) -> Matrix<T> {
    let (square, zero) = (square(v), across.constant(0.0));
    let least = across.constant(f64::MIN_POSITIVE);
    let factor = square.where_greater(zero, (along - across) / square.max(least), zero);
    let row = closure!(|i: usize| {
        let at = closure!(|j: usize| factor * v[i] * v[j] + if i == j { across } else { zero });
        [at(0), at(1), at(2)]
    });
    [row(0), row(1), row(2)]
}

#[inline(always)]
fn one<T: Real>(like: T) -> T {
    like.constant(1.0)
}

#[inline(always)]
fn scaled<T: Real>(v: &[T; 3], factor: T) -> [T; 3] {
    each(v, closure!(|x: T| x * factor))
}

/// `a b`.
#[inline(always)]
pub(crate) fn product<T: Real>(a: &Matrix<T>, b: &Matrix<T>) -> Matrix<T> {
    let row = closure!(|a_i: [T; 3]| {
        let at = closure!(|j: usize| a_i[0] * b[0][j] + a_i[1] * b[1][j] + a_i[2] * b[2][j]);
        [at(0), at(1), at(2)]
    });
    each(a, row)
}

/// The inverse of a positive definite matrix; a stress beyond all numbers leaves the unit matrix.
#[inline(always)]
fn inverse<T: Real>(m: &Matrix<T>) -> Matrix<T> {
    let minor = closure!(|i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    });
    let determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
    let (zero, largest) = (determinant.constant(0.0), determinant.constant(f64::MAX));
    let least = determinant.constant(1e-300);
    let row = closure!(|i: usize| {
        let at = closure!(|j: usize| {
            let unit = determinant.constant(if i == j { 1.0 } else { 0.0 });
            let entry = determinant.where_greater(zero, minor(j, i) / determinant.max(least), unit);
            determinant.where_greater(largest, unit, entry)
        });
        [at(0), at(1), at(2)]
    });
    [row(0), row(1), row(2)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::parameters::OgdenParameters;

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
                    let flow = EyringFlow { k: dt / 101.2, c: std::f64::consts::FRAC_1_SQRT_2 / tau_0 };
                    let plain = flow.relax(&spring(), &trial);
                    for relaxed in plain.into_iter().chain(flow.relax_damped(&spring(), &trial)) {
                        let beta = spring().stress(&spring().powers(&relaxed.strain));
                        let v = difference(&trial, &relaxed.strain);
                        // The inverse form, which has no large numbers.
                        let argument = flow.c / flow.k * square(&v).sqrt();
                        let ratio = if argument > 0.0 { argument.asinh() / argument } else { 1.0 };
                        for a in 0..3 {
                            let error = flow.k * beta[a] - ratio * v[a];
                            assert!(error.abs() < 1e-12 * (1.0 + dt), "{trial:?} {dt} {tau_0}: {error:e}");
                        }
                    }
                    assert!(flow.relax_damped(&spring(), &trial).is_some(), "{trial:?} {dt} {tau_0}");
                }
            }
        }
    }

    /// The line search is for the rare: strains and steps of indentation need none.
    #[test]
    fn plain_iteration_is_enough_for_soft_samples() {
        for tau_0 in [10.0, 200.0, 1e4] {
            for dt in [1e-3, 0.1, 10.0] {
                for size in [1e-6, 0.01, 0.1, 0.3, 0.6] {
                    let flow = EyringFlow { k: dt / 101.2, c: std::f64::consts::FRAC_1_SQRT_2 / tau_0 };
                    let trial = [size, -0.3 * size, -0.7 * size];
                    assert!(flow.relax(&spring(), &trial).is_some(), "{tau_0} {dt} {size}");
                }
            }
        }
    }

    #[test]
    fn hyperbolic_functions_are_the_librarys() {
        for x in [1e-12, 1e-3, 0.0999, 0.1001, 1.0, 19.9, 20.1, 300.0] {
            let Hyperbolic { phi, cosh, decline } = Hyperbolic::of(x);
            approx::assert_relative_eq!(phi, x.sinh() / x, max_relative = 4e-15);
            approx::assert_relative_eq!(cosh, x.cosh(), max_relative = 4e-15);
            approx::assert_relative_eq!(decline, x.tanh() / x, max_relative = 4e-15);
            approx::assert_relative_eq!(ratio(x), x.asinh() / x, max_relative = 1e-14);
        }
        let Hyperbolic { phi, cosh, decline } = Hyperbolic::of(0.0);
        assert_eq!((phi, cosh, decline, ratio(0.0)), (1.0, 1.0, 1.0, 1.0));
        let beyond = Hyperbolic::of(1e3);
        assert_eq!((beyond.phi.recip(), beyond.cosh.recip(), beyond.decline), (0.0, 0.0, 1e-3));
    }

    #[test]
    fn linearisation_matches_finite_differences() {
        let (flow, trial, h) = (EyringFlow { k: 5e-5, c: 7e-3 }, [0.2, -0.15, -0.05], 1e-6);
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
        let at =
            |s: f64| EyringFlow { k: flow.k * (1.0 + s), ..flow }.relax(&spring(), &trial).unwrap().strain;
        let (up, down) = (at(1e-5), at(-1e-5));
        for a in 0..3 {
            let slope = (up[a] - down[a]) / (2e-5 * flow.k);
            let analytic = -apply(&exact.inverse, &exact.drive)[a];
            approx::assert_relative_eq!(analytic, slope, max_relative = 1e-6);
        }
    }
}
