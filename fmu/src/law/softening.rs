//! Softening with past strain (Mullins): stresses of springs and dashpots times
//! `s = 1 - D (1 - exp(-m / e_0))`, m the past strain of the point: the largest equivalent strain
//! `e = sqrt(2/3 e':e')` so far, e' the deviator of the total logarithmic strain.
//!
//! Bonds may take time to break: with a delay tau the past strain follows the present one by `m' = (e - m) / tau` while
//! that is larger, and never falls (viscous damage; Simo and Ju, 1987). Without delay m is the maximum of e.
//!
//! Damage of the effective stress (Simo, 1987): the flow of the branches is that of the undamaged material, so
//! relaxation times stay. Volume and seepage are untouched. While a point is strained beyond its past, m
//! follows the present iterate (implicit Euler, with its tangent); a maximum is taken at the ends of the stages, an
//! error of second order.

use super::Voigt;
use super::magnitude::Magnitude;
use super::point::{DeformationGradient, Elasticity};
use super::sensitivity::SpatialGradient;
use super::spectral::{Spectral, deviator};
use crate::number::{Real, closure, each};

/// The law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softening {
    /// D, the share that is lost at large strain [-].
    pub loss: f64,
    /// e_0 [-].
    pub strain: f64,
    /// tau (s); 0: at once.
    pub delay: f64,
}

/// PastStrain strain at the end of a stage.
pub(crate) struct PastStrain<T> {
    /// There.
    pub(crate) strain: T,
    /// Continued to where the next stage starts.
    pub(crate) continued: T,
}

impl Softening {
    /// What is left of the stress after the strain `past`, and its slope by it.
    #[inline(always)]
    fn left<T: Real>(&self, past: T) -> (T, T) {
        let decay = (past * (-1.0 / self.strain)).exp();
        (decay * self.loss + (1.0 - self.loss), decay * (-self.loss / self.strain))
    }

    /// Share of a larger present strain that the past strain takes up within a stage of `dt` (s).
    #[inline(always)]
    fn followed(&self, dt: f64) -> f64 {
        if self.delay > 0.0 { dt / (dt + self.delay) } else { 1.0 }
    }

    /// The same, continued through the stage; never beyond the present strain, since what is lost is lost.
    #[inline(always)]
    fn continued(&self, dt: f64, reach: f64) -> f64 {
        (self.followed(dt) * reach).min(1.0)
    }

    /// The past strain at the end of a stage of `dt` (s) that started with `past`.
    #[inline(always)]
    pub(crate) fn remember<T: Real>(
        &self,
        f: &DeformationGradient<T>,
        past: T,
        (dt, reach): (f64, f64),
    ) -> Option<PastStrain<T>> {
        let present = strain(f)?.0;
        Some(PastStrain {
            strain: moved(past, present, self.followed(dt)),
            continued: moved(past, present, self.continued(dt, reach)),
        })
    }

    /// Factor on stresses and energies for a past strain.
    #[inline(always)]
    pub(crate) fn factor<T: Real>(&self, past: T) -> T {
        self.left(past).0
    }

    /// Softens the undamaged stress and tangent; `past` is the past strain before the stage of `dt` (s).
    #[inline(always)]
    pub(crate) fn apply<T: Real>(
        &self,
        f: &DeformationGradient<T>,
        (past, dt): (T, f64),
        e: &mut Elasticity<T>,
    ) -> Option<()> {
        let (present, direction) = strain(f)?;
        let followed = self.followed(dt);
        let (left, slope) = self.left(moved(past, present, followed));
        // Below its past strain a point softens no further.
        let slope = present.where_greater(past, slope * followed, past.constant(0.0));
        for (row, tau) in e.tangent.iter_mut().zip(&mut e.kirchhoff_stress) {
            for (c, d) in row.iter_mut().zip(direction) {
                *c = *c * left + slope * *tau * d;
            }
            *tau = *tau * left;
        }
        Some(())
    }
}

impl Softening {
    /// Softens the changes of the undamaged stress with some parameters at fixed deformation, and adds those
    /// that come from the past strain before the stage of `dt` (s), `past` with its own changes by parameter.
    #[inline(always)]
    pub(crate) fn differentiate<T: Real>(
        &self,
        f: &DeformationGradient<T>,
        (past, changes, dt): (T, impl Fn(usize) -> T, f64),
        undamaged: &Voigt<T>,
        stress: &mut [Voigt<T>],
    ) -> Option<()> {
        let present = strain(f)?.0;
        let followed = self.followed(dt);
        let (left, slope) = self.left(moved(past, present, followed));
        // What is taken up of the present strain is fixed here.
        let slope = present.where_greater(past, slope * (1.0 - followed), slope);
        for (parameter, tau) in stress.iter_mut().enumerate() {
            let change = slope * changes(parameter);
            for (tau, undamaged) in tau.iter_mut().zip(undamaged) {
                *tau = *tau * left + change * *undamaged;
            }
        }
        Some(())
    }

