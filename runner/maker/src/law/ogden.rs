//! One Ogden term in principal logarithmic strains (Eqs. 8, 9).

use crate::specimen::Ogden;

/// Stress, stiffness and energy at principal logarithmic strains, of which only the deviator counts.
pub(super) struct Principal {
    /// Principal Kirchhoff stresses (Pa).
    pub stress: [f64; 3],
    /// `d stress_a / d strain_b` (Pa).
    pub stiffness: [[f64; 3]; 3],
    /// Stored energy (J/m^3).
    pub energy: f64,
}

/// `tau_a = mu (q_a - mean q)`, `q_a = exp(alpha dev(strain)_a)`.
pub(super) fn principal(law: &Ogden, strain: &[f64; 3]) -> Principal {
    let Ogden { mu, alpha } = *law;
    let mean = (strain[0] + strain[1] + strain[2]) / 3.0;
    let q = strain.map(|e| (alpha * (e - mean)).exp());
    let mean_q = (q[0] + q[1] + q[2]) / 3.0;
    let mut stiffness = [[0.0; 3]; 3];
    for a in 0..3 {
        for b in 0..3 {
            let same = if a == b { q[a] } else { 0.0 };
            stiffness[a][b] = mu * alpha * (same - (q[a] + q[b] - mean_q) / 3.0);
        }
    }
    Principal { stress: q.map(|q| mu * (q - mean_q)), stiffness, energy: 3.0 * mu / alpha * (mean_q - 1.0) }
}
