//! Closed forms, each once, with its source and formula. `verification/closed_forms.rs` holds them against published values.
//!
//! SI units; small strain; nu is the drained skeleton's Poisson ratio, G its shear modulus.

pub mod consolidation;
pub mod half_space;
pub mod layer;
pub mod partial_slip;
pub mod sphere;
pub mod unconfined;

/// Where a rising `f` passes 0 between -1 and 1, by bisection to rounding.
pub fn rising_zero(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if f(middle) > 0.0 { high = middle } else { low = middle }
    }
    low
}

/// Where `f` changes its sign between `from` and `to`, by bisection in steps no longer than `step`.
fn roots(f: impl Fn(f64) -> f64, from: f64, to: f64, step: f64) -> Vec<f64> {
    let count = ((to - from) / step).ceil();
    let at = |k: f64| from + (to - from) * k / count;
    let mut found = Vec::new();
    for k in 0..count as usize {
        let (mut low, mut high) = (at(k as f64), at(k as f64 + 1.0));
        let sign = f(low);
        if sign * f(high) >= 0.0 {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if sign * f(middle) > 0.0 { low = middle } else { high = middle }
        }
        found.push(0.5 * (low + high));
    }
    found
}
