//! Partial slip (Spence 1975): a rigid indenter on an elastic half-space sticks in a disc of the radius c and slides against Coulomb
//! friction f around it, up to the contact's edge at 1. Under a flat punch c stays while the load grows, and for every other
//! self-similar profile (sphere, cone) c over the contact's radius is the flat punch's.
//!
//! With the transforms `int phi(s) cos(k s) ds` of the pressure and `int psi(s) sin(k s) ds` of the shear, and Dundurs' constant
//! `beta = (1 - 2 nu) / (2 (1 - nu))` of a rigid indenter:
//! ```text
//! phi(x) = 1 + beta/pi int_0^1 2 s psi(s) / (s^2 - x^2) ds                                       depth
//! psi(x) = -beta/pi int_0^1 2 x phi(s) / (s^2 - x^2) ds                                 x < c    no slip
//! psi(x) = 2/pi f x ( phi(1) K'(x) - int_x^1 phi'(s) K'(x / s) / s ds )                 x > c    shear = f pressure
//! ```
//! and psi has no jump at c, where the shear would be infinite; `K'(k) = K(sqrt(1 - k^2))`, K the elliptic integral.

use super::roots;
use std::f64::consts::{FRAC_PI_2, PI};

/// Cells of the stick zone and of the slip zone's halves towards the edge and towards c: c to 5e-4, the force to 2e-4.
const CELLS: (usize, usize, usize) = (60, 60, 30);

/// Dundurs' constant of a half-space under a rigid indenter.
pub fn dundurs(nu: f64) -> f64 {
    (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu))
}

/// `K(sqrt(1 - k^2))` by the arithmetic-geometric mean.
fn complementary_elliptic(k: f64) -> f64 {
    let (mut a, mut g) = (1.0, k);
    while (a - g).abs() > 1e-15 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    FRAC_PI_2 / a
}

/// Stick radius where what the shear does to the pressure is neglected (phi = 1, Goodman's approximation):
/// `ln((1 + c) / (1 - c)) / (2 c) = f / beta K'(c)`.
pub fn uncoupled_stick_radius(nu: f64, friction: f64) -> f64 {
    let excess = |c: f64| {
        ((1.0 + c) / (1.0 - c)).ln() / (2.0 * c) - friction / dundurs(nu) * complementary_elliptic(c)
    };
    roots(excess, 1e-9, 1.0 - 1e-12, 1.0)[0]
}

/// Stick radius c, and the force over that of the frictionless flat punch at the same depth.
pub fn flat_punch(nu: f64, friction: f64) -> (f64, f64) {
    let c = roots(|c| solve(nu, friction, c).0, 1e-3, 1.0 - 1e-6, 1.0)[0];
    (c, solve(nu, friction, c).1)
}

/// Jump of psi at c, and the force, by functions constant in cells that crowd towards c and the edge. The coupling is a contraction
/// by beta at most: iterate.
fn solve(nu: f64, friction: f64, c: f64) -> (f64, f64) {
    let (stick, edge, inner) = CELLS;
    let graded = |k: usize, cells: usize, power: i32| (k as f64 / cells as f64).powi(power);
    let half = 0.5 * (1.0 - c);
    let to_c = (0..stick).map(|k| c - c * graded(stick - k, stick, 3));
    let from_c = (0..inner).map(|k| c + half * graded(k, inner, 3));
    let to_edge = (0..=edge).map(|k| 1.0 - half * graded(edge - k, edge, 6));
    let ends: Vec<f64> = to_c.chain(from_c).chain(to_edge).collect();
    let cells: Vec<[f64; 2]> = ends.windows(2).map(|s| [s[0], s[1]]).collect();
    let middles: Vec<f64> = cells.iter().map(|s| 0.5 * (s[0] + s[1])).collect();
    let coupling = dundurs(nu) / PI;
    // Integrals over a cell of 2 s / (s^2 - x^2) and 2 x / (s^2 - x^2).
    let over = |kernel: fn(f64, f64) -> f64| -> Vec<Vec<f64>> {
        let row = |x: &f64| cells.iter().map(|s| coupling * (kernel(s[1], *x) - kernel(s[0], *x))).collect();
        middles.iter().map(row).collect()
    };
    let depth = over(|s, x| ((s - x) * (s + x)).abs().ln());
    let no_slip = over(|s, x| ((s - x) / (s + x)).abs().ln());
    let share = 2.0 / PI * friction;
    let slip = |i: usize, phi: &[f64]| {
        let x = middles[i];
        let step = |j: usize| (phi[j] - phi[j - 1]) * complementary_elliptic(x / cells[j][0]) / cells[j][0];
        let at_edge = phi[phi.len() - 1] * complementary_elliptic(x);
        share * x * (at_edge - (i + 1..phi.len()).map(step).sum::<f64>())
    };
    let product = |row: &[f64], values: &[f64]| row.iter().zip(values).map(|(a, b)| a * b).sum::<f64>();
    let (mut phi, mut psi) = (vec![1.0; cells.len()], vec![0.0; cells.len()]);
    loop {
        let shear: Vec<f64> = (0..cells.len())
            .map(|i| if i < stick { -product(&no_slip[i], &phi) } else { slip(i, &phi) })
            .collect();
        let change = shear.iter().zip(&psi).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        psi = shear;
        phi = depth.iter().map(|row| 1.0 + product(row, &psi)).collect();
        if change < 1e-10 {
            let force = cells.iter().zip(&phi).map(|(s, phi)| (s[1] - s[0]) * phi).sum();
            return (psi[stick] - psi[stick - 1], force);
        }
    }
}
