//! What is known of an effect's magnitude before the measurement: a Cauchy distribution of its plausible scale. An unusual size is
//! unlikely, not impossible: ten scales cost `2 ln 101 = 9` of twice the log evidence, where a normal distribution would cost 100.

use super::linearised::normal_cdf;
use std::f64::consts::{FRAC_PI_2, PI};

/// Points of the quadrature, uniform in the angle whose tangent is the magnitude.
const ANGLES: usize = 20_000;
/// A magnitude is known well where its deviation is a smaller part of the scale on which the prior changes there.
const NARROW: f64 = 0.03;

/// Twice the log of `sqrt(2 pi) s E[N(m; m', s)]`, with `m'` as likely as the Cauchy distribution says, or the positive half of it, for a
/// magnitude that the data alone put at `m +- s` (plausible scales). With the fall of chi^2 to `m` it is twice the log evidence against
/// no effect, up to `-m^2 / s^2`, which that fall has.
pub fn prior_weight(magnitude: f64, deviation: f64, one_sided: bool) -> f64 {
    let (m, s) = (magnitude, deviation);
    let sides = if one_sided { 2.0 } else { 1.0 };
    if !(s > 0.0 && s.is_finite() && m.is_finite()) {
        return 0.0;
    }
    if s < NARROW * m.hypot(1.0) {
        let side = if one_sided { log_normal_cdf(m / s) } else { 0.0 };
        return 2.0 * ((2.0 * PI).sqrt() * s * sides / (PI * (1.0 + m * m))).ln() + 2.0 * side;
    }
    let first = if one_sided { 0.0 } else { -FRAC_PI_2 };
    let step = (FRAC_PI_2 - first) / ANGLES as f64;
    let density = |k: usize| (-0.5 * (((first + (k as f64 + 0.5) * step).tan() - m) / s).powi(2)).exp();
    let mean: f64 = (0..ANGLES).map(density).sum::<f64>() * step * sides / PI;
    2.0 * mean.max(f64::MIN_POSITIVE).ln()
}

/// Logarithm of the standard normal distribution, far out by its asymptote.
fn log_normal_cdf(z: f64) -> f64 {
    /// Beyond it the asymptote is within 1 %.
    const FAR: f64 = -12.0;
    if z < FAR { -0.5 * z * z - (-z * (2.0 * PI).sqrt()).ln() } else { normal_cdf(z).ln() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_that_tell_nothing_change_nothing() {
        assert!(prior_weight(0.0, 1e4, false).abs() < 1e-3);
        assert!(prior_weight(-0.3, 1e4, true).abs() < 1e-3);
    }

    #[test]
    fn both_ways_of_integrating_agree_where_they_meet() {
        for (m, one_sided) in [(0.0, false), (0.4, true), (3.0, false), (8.0, true)] {
            let at = |part: f64| prior_weight(m, part * NARROW * f64::hypot(m, 1.0), one_sided);
            let slope = 2.0 * (1.001_f64 / 0.999).ln();
            let (below, above) = (at(0.999), at(1.001));
            assert!((above - below - slope).abs() < 0.05, "{m}: {below} {above}");
        }
    }

    /// By hand: `m = 0`, `s` small: `sqrt(2 pi) s / pi`; ten scales cost `2 ln 101` more.
    #[test]
    fn an_unusual_size_is_unlikely_not_impossible() {
        let at = |m: f64| prior_weight(m, 1e-3, false);
        assert!((at(0.0) - 2.0 * ((2.0 * PI).sqrt() * 1e-3 / PI).ln()).abs() < 1e-9);
        assert!((at(0.0) - at(10.0) - 2.0 * 101f64.ln()).abs() < 1e-9);
        // All of what is known lies on one side: twice the density.
        assert!((prior_weight(1.0, 1e-3, true) - at(1.0) - 2.0 * 2f64.ln()).abs() < 1e-9);
        assert!(prior_weight(-1.0, 0.2, true) < prior_weight(1.0, 0.2, true) - 15.0);
        // What the data put far on the wrong side is worse than nothing, however far: the fall of chi^2 to it is 2500.
        assert!(prior_weight(-5.0, 0.1, true) < -2500.0);
    }
}
