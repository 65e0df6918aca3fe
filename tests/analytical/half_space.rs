//! An elastic half-space under an indenter, and its poroelastic relaxation; a the contact radius, d the depth (m).

use std::f64::consts::PI;

/// Frictionless flat punch (Sneddon 1965): `F = 4 G a d / (1 - nu)`, `8 G a d` undrained (N).
pub fn flat_punch(shear: f64, nu: f64, a: f64, d: f64) -> f64 {
    4.0 * shear * a * d / (1.0 - nu)
}

/// Bonded flat punch (Spence 1968): `F = 4 G a d ln(3 - 4 nu) / (1 - 2 nu)`, `8 G a d` undrained (N).
pub fn bonded_punch(shear: f64, nu: f64, a: f64, d: f64) -> f64 {
    4.0 * shear * a * d * (3.0 - 4.0 * nu).ln() / (1.0 - 2.0 * nu)
}

/// Frictionless sphere of the radius R (Hertz 1881): `F = 8 G / (3 (1 - nu)) sqrt(R) d^1.5` (N).
pub fn sphere(shear: f64, nu: f64, radius: f64, d: f64) -> f64 {
    8.0 / 3.0 * shear / (1.0 - nu) * radius.sqrt() * d.powf(1.5)
}

/// Frictionless cone (Sneddon 1965): `F = 4 G / (pi (1 - nu)) tan(half-angle) d^2` (N).
pub fn cone(shear: f64, nu: f64, half_angle: f64, d: f64) -> f64 {
    4.0 / PI * shear / (1.0 - nu) * half_angle.tan() * d * d
}

/// Depth (m) and force over `E* = 2 G / (1 - nu)` (m^2) of a flat punch with a rounded edge whose contact has the radius `a`:
/// Sneddon's integrals of the face's slope over `r = a sin(angle)` by the midpoint rule (Ciavarella 1999),
/// `d = a int f'(r) / sqrt(a^2 - r^2) dr`, `F = 2 E* int r^2 f'(r) / sqrt(a^2 - r^2) dr`.
pub fn rounded_punch(flat: f64, edge: f64, a: f64) -> (f64, f64) {
    const PARTS: usize = 20_000;
    let width = 0.5 * PI / PARTS as f64;
    let slope = |r: f64| if r > flat { (r - flat) / (edge * edge - (r - flat).powi(2)).sqrt() } else { 0.0 };
    let terms = (0..PARTS).map(|k| {
        let r = a * ((k as f64 + 0.5) * width).sin();
        (a * slope(r) * width, 2.0 * r * r * slope(r) * width)
    });
    terms.fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1))
}

/// Relaxing part of the force on a sealed flat punch at `x = D t / a^2`, a fit (Hu, Zhao, Vlassak and Suo 2010).
pub fn relaxation_fit(x: f64) -> f64 {
    1.304 * (-x.sqrt()).exp() - 0.304 * (-0.254 * x).exp()
}

/// Times `x = D t / a^2` of [`FLAT_RELAXATION`] and [`SPHERE_RELAXATION`].
pub const RELAXATION_TIMES: [f64; 5] = [0.03, 0.1, 0.3, 1.0, 3.0];
/// Relaxing part of the force on a sealed flat punch, the surface beside it drained, nu = 0.2 (`verification/half_space.py`).
pub const FLAT_RELAXATION: [f64; 5] = [0.8048, 0.6567, 0.4535, 0.2306, 0.1203];
/// The same on a sphere whose contact radius is fixed.
pub const SPHERE_RELAXATION: [f64; 5] = [0.8969, 0.7414, 0.4982, 0.2398, 0.1217];
