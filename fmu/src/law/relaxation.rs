//! Newton's iteration of one viscous update, `eps - eps_trial + k beta(eps) = 0` with `k = dt / (2 eta)`.

use super::branch::Relaxed;
use super::ogden::Ogden;
use crate::number::{Real, closure, each};

/// A residual of the strain from which one more iteration leads to rounding.
const LAST: f64 = 3e-8;

/// A strain on the way to the root of `eps - eps_trial + k beta(eps)`.
#[derive(Clone, Copy)]
pub(super) struct Iterate<'a, T> {
    spring: &'a Ogden,
    /// Fluidity (1/Pa).
    k: f64,
    strain: [T; 3],
    powers: [T; 3],
    residual: [T; 3],
    /// Square of the residual's size.
    pub square: T,
    /// Where that is small enough for the last correction.
    pub last: T,
}

impl<'a, T: Real> Iterate<'a, T> {
    #[inline(always)]
    pub fn start(spring: &'a Ogden, trial: &[T; 3], k: f64) -> Self {
        // Exact at small strain.
        let share = 1.0 / (1.0 + k * spring.small_strain_stiffness());
        let largest = trial[0].max(-trial[0]).max(trial[1].max(-trial[1])).max(trial[2].max(-trial[2]));
        let size = (largest + 1.0) * LAST;
        Self::at(spring, k, size * size, each(trial, closure!(|t: T| t * share)), trial)
    }

    #[inline(always)]
    fn at(spring: &'a Ogden, k: f64, last: T, strain: [T; 3], trial: &[T; 3]) -> Self {
        let powers = spring.powers(&strain);
        let beta = spring.stress(&powers);
        let at = closure!(|i: usize| beta[i].mul_add(last.constant(k), strain[i] - trial[i]));
        let residual = [at(0), at(1), at(2)];
        Self { spring, k, strain, powers, residual, square: square(&residual), last }
    }

    /// Newton's correction.
    #[inline(always)]
    pub fn correction(&self) -> [T; 3] {
        Relaxation::new(&self.spring.stiffness(&self.powers), self.k).apply(&self.residual)
    }

    /// The iterate at the strain less `de`.
    #[inline(always)]
    pub fn after(&self, de: &[T; 3], trial: &[T; 3]) -> Self {
        Self::at(self.spring, self.k, self.last, difference(&self.strain, de), trial)
    }

    /// The strain less a small `de`.
    #[inline(always)]
    pub fn moved(&self, de: &[T; 3]) -> Relaxed<T> {
        moved(self.spring, &self.strain, &self.powers, de)
    }
}

/// A strain, of these powers, less a small `de`.
#[inline(always)]
pub(crate) fn moved<T: Real>(spring: &Ogden, strain: &[T; 3], powers: &[T; 3], de: &[T; 3]) -> Relaxed<T> {
    let power = closure!(|a: usize| powers[a] * spring.power_of_small(-de[a]));
    Relaxed { strain: difference(strain, de), powers: [power(0), power(1), power(2)] }
}

/// What `attempt` makes of the longest of the steps 1, 1/2, 1/4, ... that succeeds, if one of at least `shortest` does.
pub(super) fn line_search<I>(shortest: f64, attempt: impl Fn(f64) -> Option<I>) -> Option<I> {
    let steps = std::iter::successors(Some(1.0), |step| Some(0.5 * step));
    steps.take_while(|&step| step >= shortest).find_map(attempt)
}

/// `(I + k P diag(a))^-1` by the Sherman–Morrison formula, over a common denominator: with `D_i = 1 + k a_i`,
/// `O_i` the product of the two others and `M` the mean of those,
/// `(delta_ij O_i M + k / 3 O_i O_j a_j) / (D_1 D_2 D_3 M)`.
pub(super) struct Relaxation<T> {
    /// `O_i`.
    others: [T; 3],
    /// `a_i O_i`.
    pub pulls: [T; 3],
    /// `M`.
    pub mean: T,
    /// `1 / (D_1 D_2 D_3 M)`.
    pub inverse: T,
    /// `k / 3`, in every lane.
    pub k: T,
}

impl<T: Real> Relaxation<T> {
    #[inline(always)]
    pub fn new(a: &[T; 3], k: f64) -> Self {
        let d = each(a, closure!(|a_i: T| a_i * k + 1.0));
        let others = [d[1] * d[2], d[0] * d[2], d[0] * d[1]];
        let pulls = [a[0] * others[0], a[1] * others[1], a[2] * others[2]];
        let mean = (others[0] + others[1] + others[2]) * (1.0 / 3.0);
        let inverse = (d[0] * others[0] * mean).recip();
        Self { others, pulls, mean, inverse, k: mean.constant(k / 3.0) }
    }

    #[inline(always)]
    fn apply(&self, v: &[T; 3]) -> [T; 3] {
        let Self { others, pulls, mean, inverse, k } = self;
        let pull = pulls[0].mul_add(v[0], pulls[1].mul_add(v[1], pulls[2] * v[2])) * *k;
        let at = closure!(|i: usize| mean.mul_add(v[i], pull) * (others[i] * *inverse));
        [at(0), at(1), at(2)]
    }

    #[inline(always)]
    pub fn matrix(&self) -> [[T; 3]; 3] {
        let Self { others, pulls, mean, inverse, k } = self;
        let rows = each(others, closure!(|o: T| o * *inverse));
        let off = closure!(|i: usize, j: usize| rows[i] * (pulls[j] * *k));
        let on = closure!(|i: usize| rows[i] * (*mean + pulls[i] * *k));
        [[on(0), off(0, 1), off(0, 2)], [off(1, 0), on(1), off(1, 2)], [off(2, 0), off(2, 1), on(2)]]
    }
}

/// `m v`.
#[inline(always)]
pub(crate) fn apply<T: Real>(m: &[[T; 3]; 3], v: &[T; 3]) -> [T; 3] {
    each(m, closure!(|row: [T; 3]| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]))
}

/// `a - b`.
#[inline(always)]
pub(crate) fn difference<T: Real>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + b`.
#[inline(always)]
pub(super) fn sum<T: Real>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Square of the size.
#[inline(always)]
pub(crate) fn square<T: Real>(v: &[T; 3]) -> T {
    v[0].mul_add(v[0], v[1].mul_add(v[1], v[2] * v[2]))
}
