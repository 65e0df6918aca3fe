//! A sphere in a fluid whose pressure is raised (Cryer 1963).

use super::roots;

/// Pore pressure at the centre over the pressure on the drained surface at `T = c t / R^2`, incompressible grains and fluid (Verruijt):
/// `sum m (sin x - x) / ((m - 1) sin x + m x cos x / 2) exp(-x^2 T)`, `(1 - m x^2 / 2) tan x = x`, `m = (1 - nu) / (1 - 2 nu)`.
pub fn centre_pressure(nu: f64, time_factor: f64) -> f64 {
    let m = (1.0 - nu) / (1.0 - 2.0 * nu);
    let characteristic = |x: f64| (1.0 - 0.5 * m * x * x) * x.sin() - x * x.cos();
    let longest = 6.5 / time_factor.sqrt();
    let term = |x: &f64| {
        let x = *x;
        m * (x.sin() - x) / ((m - 1.0) * x.sin() + 0.5 * m * x * x.cos()) * (-x * x * time_factor).exp()
    };
    roots(characteristic, 0.1, longest.max(10.0), 0.01).iter().map(term).sum()
}
