//! One-dimensional consolidation (Terzaghi 1923): a confined column that drains at one end, `c = k M`, `M = K + 4 G / 3`.

use std::f64::consts::PI;

/// Degree of consolidation under a constant load at `T = c t / H^2`:
/// `U = 1 - sum 8 / ((2 n + 1) pi)^2 exp(-((2 n + 1) pi / 2)^2 T)`.
pub fn degree(time_factor: f64) -> f64 {
    let term = |n: u32| {
        let odd = f64::from(2 * n + 1) * PI;
        8.0 / (odd * odd) * (-0.25 * odd * odd * time_factor).exp()
    };
    1.0 - (0..2000).map(term).sum::<f64>()
}

/// A column whose other end is sealed and moves inwards at a constant velocity.
#[derive(Debug, Clone, Copy)]
pub struct Ramp {
    /// Confined modulus M (Pa).
    pub modulus: f64,
    /// Coefficient of consolidation c (m^2/s).
    pub consolidation: f64,
    /// Height H (m).
    pub height: f64,
    /// Velocity v (m/s).
    pub velocity: f64,
}

impl Ramp {
    /// `M v / H (t + 2 sum s^n tau_n (1 - exp(-t / tau_n)))`, `tau_n = H^2 / (n^2 pi^2 c)`, from `c u_zz = u_t + v` with
    /// `u(0) = 0`, `u(H) = -v t`.
    fn series(&self, time: f64, sign: f64) -> f64 {
        let term = |n: i32| {
            let tau = self.height * self.height / (f64::from(n * n) * PI * PI * self.consolidation);
            2.0 * sign.powi(n) * tau * (1.0 - (-time / tau).exp())
        };
        self.modulus * self.velocity / self.height * (time + (1..2000).map(term).sum::<f64>())
    }

    /// Total stress, which is the effective one at the drained end (Pa), s = 1.
    pub fn stress(&self, time: f64) -> f64 {
        self.series(time, 1.0)
    }

    /// Effective stress at the sealed end (Pa), s = -1; the rest of the total is pore pressure.
    pub fn effective_stress(&self, time: f64) -> f64 {
        self.series(time, -1.0)
    }
}

/// Shortest time step (s) that an element of the height `h` (m) at a drained end resolves: `h^2 / (6 c)` (Vermeer and Verruijt 1981).
pub fn shortest_step(h: f64, consolidation: f64) -> f64 {
    h * h / (6.0 * consolidation)
}
