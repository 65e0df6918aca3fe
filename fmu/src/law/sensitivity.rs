//! How stress and history at a point change with the material's parameters.
//!
//! Direct differentiation of [`PointMaterial::elasticity`] and [`PointMaterial::update`]: both are isotropic
//! functions of the trial tensors `b = F Cv^-1 F^T`, which change with the deformation and with the
//! history's own change.

use super::Voigt;
use super::branch::{Branch, BranchSensitivity, Relaxed};
use super::ogden::Ogden;
use super::parameter::{MaterialParameter, Spring};
use super::point::{DeformationGradient, PointMaterial, add};
use super::spectral::{Spectral, deviator};
use crate::number::{Real, closure};

/// Spatial gradient of a change of the displacement, `l = d(du)/dx`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpatialGradient<T = f64> {
    /// In-plane part.
    pub plane: [[T; 2]; 2],
    /// Hoop part.
    pub hoop: T,
}

impl<T: Real> SpatialGradient<T> {
    /// Relative change of the volume.
    #[inline(always)]
    pub fn trace(&self) -> T {
        self.plane[0][0] + self.plane[1][1] + self.hoop
    }

    /// `a : l` for symmetric `a`.
    #[inline(always)]
    pub fn power(&self, a: &Voigt<T>) -> T {
        let l = &self.plane;
        a[0] * l[0][0] + a[1] * l[1][1] + a[2] * self.hoop + a[3] * (l[0][1] + l[1][0])
    }

    /// `l a + a l^T` for symmetric `a`.
    #[inline(always)]
    fn convect(&self, a: &Voigt<T>) -> Voigt<T> {
        let l = &self.plane;
        [
            (l[0][0] * a[0] + l[0][1] * a[3]) * 2.0,
            (l[1][0] * a[3] + l[1][1] * a[1]) * 2.0,
            self.hoop * a[2] * 2.0,
            l[0][0] * a[3] + l[0][1] * a[1] + l[1][0] * a[0] + l[1][1] * a[3],
        ]
    }

    /// Components rr, rz, zr, zz, tt.
    #[inline(always)]
    fn components(&self) -> [T; 5] {
        let [[rr, rz], [zr, zz]] = self.plane;
        [rr, rz, zr, zz, self.hoop]
    }

    /// The gradient with such components.
    #[inline(always)]
    fn of([rr, rz, zr, zz, tt]: [T; 5]) -> Self {
        Self { plane: [[rr, rz], [zr, zz]], hoop: tt }
    }
}

/// One branch at a converged point: what both derivatives need of its update.
struct ConvergedBranch<T> {
    frame: Spectral<T>,
    /// Deviatoric logarithmic trial strains.
    trial: [T; 3],
    relaxed: Relaxed<T>,
    sensitivity: BranchSensitivity<T>,
}

impl<T: Real> ConvergedBranch<T> {
    #[inline(always)]
    fn of(branch: &Branch, f: &DeformationGradient<T>, cv_inverse: &Voigt<T>, dt: f64) -> Option<Self> {
        let frame = Spectral::of(&f.push(cv_inverse))?;
        let trial = deviator(&frame.log_strains());
        let relaxed = branch.relax(&trial, dt)?;
        let sensitivity = branch.sensitivity(&relaxed, dt);
        Some(Self { frame, trial, relaxed, sensitivity })
    }
}

/// A linear map to tensors, column by column: there are more parameters than columns.
struct Linear<T, const N: usize>([Voigt<T>; N]);

impl<T: Real, const N: usize> Linear<T, N> {
    /// The map that takes the unit vectors to `column`.
    #[inline(always)]
    fn new(one: T, column: impl Fn([T; N]) -> Voigt<T>) -> Self {
        let zero = [one.constant(0.0); N];
        let mut columns = [[zero[0]; 4]; N];
        for (k, to) in columns.iter_mut().enumerate() {
            let mut unit = zero;
            unit[k] = one;
            *to = column(unit);
        }
        Self(columns)
    }

    /// Adds the image of `v`.
    #[inline(always)]
    fn add(&self, v: &[T; N], sum: &mut Voigt<T>) {
        for (column, v) in self.0.iter().zip(v) {
            for (sum, entry) in sum.iter_mut().zip(column) {
                *sum = entry.mul_add(*v, *sum);
            }
        }
    }
}

/// First of a branch's parameters; alpha and eta follow.
#[inline(always)]
const fn first_of(branch: usize) -> usize {
    MaterialParameter::Mu(Spring::Branch(branch)).index()
}

