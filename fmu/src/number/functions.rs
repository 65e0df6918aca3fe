//! Exponential and logarithm of lanes.

use super::{Lanes, Real, closure};
use pulp::Simd;

/// Adding it rounds to an integer, which then is in the last bits.
const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
/// ln 2 in two parts, of which an exponent times the first is exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// Largest argument of an exponential that is a number.
const LARGEST: f64 = 709.782_712_893_384;
/// The exponential of less is given as zero (less than 1e-307).
const SMALLEST: f64 = -708.0;

/// `exp(x) = 2^n exp(r)`, n an integer and `|r| <= ln 2 / 2`; zero below [`SMALLEST`].
#[inline(always)]
pub(super) fn exp<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    let c = closure!(|value: f64| x.constant(value));
    let shifted = x.mul_add(c(std::f64::consts::LOG2_E), c(ROUND));
    let n = shifted - ROUND;
    let r = n.mul_add(c(-LN_2[1]), n.mul_add(c(-LN_2[0]), x));
    // exp(r) = 1 + r + r^2 q(r), in pairs: short chains of operations wait less for one another.
    let pair = closure!(|low: f64, high: f64| r.mul_add(c(high), c(low)));
    let (r2, q0, q1) = (
        r * r,
        pair(0.5, 0.166_666_666_666_666_85),
        pair(0.041_666_666_666_666_505, 0.008_333_333_333_316_527),
    );
    let (q2, q3) = (
        pair(0.001_388_888_888_897_745, 1.984_126_989_605_092e-4),
        pair(2.480_158_715_923_547_3e-5, 2.755_723_629_119_288e-6),
    );
    let (q4, r4) = (pair(2.755_739_112_349_004_7e-7, 2.511_129_308_928_765e-8), r2 * r2);
    let q4 = r2.mul_add(c(2.088_606_211_072_837e-9), q4);
    let q = (r4 * r4).mul_add(q4, r4.mul_add(r2.mul_add(q3, q2), r2.mul_add(q1, q0)));
    let p = r2.mul_add(q, r) + 1.0;
    // Half the power of two, so that its exponent stays in range for the largest arguments.
    let half = shifted.map_bits(closure!(|bits: u64| bits.wrapping_add(1022) << 52));
    let result = (p + p) * half;
    let result = x.where_greater(c(LARGEST), c(f64::INFINITY), result);
    c(SMALLEST).where_greater(x, c(0.0), result)
}

/// `ln x = k ln 2 + ln(1 + f)`, `1 + f` between `sqrt(1/2)` and `sqrt 2`; NaN unless x is positive and normal.
#[inline(always)]
pub(super) fn ln<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    /// Bits of the exponent one.
    const ONE: u64 = 1 << 52;
    /// Bits of about `sqrt(1/2)`.
    const LEAST: u64 = 0x3fe6_a09e_0000_0000;
    let c = closure!(|value: f64| x.constant(value));
    // k + 1023 as the last bits of 2^52.
    let k = x.map_bits(closure!(
        |bits: u64| (bits.wrapping_sub(LEAST).wrapping_add(1023 * ONE) >> 52) | (1075 * ONE)
    )) - (ONE as f64 + 1023.0);
    let f = x.map_bits(closure!(|bits: u64| bits.wrapping_sub(bits.wrapping_sub(LEAST) & !(ONE - 1)))) - 1.0;
    // ln(1 + f) = 2 atanh s, s = f / (2 + f).
    let s = f / (f + 2.0);
    let z = s * s;
    let w = z * z;
    let odd = w.mul_add(c(0.153_138_376_992_093_73), c(0.222_221_984_321_497_84));
    let odd = w * w.mul_add(odd, c(0.399_999_999_994_094_2));
    let even = w.mul_add(c(0.147_981_986_051_165_86), c(0.181_835_721_616_180_5));
    let even = w.mul_add(even, c(0.285_714_287_436_623_9));
    let r = z.mul_add(w.mul_add(even, c(0.666_666_666_666_673_5)), odd);
    let half = f * f * 0.5;
    let rest = s.mul_add(half + r, k * LN_2[1]);
    let result = k.mul_add(c(LN_2[0]), f - (half - rest));
    let result = x.where_greater(c(f64::MAX), x, result);
    c(f64::MIN_POSITIVE).where_greater(x, c(f64::NAN), x.where_greater(c(0.0), result, c(f64::NAN)))
}

#[cfg(test)]
mod tests {
    use super::super::on_every_machine;
    use super::*;

    /// Largest error of a function over many arguments, in units of the last place of the library's value.
    struct Compare {
        arguments: Vec<f64>,
        lanes: for<'a> fn(&'a f64) -> f64,
        is_exp: bool,
    }

    impl pulp::WithSimd for Compare {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for &x in &self.arguments {
                let lanes = Lanes::splat(simd, x);
                let value =
                    if self.is_exp { exp(lanes) } else { ln(lanes) }.as_slice()[Lanes::<S>::COUNT - 1];
                let exact = (self.lanes)(&x);
                let unit = f64::from_bits(exact.abs().to_bits() + 1) - exact.abs();
                assert!((value - exact).abs() <= 1.01 * unit, "{x:e}: {value:e}, not {exact:e}");
            }
        }
    }

    struct Extremes;

    impl pulp::WithSimd for Extremes {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let at = |f: fn(Lanes<S>) -> Lanes<S>, x: f64| f(Lanes::splat(simd, x)).as_slice()[0];
            for x in [710.0, 1e5, 1e300, f64::INFINITY] {
                assert_eq!(at(exp, x), f64::INFINITY);
            }
            for x in [-708.5, -1e5, -1e300, f64::NEG_INFINITY] {
                assert_eq!(at(exp, x), 0.0);
            }
            assert_eq!(at(exp, 0.0), 1.0);
            assert_eq!(at(ln, 1.0), 0.0);
            assert_eq!(at(ln, f64::INFINITY), f64::INFINITY);
            assert!(at(exp, f64::NAN).is_nan());
            for x in [f64::NAN, 0.0, -0.0, -1.0, f64::NEG_INFINITY, f64::MIN_POSITIVE / 2.0] {
                assert!(at(ln, x).is_nan(), "{x}");
            }
        }
    }

    #[test]
    fn exponentials_are_the_librarys() {
        let mut arguments: Vec<f64> = (-70_000..=70_000).map(|k| f64::from(k) * 1.013e-2).collect();
        arguments.retain(|x| (-707.0..709.0).contains(x));
        arguments.extend((0..300).flat_map(|k| [1.0, -1.0].map(|s| s * 0.9_f64.powi(k))));
        on_every_machine(&|| Compare { arguments: arguments.clone(), lanes: |x| x.exp(), is_exp: true });
    }

    #[test]
    fn logarithms_are_the_librarys() {
        let mut arguments: Vec<f64> = (-70_000..=70_000).map(|k| (f64::from(k) * 1.0e-2).exp()).collect();
        arguments.extend((1..60).flat_map(|k| [1.0, -1.0].map(|s| 1.0 + s * 0.5_f64.powi(k))));
        arguments.extend([f64::MIN_POSITIVE, f64::MAX, 0.5_f64.sqrt(), 2.0_f64.sqrt()]);
        on_every_machine(&|| Compare { arguments: arguments.clone(), lanes: |x| x.ln(), is_exp: false });
    }

    #[test]
    fn extreme_arguments_have_the_right_limits() {
        on_every_machine(&|| Extremes);
    }
}
