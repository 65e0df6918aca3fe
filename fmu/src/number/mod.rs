//! Real numbers that the laws and the element are written for: one `f64`, or several elements' values at once
//! in the lanes of the machine's vectors.

mod functions;
mod lanes;

pub use lanes::{Lanes, PACKET, Packet};

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number, or several that are treated alike.
///
/// Nothing here panics: bad numbers become NaN, and NaN compares false.
pub trait Real:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
{
    /// `value` in every lane.
    fn constant(self, value: f64) -> Self;
    /// `self a + b`, rounded once where the machine does so at no cost.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Exponential, to about one unit in the last place.
    fn exp(self) -> Self;
    /// Natural logarithm of a positive normal number, to about one unit in the last place.
    fn ln(self) -> Self;
    /// Power of a positive number.
    fn powf(self, exponent: f64) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
    /// Whether every lane is greater than `other`'s.
    fn all_greater(self, other: Self) -> bool;
    /// `yes` in the lanes that are greater than `other`'s, else `no`.
    fn where_greater(self, other: Self, yes: Self, no: Self) -> Self;
    /// A function of `from` lane by lane, for what is rare; `None` when one lane has no value.
    fn lanewise<const M: usize, const N: usize>(
        from: &[Self; M],
        function: impl Fn([f64; M]) -> Option<[f64; N]>,
    ) -> Option<[Self; N]>;

    /// `1 / self`.
    #[inline(always)]
    fn recip(self) -> Self {
        self.constant(1.0) / self
    }
}

/// A closure that is always compiled in line (stable Rust allows the attribute only before arguments).
macro_rules! closure {
    ($($closure:tt)*) => {
        std::convert::identity(#[inline(always)] $($closure)*)
    };
}
pub(crate) use closure;

/// `f` of every entry. Vector instructions are only as fast as they should be in line: the closure of
/// `array::map` may stay a function of its own, one made by `closure!` may not.
#[inline(always)]
pub fn each<const N: usize, A: Copy, B: Copy>(v: &[A; N], f: impl Fn(A) -> B) -> [B; N] {
    each_of(v, closure!(|entry: &A| f(*entry)))
}

/// The same of entries that stay where they are.
#[inline(always)]
pub fn each_of<const N: usize, A, B: Copy>(v: &[A; N], f: impl Fn(&A) -> B) -> [B; N] {
    let mut result = [f(&v[0]); N];
    for i in 1..N {
        result[i] = f(&v[i]);
    }
    result
}

impl Real for f64 {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        // Where the compiler may not assume fused instructions, `f64::mul_add` is a slow library call.
        self * a + b
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn exp(self) -> Self {
        self.exp()
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.ln()
    }

    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        self.powf(exponent)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn all_greater(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn where_greater(self, other: Self, yes: Self, no: Self) -> Self {
        if self > other { yes } else { no }
    }

    #[inline(always)]
    fn lanewise<const M: usize, const N: usize>(
        from: &[Self; M],
        function: impl Fn([f64; M]) -> Option<[f64; N]>,
    ) -> Option<[Self; N]> {
        function(*from)
    }
}

/// What a computation gives in the vectors of every kind that this machine has, first in single lanes.
#[cfg(test)]
#[inline(never)]
pub(crate) fn on_every_machine<F: pulp::WithSimd>(work: &dyn Fn() -> F) -> Vec<F::Output> {
    let mut results = vec![pulp::Simd::vectorize(pulp::Scalar::new(), work())];
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(v3) = pulp::x86::V3::try_new() {
            results.push(pulp::Simd::vectorize(v3, work()));
        }
        if let Some(v4) = pulp::x86::V4::try_new() {
            results.push(pulp::Simd::vectorize(v4, work()));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    results.push(pulp::Arch::new().dispatch(work()));
    results
}