/// A converged step at one point.
#[derive(Clone, Copy)]
pub struct ConvergedStep<'a, T = f64> {
    /// Deformation at its end.
    pub f: &'a DeformationGradient<T>,
    /// `Cv^-1` of every branch at its start.
    pub history: &'a [Voigt<T>],
    /// Its length (s).
    pub dt: f64,
}

impl PointMaterial {
    /// Change of the isochoric Kirchhoff stress at fixed deformation, by every parameter.
    ///
    /// `changes` gives those of the history at the step's start, by parameter and branch; `stress` takes one
    /// tensor per parameter (Pa per unit of the parameter). `None` as in `elasticity`.
    #[inline(always)]
    pub fn stress_sensitivity<T: Real>(
        &self,
        ConvergedStep { f, history, dt }: ConvergedStep<'_, T>,
        changes: impl Fn(usize, usize) -> Voigt<T>,
        stress: &mut [Voigt<T>],
    ) -> Option<()> {
        let (zero, one) = (f.hoop.constant(0.0), f.hoop.constant(1.0));
        stress.fill([zero; 4]);
        let frame = Spectral::of(&f.left_cauchy_green())?;
        let e = deviator(&frame.log_strains());
        let equilibrium: &Ogden = self.equilibrium_law();
        let first = MaterialParameter::Mu(Spring::Equilibrium).index();
        for (k, explicit) in equilibrium.sensitivity(&e, &equilibrium.powers(&e)).iter().enumerate() {
            stress[first + k] = frame.compose(explicit);
        }
        for (index, (branch, cv_inverse)) in self.branch_laws().iter().zip(history).enumerate() {
            let ConvergedBranch { frame, relaxed, sensitivity, .. } =
                ConvergedBranch::of(branch, f, cv_inverse, dt)?;
            let powers = &relaxed.powers;
            let (beta, tangent) = (branch.spring.stress(powers), branch.tangent(powers, dt));
            let by_history = Linear::new(
                one,
                closure!(|change: Voigt<T>| frame.differentiate(&beta, &tangent, &f.push(&change))),
            );
            for (parameter, tau) in stress.iter_mut().enumerate() {
                by_history.add(&changes(parameter, index), tau);
            }
            for (tau, explicit) in stress[first_of(index)..].iter_mut().zip(&sensitivity.stress) {
                add(tau, &frame.compose(explicit));
            }
        }
        Some(())
    }

