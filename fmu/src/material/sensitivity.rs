//! How stress and history at a point change with the material's parameters.
//!
//! Direct differentiation of [`PointMaterial::elasticity`] and [`PointMaterial::update`]: both are isotropic
//! functions of the trial tensors `b = F Cv^-1 F^T`, which change with the deformation and with the
//! history's own change.

use super::branch::{Branch, BranchSensitivity, Relaxed};
use super::ogden::Ogden;
use super::parameter::{MaterialParameter, Spring};
use super::point::{DeformationGradient, PointMaterial};
use super::spectral::{Spectral, deviator};
use super::{IDENTITY, Voigt};

/// Spatial gradient of a change of the displacement, `l = d(du)/dx`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpatialGradient {
    /// In-plane part.
    pub plane: [[f64; 2]; 2],
    /// Hoop part.
    pub hoop: f64,
}

impl SpatialGradient {
    /// Relative change of the volume.
    #[inline(always)]
    pub fn trace(&self) -> f64 {
        self.plane[0][0] + self.plane[1][1] + self.hoop
    }

    /// `l a + a l^T` for symmetric `a`.
    #[inline(always)]
    fn convect(&self, a: &Voigt) -> Voigt {
        let l = &self.plane;
        [
            2.0 * (l[0][0] * a[0] + l[0][1] * a[3]),
            2.0 * (l[1][0] * a[3] + l[1][1] * a[1]),
            2.0 * self.hoop * a[2],
            l[0][0] * a[3] + l[0][1] * a[1] + l[1][0] * a[0] + l[1][1] * a[3],
        ]
    }
}

/// One branch at a converged point: what both derivatives need of its update.
#[derive(Debug, Clone, Copy, Default)]
pub struct Flow {
    frame: Spectral,
    /// Deviatoric logarithmic trial strains.
    trial: [f64; 3],
    relaxed: Relaxed,
    sensitivity: BranchSensitivity,
}

impl Flow {
    #[inline(always)]
    fn of(branch: &Branch, f: &DeformationGradient, cv_inverse: &Voigt, dt: f64) -> Option<Self> {
        let frame = Spectral::of(&f.push(cv_inverse))?;
        let trial = deviator(&frame.log_strains());
        let relaxed = branch.relax(&trial, dt)?;
        Some(Self { frame, trial, relaxed, sensitivity: branch.sensitivity(&relaxed, dt) })
    }
}

/// First of a branch's parameters; alpha and eta follow.
#[inline(always)]
const fn first_of(branch: usize) -> usize {
    MaterialParameter::Mu(Spring::Branch(branch)).index()
}

impl PointMaterial {
    /// Change of the isochoric Kirchhoff stress at fixed deformation, by every parameter.
    ///
    /// `changes` are those of the history at the step's start, parameter by parameter and branch by branch;
    /// `stress` takes one tensor per parameter (Pa per unit of the parameter) and `flows` what
    /// [`Self::history_sensitivity`] needs of each branch. `None` as in `elasticity`.
    #[inline(always)]
    pub fn stress_sensitivity(
        &self,
        f: &DeformationGradient,
        history: &[Voigt],
        changes: &[Voigt],
        dt: f64,
        flows: &mut [Flow],
        stress: &mut [Voigt],
    ) -> Option<()> {
        stress.fill([0.0; 4]);
        let frame = Spectral::of(&f.push(&IDENTITY))?;
        let e = deviator(&frame.log_strains());
        let equilibrium: &Ogden = self.equilibrium_law();
        let first = MaterialParameter::Mu(Spring::Equilibrium).index();
        for (k, explicit) in equilibrium.sensitivity(&e, &equilibrium.powers(&e)).iter().enumerate() {
            stress[first + k] = frame.compose(explicit);
        }
        let branches = history.len();
        for (index, (cv_inverse, flow)) in history.iter().zip(flows).enumerate() {
            let branch = &self.branch_laws()[index];
            *flow = Flow::of(branch, f, cv_inverse, dt)?;
            let powers = &flow.relaxed.powers;
            let (beta, tangent) = (branch.spring.stress(powers), branch.tangent(powers, dt));
            for (parameter, tau) in stress.iter_mut().enumerate() {
                let own = parameter.wrapping_sub(first_of(index));
                let explicit = flow.sensitivity.stress.get(own).unwrap_or(&[0.0; 3]);
                let change = f.push(&changes[parameter * branches + index]);
                let branch_stress = flow.frame.differentiate(&beta, &tangent, explicit, &change);
                (0..4).for_each(|i| tau[i] += branch_stress[i]);
            }
        }
        Some(())
    }

