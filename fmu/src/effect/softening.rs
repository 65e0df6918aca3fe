//! Softening with past strain (Mullins): stresses of springs and dashpots times
//! `s = 1 - D (1 - exp(-e_max / e_0))`, e_max the largest equivalent strain `sqrt(2/3 e:e)` of the point so
//! far, e the deviator of the total logarithmic strain.
//!
//! Damage of the effective stress (Simo, 1987): the flow of the branches is that of the undamaged material, so
//! relaxation times stay. Volume and seepage are untouched. While a point is strained beyond its past, e_max
//! is that of the present iterate (implicit, with its tangent); between stages its maximum is taken at their
//! ends, an error of second order.

use super::descriptor::{Effect, Place, linear, one_sided, switch};
use crate::material::point::{DeformationGradient, Elasticity};
use crate::material::spectral::{Spectral, deviator};
use crate::material::{IDENTITY, Voigt};
use crate::variables::units::ONE;
use crate::variables::{Variable, field, real};
use serde::{Deserialize, Serialize};

/// Loss and the strain at which it happens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// D, the share that is lost at large strain [-].
    pub loss: f64,
    /// e_0 [-].
    pub strain: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { loss: 0.0, strain: 0.2 }
    }
}

impl Parameters {
    pub(crate) fn is_active(&self) -> bool {
        self.loss != 0.0
    }

    /// The law, where it acts.
    pub(crate) fn law(&self) -> Option<Softening> {
        self.is_active().then_some(Softening { loss: self.loss, strain: self.strain })
    }
}

/// The law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softening {
    loss: f64,
    strain: f64,
}

impl Softening {
    /// What is left of the stress after the strain `past`, and its slope by it.
    fn left(&self, past: f64) -> (f64, f64) {
        let decay = (-past / self.strain).exp();
        (1.0 - self.loss * (1.0 - decay), -self.loss / self.strain * decay)
    }

    /// Largest strain so far, the present one included.
    pub(crate) fn past_strain(f: &DeformationGradient, past: f64) -> Option<f64> {
        Some(past.max(strain(f)?.0))
    }

    /// Factor on stresses and energies for a largest strain so far.
    pub(crate) fn factor(&self, past: f64) -> f64 {
        self.left(past).0
    }

    /// Softens the undamaged stress and tangent; `past` is the largest strain before the step.
    pub(crate) fn apply(&self, f: &DeformationGradient, past: f64, e: &mut Elasticity) -> Option<()> {
        let (present, direction) = strain(f)?;
        let (left, slope) = self.left(past.max(present));
        e.tangent.iter_mut().flatten().for_each(|c| *c *= left);
        if present > past {
            for (row, tau) in e.tangent.iter_mut().zip(&e.kirchhoff_stress) {
                row.iter_mut().zip(&direction).for_each(|(c, d)| *c += slope * tau * d);
            }
        }
        e.kirchhoff_stress.iter_mut().for_each(|tau| *tau *= left);
        Some(())
    }
}

/// Equivalent strain and its derivative by the rate of deformation, a tensor.
fn strain(f: &DeformationGradient) -> Option<(f64, Voigt)> {
    let frame = Spectral::of(&f.push(&IDENTITY))?;
    let e = deviator(&frame.log_strains());
    let equivalent = (2.0 / 3.0 * (e[0] * e[0] + e[1] * e[1] + e[2] * e[2])).sqrt();
    // Undeformed, every direction is as good as any other and the stress is zero.
    let scale = if equivalent > 0.0 { 2.0 / (3.0 * equivalent) } else { 0.0 };
    Some((equivalent, frame.compose(&e.map(|x| scale * x))))
}

pub(super) const VARIABLES: &[Variable] = &[
    real(
        "effect.softening.loss",
        "Share D of all springs and dashpots that is lost at large past strain",
        &ONE,
        (0.0, 0.95),
        field!(Real, padded.effect.softening.loss),
    ),
    real(
        "effect.softening.strain",
        "Past equivalent logarithmic strain at which 63 % of the loss has happened",
        &ONE,
        (1e-3, 10.0),
        field!(Real, padded.effect.softening.strain),
    ),
];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "softening",
    title: "softening with past strain",
    place: Place::Specimen,
    variants: &[one_sided(
        "Mullins",
        &[linear("effect.softening.loss", 0.0, 0.3), switch("effect.softening.strain", 0.2, 0.2)],
    )
    .without_sensitivities()],
    physics: "Bonds that break on first loading do not heal: stresses fall with the largest strain a point has \
              seen. Unloading and later cycles to the same depth follow the softened response.",
    revealed_by: "A first cycle above the later ones, unloading below loading without any rate.",
    mimicked_by: "Within the first loading all moduli with smaller exponents; over cycles a branch that has not \
                  recovered, or swelling.",
    mimics: &["modulus_drift", "third_branch"],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::PointMaterial;
    use crate::parameters::MaterialParameters;

    /// Uniaxial log strain `e` at constant volume has the equivalent strain `e`; simple shear `g` tends to
    /// `g / sqrt 3`.
    #[test]
    fn equivalent_strain() {
        let e: f64 = 0.3;
        let lateral = (-0.5 * e).exp();
        let f = DeformationGradient { plane: [[lateral, 0.0], [0.0, e.exp()]], hoop: lateral };
        approx::assert_relative_eq!(strain(&f).unwrap().0, e, max_relative = 1e-12);
        let f = DeformationGradient { plane: [[1.0, 1e-4], [0.0, 1.0]], hoop: 1.0 };
        approx::assert_relative_eq!(strain(&f).unwrap().0, 1e-4 / 3.0_f64.sqrt(), max_relative = 1e-6);
    }

    /// Stress and tangent against central differences along a velocity gradient, both while strained beyond
    /// the past and below it: `d tau = C : d + l tau + tau l^T`.
    #[test]
    fn tangent_matches_finite_differences() {
        let material = PointMaterial::new(&MaterialParameters::default());
        let law = Parameters { loss: 0.4, strain: 0.1 }.law().unwrap();
        let f = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
        let l = [[0.3, -0.2], [0.5, 0.1]];
        let h = 1e-6;
        for past in [0.0, 0.5] {
            let at = |s: f64| {
                let mut g = f;
                for i in 0..2 {
                    for j in 0..2 {
                        g.plane[i][j] += s * (l[i][0] * f.plane[0][j] + l[i][1] * f.plane[1][j]);
                    }
                }
                g.hoop *= 1.0 - 0.4 * s;
                let mut e = material.elasticity(&g, &[IDENTITY; 2], 1e-3).unwrap();
                law.apply(&g, past, &mut e).unwrap();
                e
            };
            let (e, up, down) = (at(0.0), at(h).kirchhoff_stress, at(-h).kirchhoff_stress);
            let (tau, d) = (e.kirchhoff_stress, [l[0][0], l[1][1], -0.4, l[0][1] + l[1][0]]);
            let convected = [
                2.0 * (l[0][0] * tau[0] + l[0][1] * tau[3]),
                2.0 * (l[1][0] * tau[3] + l[1][1] * tau[1]),
                -0.8 * tau[2],
                l[0][0] * tau[3] + l[0][1] * tau[1] + l[1][0] * tau[0] + l[1][1] * tau[3],
            ];
            for i in 0..4 {
                let exact = convected[i] + (0..4).map(|j| e.tangent[i][j] * d[j]).sum::<f64>();
                let slope = (up[i] - down[i]) / (2.0 * h);
                approx::assert_relative_eq!(exact, slope, max_relative = 1e-6, epsilon = 1e-2);
            }
        }
    }
}