    /// Change of the history over a converged step, by every parameter; the companion of `update`.
    ///
    /// `gradients` are those of the displacement's changes, one per parameter; `changes` gives the history's at
    /// the step's start and `updated` takes those at its end, by parameter and branch. `None` as in `update`.
    #[inline(always)]
    pub fn history_sensitivity<T: Real>(
        &self,
        ConvergedStep { f, history, dt }: ConvergedStep<'_, T>,
        reach: f64,
        gradients: &[SpatialGradient<T>],
        changes: impl Fn(usize, usize) -> Voigt<T>,
        mut updated: impl FnMut(usize, usize, Voigt<T>),
    ) -> Option<()> {
        let (zero, one) = (f.hoop.constant(0.0), f.hoop.constant(1.0));
        let f_inverse = f.inverse();
        for (index, (branch, cv_inverse)) in self.branch_laws().iter().zip(history).enumerate() {
            let ConvergedBranch { frame, trial, relaxed, sensitivity } =
                ConvergedBranch::of(branch, f, cv_inverse, dt)?;
            // v_a = b_a exp(2 reach (eps_a - eps_trial_a)).
            let mut squares = frame.squares;
            let (mut slope, mut explicit) = ([[zero; 3]; 3], [[zero; 3]; 3]);
            for a in 0..3 {
                squares[a] = squares[a] * ((relaxed.strain[a] - trial[a]) * (2.0 * reach)).exp();
                let double = squares[a] * 2.0;
                let mut flow = sensitivity.strain_slope[a];
                flow[a] -= one;
                let flow = deviator(&flow);
                for b in 0..3 {
                    slope[a][b] = double * flow[b] * reach;
                    explicit[b][a] = double * sensitivity.strain[b][a] * reach;
                }
                slope[a][a] += double;
            }
            let by_tensor = closure!(|change: Voigt<T>| frame.differentiate(&squares, &slope, &change));
            let by_history =
                Linear::new(one, closure!(|change: Voigt<T>| f_inverse.push(&by_tensor(f.push(&change)))));
            let (b_trial, b_relaxed) = (frame.compose(&frame.squares), frame.compose(&squares));
            let by_gradient = Linear::new(
                one,
                closure!(|components: [T; 5]| {
                    let l = SpatialGradient::of(components);
                    let mut tensor = by_tensor(l.convect(&b_trial));
                    for (tensor, convected) in tensor.iter_mut().zip(l.convect(&b_relaxed)) {
                        *tensor -= convected;
                    }
                    f_inverse.push(&tensor)
                }),
            );
            for (parameter, l) in gradients.iter().enumerate() {
                let mut new = [zero; 4];
                by_history.add(&changes(parameter, index), &mut new);
                by_gradient.add(&l.components(), &mut new);
                if let Some(explicit) = explicit.get(parameter.wrapping_sub(first_of(index))) {
                    add(&mut new, &f_inverse.push(&frame.compose(explicit)));
                }
                updated(parameter, index, new);
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::extensions::Extensions;
    use crate::law::parameters::MaterialParameters;

    const DT: f64 = 3e-3;
    const REACH: f64 = 2.414;
    const F: DeformationGradient = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
    const HISTORY: [Voigt; 2] = [[1.1, 0.93, 1.0 / (1.1 * 0.93 - 0.0025), 0.05], [0.9, 1.05, 1.06, -0.02]];

    /// The plain material, and one with every extension that acts on a stage.
    fn extensions() -> [Extensions; 2] {
        let all = Extensions {
            inverse_stress: 5e-3,
            permeability_exponent: 4.0,
            amplitude: 1.5,
            growth_rate: 1e-2,
            softening: None,
        };
        [Extensions::default(), all]
    }

    fn made(m: &MaterialParameters, extensions: &Extensions) -> PointMaterial {
        PointMaterial::extended(m, extensions, 20.0)
    }

    fn with(parameter: MaterialParameter, relative: f64, extensions: &Extensions) -> (PointMaterial, f64) {
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
        (made(&m, extensions), value)
    }

    /// Moves parameter, deformation and history together, by `s` along the given changes.
    fn moved(
        parameter: MaterialParameter,
        extensions: &Extensions,
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
        let (_, value) = with(parameter, 0.0, extensions);
        let history = std::array::from_fn(|b| std::array::from_fn(|i| HISTORY[b][i] + s * changes[b][i]));
        (with(parameter, s / value, extensions).0, f, history)
    }

    /// Stress at fixed deformation and updated history against central differences, 1e-6.
    #[test]
    fn sensitivities_match_finite_differences() {
        extensions().iter().for_each(matches_finite_differences);
    }

    fn matches_finite_differences(extensions: &Extensions) {
        let material = made(&MaterialParameters::default(), extensions);
        let count = MaterialParameter::count(2);
        let still = SpatialGradient::default();
        let l = SpatialGradient { plane: [[0.3, -0.2], [0.5, 0.1]], hoop: -0.4 };
        for parameter in MaterialParameter::all(2) {
            let (_, value) = with(parameter, 0.0, extensions);
            let h = 1e-5 * value.abs();
            // Changes as large as one per value of the parameter.
            let l = SpatialGradient { plane: l.plane.map(|r| r.map(|x| x / value)), hoop: l.hoop / value };
            let own = [[0.2, -0.1, 0.3, 0.15], [-0.3, 0.1, 0.2, 0.05]].map(|c: Voigt| c.map(|x| x / value));
            let mut changes = vec![[0.0; 4]; 2 * count];
            changes[2 * parameter.index()..][..2].copy_from_slice(&own);
            let mut gradients = vec![still; count];
            gradients[parameter.index()] = l;

            let mut stress = vec![[0.0; 4]; count];
            let step = ConvergedStep { f: &F, history: &HISTORY, dt: DT };
            let change = |parameter: usize, branch: usize| changes[2 * parameter + branch];
            material.stress_sensitivity(step, change, &mut stress).unwrap();
            let at = |s: f64| {
                let (material, f, history) = moved(parameter, extensions, s, &still, &own);
                material.elasticity(&f, &history, DT).unwrap().kirchhoff_stress
            };
            compare(&stress[parameter.index()], &at(h), &at(-h), h);

            let mut updated = vec![[0.0; 4]; 2 * count];
            let update = |parameter: usize, branch: usize, new| updated[2 * parameter + branch] = new;
            material.history_sensitivity(step, REACH, &gradients, change, update).unwrap();
            let at = |s: f64| {
                let (material, f, history) = moved(parameter, extensions, s, &l, &own);
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
