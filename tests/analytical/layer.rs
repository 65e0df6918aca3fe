//! A frictionless flat punch on a layer that is bonded to a rigid base (Hayes, Keer, Herrmann and Mockros 1972).

use std::f64::consts::PI;

/// `kappa = F (1 - nu) / (4 G a d)` at `a / h` for a layer of the height h: 1 for a half-space.
///
/// `phi(s) - int_0^1 K(s, t) phi(t) dt = 1`, `K = 2/pi (a/h) int_0^inf (1 - L(w)) cos(w s a/h) cos(w t a/h) dw`, kappa the mean of phi;
/// `L = (2 k sinh 2w - 4 w) / (2 k cosh 2w + 1 + k^2 + 4 w^2)`, `k = 3 - 4 nu`, is the layer's compliance over the half-space's.
pub fn kappa(nu: f64, radius_over_height: f64) -> f64 {
    /// Nodes of the midpoint rule on (0, 1), and of that on the wave numbers up to [`LONGEST`], where 1 - L is below 1e-14.
    const NODES: usize = 100;
    const WAVES: usize = 4000;
    const LONGEST: f64 = 20.0;
    let k = 3.0 - 4.0 * nu;
    let dw = LONGEST / WAVES as f64;
    let kernel: Vec<(f64, f64)> = (0..WAVES)
        .map(|i| {
            let w = (i as f64 + 0.5) * dw;
            let rest = 2.0 * k * (-2.0 * w).exp() + 1.0 + k * k + 4.0 * w * w + 4.0 * w;
            (w * radius_over_height, rest / (2.0 * k * (2.0 * w).cosh() + 1.0 + k * k + 4.0 * w * w))
        })
        .collect();
    // K depends on s + t and s - t alone, which are whole numbers of the nodes' distance.
    let h = 1.0 / NODES as f64;
    let wave = |x: f64| kernel.iter().map(|(w, value)| value * (w * x).cos()).sum::<f64>() * dw;
    let table: Vec<f64> = (0..2 * NODES).map(|n| wave(n as f64 * h) * radius_over_height / PI).collect();
    // The kernel's norm is below 1: iterate.
    let mut phi = vec![1.0; NODES];
    loop {
        let at = |s: usize| {
            let terms = (0..NODES).map(|t| (table[s + t + 1] + table[s.abs_diff(t)]) * phi[t]);
            1.0 + h * terms.sum::<f64>()
        };
        let next: Vec<f64> = (0..NODES).map(at).collect();
        let change = phi.iter().zip(&next).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        phi = next;
        if change < 1e-12 {
            return phi.iter().sum::<f64>() * h;
        }
    }
}
