//! Several numbers in one vector register.

use super::{Real, closure, functions};
use pulp::{Simd, bytemuck};
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Elements that are stored together: as many as the widest vector has lanes.
pub const PACKET: usize = 8;

/// One number of every element of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[repr(C, align(64))]
pub struct Packet(pub [f64; PACKET]);

/// The lanes of one vector; `simd` is the proof that the machine has it, of size zero.
#[derive(Debug, Clone, Copy)]
pub struct Lanes<S: Simd> {
    simd: S,
    v: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// Number of lanes; it divides [`PACKET`].
    pub const COUNT: usize = S::F64_LANES;

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, v: simd.splat_f64s(value) }
    }

    /// Numbers `part COUNT..` of a packet.
    #[inline(always)]
    pub fn load(simd: S, packet: &Packet, part: usize) -> Self {
        Self { simd, v: S::as_simd_f64s(&packet.0).0[part] }
    }

    /// One number per lane.
    #[inline(always)]
    pub fn from_fn(simd: S, mut value: impl FnMut(usize) -> f64) -> Self {
        let mut lanes = Self::splat(simd, 0.0);
        for (lane, v) in lanes.as_mut_slice().iter_mut().enumerate() {
            *v = value(lane);
        }
        lanes
    }

    /// The numbers.
    #[inline(always)]
    pub fn as_slice(&self) -> &[f64] {
        bytemuck::cast_slice(std::slice::from_ref(&self.v))
    }

    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [f64] {
        bytemuck::cast_slice_mut(std::slice::from_mut(&mut self.v))
    }

    /// The same function of every lane's bits.
    #[inline(always)]
    pub(super) fn map_bits(mut self, function: impl Fn(u64) -> u64) -> Self {
        for v in self.as_mut_slice() {
            *v = f64::from_bits(function(v.to_bits()));
        }
        self
    }
}

macro_rules! operator {
    ($name:ident, $function:ident, $vector:ident) => {
        impl<S: Simd> $name for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self { simd: self.simd, v: self.simd.$vector(self.v, other.v) }
            }
        }

        impl<S: Simd> $name<f64> for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                $name::$function(self, Self::splat(self.simd, other))
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> SubAssign for Lanes<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { v: self.simd.xor_f64s(self.v, self.simd.splat_f64s(-0.0)), ..self }
    }
}

impl<S: Simd> Real for Lanes<S> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self { v: self.simd.mul_add_e_f64s(self.v, a.v, b.v), ..self }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self { v: self.simd.sqrt_f64s(self.v), ..self }
    }

    #[inline(always)]
    fn exp(self) -> Self {
        functions::exp(self)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        functions::ln(self)
    }

    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        Self::from_fn(self.simd, closure!(|lane: usize| self.as_slice()[lane].powf(exponent)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self { v: self.simd.max_f64s(self.v, other.v), ..self }
    }

    #[inline(always)]
    fn all_greater(self, other: Self) -> bool {
        let greater = self.simd.greater_than_f64s(self.v, other.v);
        self.simd.first_true_m64s(self.simd.not_m64s(greater)) >= Self::COUNT
    }

    #[inline(always)]
    fn where_greater(self, other: Self, yes: Self, no: Self) -> Self {
        let greater = self.simd.greater_than_f64s(self.v, other.v);
        Self { v: self.simd.select_f64s(greater, yes.v, no.v), ..self }
    }

    #[inline(never)]
    fn lanewise<const M: usize, const N: usize>(
        from: &[Self; M],
        function: impl Fn([f64; M]) -> Option<[f64; N]>,
    ) -> Option<[Self; N]> {
        let mut result = [from[0]; N];
        for lane in 0..Self::COUNT {
            let values = function(std::array::from_fn(|k| from[k].as_slice()[lane]))?;
            for (result, value) in result.iter_mut().zip(values) {
                result.as_mut_slice()[lane] = value;
            }
        }
        Some(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A packet whose numbers all differ.
    const SOME: Packet = Packet([0.5, -1.5, 2.0, 3.25, -4.0, 5.0, 6.5, 0.125]);

    struct Check;

    impl pulp::WithSimd for Check {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for part in 0..PACKET / Lanes::<S>::COUNT {
                let a = Lanes::load(simd, &SOME, part);
                let own = &SOME.0[part * Lanes::<S>::COUNT..][..Lanes::<S>::COUNT];
                assert_eq!(a.as_slice(), own);
                let is = |lanes: Lanes<S>, f: &dyn Fn(f64) -> f64| {
                    lanes.as_slice().iter().zip(own).for_each(|(v, x)| assert_eq!(*v, f(*x)));
                };
                is((a + 2.0) * a - a / (a + a), &|x| (x + 2.0) * x - 0.5);
                is(-a, &|x| -x);
                is((a * a).sqrt(), &f64::abs);
                is(a.mul_add(a, a), &|x| x * x + x);
                is(a.max(-a), &f64::abs);
                is(a.where_greater(a.constant(2.0), a, -a), &|x| if x > 2.0 { x } else { -x });
                is((a * a).powf(1.5), &|x| (x * x).powf(1.5));
                assert!(a.all_greater(a.constant(-5.0)));
                let last = own[own.len() - 1];
                assert!(!a.all_greater(a.constant(last)), "the last lane counts");
                assert!(!a.constant(f64::NAN).all_greater(a), "NaN is not greater");
                let [double, sum] = Lanes::lanewise(&[a, a], |[x, y]| Some([2.0 * x, x + y + 1.0])).unwrap();
                is(double, &|x| 2.0 * x);
                is(sum, &|x| 2.0 * x + 1.0);
                assert!(Lanes::lanewise(&[a], |[x]| (x != last).then_some([x])).is_none());
            }
        }
    }

    #[test]
    fn lanes_compute_like_numbers() {
        super::super::on_every_machine(&|| Check);
    }
}