    /// Change of the history over a converged step, by every parameter; the companion of `update`.
    ///
    /// `gradients` are those of the displacement's changes, one per parameter; `changes` and `updated` are
    /// the history's, and `flows` the branches, as in [`Self::stress_sensitivity`].
    #[inline(always)]
    pub fn history_sensitivity(
        &self,
        f: &DeformationGradient,
        flows: &[Flow],
        changes: &[Voigt],
        gradients: &[SpatialGradient],
        reach: f64,
        updated: &mut [Voigt],
    ) {
        let branches = flows.len();
        let f_inverse = f.inverse();
        for (index, Flow { frame, trial, relaxed, sensitivity }) in flows.iter().enumerate() {
            // v_a = b_a exp(2 reach (eps_a - eps_trial_a)).
            let squares: [f64; 3] = std::array::from_fn(|a| {
                frame.squares[a] * (2.0 * reach * (relaxed.strain[a] - trial[a])).exp()
            });
            let mut slope = [[0.0; 3]; 3];
            for (a, row) in slope.iter_mut().enumerate() {
                let flow = deviator(&std::array::from_fn(|b| {
                    sensitivity.strain_slope[a][b] - f64::from(u8::from(a == b))
                }));
                for (b, entry) in row.iter_mut().enumerate() {
                    *entry = 2.0 * squares[a] * (f64::from(u8::from(a == b)) + reach * flow[b]);
                }
            }
            let explicit = sensitivity
                .strain
                .map(|strain| std::array::from_fn(|a| 2.0 * reach * squares[a] * strain[a]));
            let b_trial = frame.compose(&frame.squares);
            let relaxed_tensor = frame.compose(&squares);
            for (parameter, l) in gradients.iter().enumerate() {
                let own = explicit.get(parameter.wrapping_sub(first_of(index))).unwrap_or(&[0.0; 3]);
                let mut change = f.push(&changes[parameter * branches + index]);
                let convected = l.convect(&b_trial);
                (0..4).for_each(|i| change[i] += convected[i]);
                let mut tensor = frame.differentiate(&squares, &slope, own, &change);
                let convected = l.convect(&relaxed_tensor);
                (0..4).for_each(|i| tensor[i] -= convected[i]);
                updated[parameter * branches + index] = f_inverse.push(&tensor);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::EffectParameters;
    use crate::parameters::MaterialParameters;

    const DT: f64 = 3e-3;
    const REACH: f64 = 2.414;
    const F: DeformationGradient = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
    const HISTORY: [Voigt; 2] = [[1.1, 0.93, 1.0 / (1.1 * 0.93 - 0.0025), 0.05], [0.9, 1.05, 1.06, -0.02]];

    /// The plain material, and one with every effect that the derivatives know.
    fn effects() -> [EffectParameters; 2] {
        let mut all = EffectParameters::default();
        all.eyring.inverse_stress = 5e-3;
        all.permeability.exponent = 4.0;
        all.amplitude.log_factor = 0.4;
        all.modulus_drift.rate = 1e-2;
        [EffectParameters::default(), all]
    }

    fn made(m: &MaterialParameters, effect: &EffectParameters) -> PointMaterial {
        PointMaterial::with_effects(m, effect, 20.0)
    }

    fn with(parameter: MaterialParameter, relative: f64, effect: &EffectParameters) -> (PointMaterial, f64) {
        let mut m = MaterialParameters::default();
        let value = match parameter {
            MaterialParameter::Mu(Spring::Equilibrium) => &mut m.equilibrium.mu,
            MaterialParameter::Alpha(Spring::Equilibrium) => &mut m.equilibrium.alpha,
            MaterialParameter::Mu(Spring::Branch(b)) => &mut m.branches[b].ogden.mu,
            MaterialParameter::Alpha(Spring::Branch(b)) => &mut m.branches[b].ogden.alpha,
            MaterialParameter::Eta(b) => &mut m.branches[b].eta,
            MaterialParameter::SolidFraction => &mut m.n0s,
            MaterialParameter::LambdaStar => &mut m.lambda_star,
            MaterialParameter::FluidViscosity => &mut m.fluid_viscosity,
            MaterialParameter::Permeability => &mut m.permeability,
        };
        *value *= 1.0 + relative;
        let value = *value;
        (made(&m, effect), value)
    }

    /// Moves parameter, deformation and history together, by `s` along the given changes.
    fn moved(
        parameter: MaterialParameter,
        effect: &EffectParameters,
        s: f64,
        l: &SpatialGradient,
        changes: &[Voigt],
    ) -> (PointMaterial, DeformationGradient, [Voigt; 2]) {
        let mut f = F;
        for i in 0..2 {
            for j in 0..2 {
                f.plane[i][j] += s * (l.plane[i][0] * F.plane[0][j] + l.plane[i][1] * F.plane[1][j]);
            }
        }
        f.hoop += s * l.hoop * F.hoop;
        let (_, value) = with(parameter, 0.0, effect);
        let history = std::array::from_fn(|b| std::array::from_fn(|i| HISTORY[b][i] + s * changes[b][i]));
        (with(parameter, s / value, effect).0, f, history)
    }

    /// Stress at fixed deformation and updated history against central differences, 1e-6.
    #[test]
    fn sensitivities_match_finite_differences() {
        effects().iter().for_each(matches_finite_differences);
    }

    fn matches_finite_differences(effect: &EffectParameters) {
        let material = made(&MaterialParameters::default(), effect);
        let count = MaterialParameter::count(2);
        let still = SpatialGradient::default();
        let l = SpatialGradient { plane: [[0.3, -0.2], [0.5, 0.1]], hoop: -0.4 };
        for parameter in MaterialParameter::all(2) {
            let (_, value) = with(parameter, 0.0, effect);
            let h = 1e-5 * value.abs();
            // Changes as large as one per value of the parameter.
            let l = SpatialGradient { plane: l.plane.map(|r| r.map(|x| x / value)), hoop: l.hoop / value };
            let own = [[0.2, -0.1, 0.3, 0.15], [-0.3, 0.1, 0.2, 0.05]].map(|c: Voigt| c.map(|x| x / value));
            let mut changes = vec![[0.0; 4]; 2 * count];
            changes[2 * parameter.index()..][..2].copy_from_slice(&own);
            let mut gradients = vec![still; count];
            gradients[parameter.index()] = l;

            let mut stress = vec![[0.0; 4]; count];
            let mut flows = [Flow::default(); 2];
            material.stress_sensitivity(&F, &HISTORY, &changes, DT, &mut flows, &mut stress).unwrap();
            let at = |s: f64| {
                let (material, f, history) = moved(parameter, effect, s, &still, &own);
                material.elasticity(&f, &history, DT).unwrap().kirchhoff_stress
            };
            compare(&stress[parameter.index()], &at(h), &at(-h), h);

            let mut updated = vec![[0.0; 4]; 2 * count];
            material.history_sensitivity(&F, &flows, &changes, &gradients, REACH, &mut updated);
            let at = |s: f64| {
                let (material, f, history) = moved(parameter, effect, s, &l, &own);
                let mut updated = [[0.0; 4]; 2];
                material.update(&f, &history, DT, REACH, &mut updated).unwrap();
                updated
            };
            let (up, down) = (at(h), at(-h));
            for b in 0..2 {
                compare(&updated[2 * parameter.index() + b], &up[b], &down[b], h);
            }
        }
    }

    fn compare(exact: &Voigt, up: &Voigt, down: &Voigt, h: f64) {
        let slope: Voigt = std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * h));
        let size = slope.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for i in 0..4 {
            assert!((exact[i] - slope[i]).abs() <= 1e-6 * size, "{exact:?} {slope:?}");
        }
    }
}