    /// Derivatives of the factor on stresses at fixed past strain by D and e_0; `past` as in [`Self::apply`].
    #[inline(always)]
    pub(crate) fn by_magnitude<T: Real>(
        &self,
        f: &DeformationGradient<T>,
        (past, dt): (T, f64),
    ) -> Option<[(Magnitude, T); 2]> {
        let past = moved(past, strain(f)?.0, self.followed(dt));
        let decay = (past * (-1.0 / self.strain)).exp();
        let by_strain = past * decay * (self.loss / (self.strain * self.strain));
        Some([(Magnitude::Loss, decay - 1.0), (Magnitude::LossStrain, by_strain)])
    }

    /// Changes of the continued past strain over a converged stage from those before it and of the displacement, by
    /// parameter.
    #[inline(always)]
    pub(crate) fn past_sensitivity<T: Real>(
        &self,
        f: &DeformationGradient<T>,
        (past, changes): (T, impl Fn(usize) -> T),
        (dt, reach): (f64, f64),
        gradients: &[SpatialGradient<T>],
        mut new: impl FnMut(usize, T),
    ) -> Option<()> {
        let (present, direction) = strain(f)?;
        let share = self.continued(dt, reach);
        for (parameter, l) in gradients.iter().enumerate() {
            let before = changes(parameter);
            let after = before + (l.power(&direction) - before) * share;
            new(parameter, present.where_greater(past, after, before));
        }
        Some(())
    }
}

/// A past strain that has taken up a share of what a larger present one is beyond it.
#[inline(always)]
fn moved<T: Real>(past: T, present: T, share: f64) -> T {
    past + (present - past).max(past.constant(0.0)) * share
}

/// Equivalent strain and its derivative by the rate of deformation, a tensor.
#[inline(always)]
fn strain<T: Real>(f: &DeformationGradient<T>) -> Option<(T, Voigt<T>)> {
    let frame = Spectral::of(&f.left_cauchy_green())?;
    let e = deviator(&frame.log_strains());
    let equivalent = ((e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) * (2.0 / 3.0)).sqrt();
    // Undeformed, every direction is as good as any other and the stress is zero.
    let (zero, least) = (equivalent.constant(0.0), equivalent.constant(f64::MIN_POSITIVE));
    let scale = equivalent.where_greater(zero, equivalent.constant(2.0 / 3.0) / equivalent.max(least), zero);
    Some((equivalent, frame.compose(&each(&e, closure!(|x: T| scale * x)))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::parameters::MaterialParameters;
    use crate::law::{IDENTITY, PointMaterial};

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

    /// Derivatives of the factor by loss and strain against central differences, also where nothing is lost.
    #[test]
    fn the_factor_changes_with_loss_and_strain() {
        let f = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
        let (dt, h) = (1e-3, 1e-5);
        for (loss, past) in [(0.4, 0.0), (0.4, 0.5), (0.0, 0.0)] {
            let law = |loss, strain| Softening { loss, strain, delay: 2e-3 };
            let factor = |law: Softening| law.factor(law.remember(&f, past, (dt, 1.0)).unwrap().strain);
            let exact = law(loss, 0.1).by_magnitude(&f, (past, dt)).unwrap();
            let slopes = [
                (factor(law(loss + h, 0.1)) - factor(law(loss - h, 0.1))) / (2.0 * h),
                (factor(law(loss, 0.1 + h)) - factor(law(loss, 0.1 - h))) / (2.0 * h),
            ];
            for ((_, exact), slope) in exact.into_iter().zip(slopes) {
                approx::assert_relative_eq!(exact, slope, max_relative = 1e-7, epsilon = 1e-9);
            }
        }
    }

    /// Stress and tangent against central differences along a velocity gradient, both while strained beyond
    /// the past, at once and with delay, and below it: `d tau = C : d + l tau + tau l^T`.
    #[test]
    fn tangent_matches_finite_differences() {
        let material = PointMaterial::new(&MaterialParameters::default());
        let immediate = Softening { loss: 0.4, strain: 0.1, delay: 0.0 };
        let delayed = Softening { delay: 2e-3, ..immediate };
        let f = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
        let l = [[0.3, -0.2], [0.5, 0.1]];
        let h = 1e-6;
        for (law, past) in [(immediate, 0.0), (immediate, 0.5), (delayed, 0.0)] {
            let at = |s: f64| {
                let mut g = f;
                for i in 0..2 {
                    for j in 0..2 {
                        g.plane[i][j] += s * (l[i][0] * f.plane[0][j] + l[i][1] * f.plane[1][j]);
                    }
                }
                g.hoop *= 1.0 - 0.4 * s;
                let mut e = material.elasticity(&g, &[IDENTITY; 2], 1e-3).unwrap();
                law.apply(&g, (past, 1e-3), &mut e).unwrap();
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
