//! A biphasic disc between frictionless sealed plates (Armstrong, Lai and Mow 1984).

use super::roots;
use std::f64::consts::PI;

/// Bessel function of the first kind of an integer order: `1/pi int_0^pi cos(n s - x sin s) ds`.
fn bessel(order: u32, x: f64) -> f64 {
    let parts = 40 + 2 * x.abs() as usize;
    let at = |k: usize| PI * (k as f64 + 0.5) / parts as f64;
    (0..parts).map(|k| (f64::from(order) * at(k) - x * at(k).sin()).cos()).sum::<f64>() / parts as f64
}

/// Force after a step of the axial strain over `E eps A` at `tau = H_A k t / a^2`:
/// `1 + (1 - 2 nu) (1 - nu) / (1 + nu) sum exp(-x^2 tau) / ((1 - nu)^2 x^2 - (1 - 2 nu))`,
/// `J1(x) = (1 - nu) / (1 - 2 nu) x J0(x)`; the first root belongs to a growing mode where nu is below 0 only.
pub fn relaxation(nu: f64, tau: f64) -> f64 {
    let ratio = (1.0 - nu) / (1.0 - 2.0 * nu);
    let longest = (6.5 / tau.sqrt()).max(20.0);
    let term = |x: &f64| (-x * x * tau).exp() / ((1.0 - nu).powi(2) * x * x - (1.0 - 2.0 * nu));
    let sum: f64 =
        roots(|x| bessel(1, x) - ratio * x * bessel(0, x), 0.1, longest, 0.2).iter().map(term).sum();
    1.0 + (1.0 - 2.0 * nu) * (1.0 - nu) / (1.0 + nu) * sum
}
