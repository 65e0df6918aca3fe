//! The whole solid skeleton at one integration point: all of the stress (Eq. 7) but the pore pressure.

use super::branch::Branch;
use super::darcy::Darcy;
use super::extensions::Extensions;
use super::ogden::Ogden;
use super::softening::Softening;
use super::spectral::{Spectral, deviator};
use super::volumetric::Volumetric;
use super::{Voigt, Voigt2};
use crate::law::parameters::MaterialParameters;
use crate::number::{Real, closure};

/// Deformation gradient of the axisymmetric problem: `[[rr, rz], [zr, zz]]` and `tt`.
#[derive(Debug, Clone, Copy)]
pub struct DeformationGradient<T = f64> {
    /// In-plane part.
    pub plane: [[T; 2]; 2],
    /// Hoop stretch.
    pub hoop: T,
}

impl<T: Real> DeformationGradient<T> {
    /// J = det F.
    #[inline(always)]
    pub fn determinant(&self) -> T {
        self.plane_determinant() * self.hoop
    }

    #[inline(always)]
    fn plane_determinant(&self) -> T {
        let f = &self.plane;
        f[0][0] * f[1][1] - f[0][1] * f[1][0]
    }

    /// `F^-1`.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let (f, d) = (&self.plane, self.plane_determinant().recip());
        Self { plane: [[f[1][1] * d, -f[0][1] * d], [-f[1][0] * d, f[0][0] * d]], hoop: self.hoop.recip() }
    }

    /// `F a F^T` for symmetric `a`.
    #[inline(always)]
    pub fn push(&self, a: &Voigt<T>) -> Voigt<T> {
        let f = &self.plane;
        let row = closure!(|i: usize| [
            f[i][0].mul_add(a[0], f[i][1] * a[3]),
            f[i][0].mul_add(a[3], f[i][1] * a[1])
        ]);
        let (r, z) = (row(0), row(1));
        [
            r[0].mul_add(f[0][0], r[1] * f[0][1]),
            z[0].mul_add(f[1][0], z[1] * f[1][1]),
            self.hoop * self.hoop * a[2],
            r[0].mul_add(f[1][0], r[1] * f[1][1]),
        ]
    }

    /// `F F^T`.
    #[inline(always)]
    pub fn left_cauchy_green(&self) -> Voigt<T> {
        let one = self.hoop.constant(1.0);
        self.push(&[one, one, one, self.hoop.constant(0.0)])
    }
}

/// Isochoric Kirchhoff stress, i.e. without `tau_vol` and `-p J 1`, and its spatial tangent.
#[derive(Debug, Clone, Copy)]
pub struct Elasticity<T = f64> {
    /// Isochoric Kirchhoff stress (Pa).
    pub kirchhoff_stress: Voigt<T>,
    /// Spatial tangent (Oldroyd rate) (Pa).
    pub tangent: Voigt2<T>,
}

/// What the update of the history reports, per reference volume.
#[derive(Debug, Clone, Copy, Default)]
pub struct Energetics<T = f64> {
    /// Stored isochoric energy (J/m^3).
    pub stored_energy: T,
    /// Viscous dissipation rate (W/m^3).
    pub viscous_dissipation_rate: T,
}

/// All laws of one material.
#[derive(Debug, Clone)]
pub struct PointMaterial {
    equilibrium: Ogden,
    branches: Vec<Branch>,
    /// Volumetric law.
    pub volumetric: Volumetric,
    /// Seepage law.
    pub darcy: Darcy,
    /// Softening with past strain, where it acts; the caller knows the past and applies it.
    pub softening: Option<Softening>,
    n0s: f64,
    /// Time since the test's start (s).
    time: f64,
}

impl PointMaterial {
    /// The laws of a parameter set.
    pub fn new(p: &MaterialParameters) -> Self {
        Self::extended(p, &Extensions::default(), 0.0)
    }

    /// The laws of a parameter set with extensions, at `time` (s) since the test's start.
    pub fn extended(p: &MaterialParameters, extensions: &Extensions, time: f64) -> Self {
        // Without extensions both factors are exactly 1, and multiplying by them changes no bit.
        let Extensions { amplitude, inverse_stress, permeability_exponent, softening, .. } = *extensions;
        let scale = amplitude * extensions.growth(time);
        Self {
            equilibrium: Ogden::scaled(&p.equilibrium, scale),
            branches: p.branches.iter().map(|b| Branch::extended(b, scale, inverse_stress)).collect(),
            volumetric: Volumetric::scaled(p.lambda_star, p.n0s, scale),
            darcy: Darcy::extended(
                p.permeability,
                p.fluid_viscosity,
                p.n0s,
                permeability_exponent,
                1.0 / amplitude,
            ),
            softening,
            n0s: p.n0s,
            time,
        }
    }

    pub(super) fn equilibrium_law(&self) -> &Ogden {
        &self.equilibrium
    }

    pub(super) fn branch_laws(&self) -> &[Branch] {
        &self.branches
    }

    /// Time since the test's start that it is made for (s).
    pub(super) fn time(&self) -> f64 {
        self.time
    }

    /// Softening that takes anything from the stress; one that takes nothing is there to be differentiated by.
    #[inline(always)]
    pub fn weakening(&self) -> Option<&Softening> {
        self.softening.as_ref().filter(|softening| softening.loss != 0.0)
    }

    /// Whether all dashpots are linear.
    pub fn flows_linearly(&self) -> bool {
        self.branches.iter().all(Branch::is_linear)
    }

    /// Initial solid volume fraction n0S [-].
    pub fn n0s(&self) -> f64 {
        self.n0s
    }

    /// Number of viscous branches, i.e. of history tensors `Cv^-1` per point.
    pub fn branches(&self) -> usize {
        self.branches.len()
    }

    /// Whether the point can be evaluated (in every lane): pores open, not turned inside out.
    #[inline(always)]
    pub fn admissible<T: Real>(&self, f: &DeformationGradient<T>) -> bool {
        let zero = f.hoop.constant(0.0);
        f.hoop.all_greater(zero)
            && f.plane_determinant().all_greater(zero)
            && f.determinant().all_greater(zero + self.n0s)
    }

    /// Isochoric stress and consistent tangent at the end of a step of `dt` (s) (Eqs. 8, 9, 12).
    ///
    /// `history` holds `Cv^-1` of every branch at the start of the step. `None` when the
    /// deformation is inadmissible.
    #[inline(always)]
    pub fn elasticity<T: Real>(
        &self,
        f: &DeformationGradient<T>,
        history: &[Voigt<T>],
        dt: f64,
    ) -> Option<Elasticity<T>> {
        if !self.admissible(f) {
            return None;
        }
        let zero = f.hoop.constant(0.0);
        let (mut tau, mut c) = ([zero; 4], [[zero; 4]; 4]);
        let frame = Spectral::of(&f.left_cauchy_green())?;
        let q = self.equilibrium.powers(&deviator(&frame.log_strains()));
        let beta = self.equilibrium.stress(&q);
        add(&mut tau, &frame.compose(&beta));
        frame.add_tangent(&beta, &self.equilibrium.tangent(&q), &mut c);

        for (branch, cv_inverse) in self.branches.iter().zip(history) {
            let frame = Spectral::of(&f.push(cv_inverse))?;
            let relaxed = branch.relax(&deviator(&frame.log_strains()), dt)?;
            let beta = branch.spring.stress(&relaxed.powers);
            add(&mut tau, &frame.compose(&beta));
            frame.add_tangent(&beta, &branch.tangent(&relaxed.powers, dt), &mut c);
        }
        Some(Elasticity { kirchhoff_stress: tau, tangent: c })
    }

    /// Volumetric Kirchhoff stress and `J d tau / dJ` (Pa) at the dilatation `J - 1` (Eq. 10); `None` at compaction.
    #[inline(always)]
    pub fn volumetric_stress<T: Real>(&self, dilatation: T) -> Option<(T, T)> {
        let compact = dilatation.constant(self.n0s - 1.0);
        if dilatation.all_greater(compact) { Some(self.volumetric.stress(dilatation)) } else { None }
    }

    /// Advances the history over a converged step and returns the energies at its end.
    ///
    /// `reach = 1` gives the end of the step; another value continues the viscous flow of the step
    /// linearly in logarithmic strain (the SDIRK stage value).
    #[inline(always)]
    pub fn update<T: Real>(
        &self,
        f: &DeformationGradient<T>,
        history: &[Voigt<T>],
        dt: f64,
        reach: f64,
        updated: &mut [Voigt<T>],
    ) -> Option<Energetics<T>> {
        let frame = Spectral::of(&f.left_cauchy_green())?;
        let q = self.equilibrium.powers(&deviator(&frame.log_strains()));
        let mut stored_energy = self.equilibrium.energy(&q);
        let mut viscous_dissipation_rate = f.hoop.constant(0.0);
        let f_inverse = f.inverse();
        for ((branch, cv_inverse), new) in self.branches.iter().zip(history).zip(updated) {
            let frame = Spectral::of(&f.push(cv_inverse))?;
            let trial = deviator(&frame.log_strains());
            let relaxed = branch.relax(&trial, dt)?;
            let square = closure!(
                |a: usize| frame.squares[a] * ((relaxed.strain[a] - trial[a]) * (2.0 * reach)).exp()
            );
            *new = f_inverse.push(&frame.compose(&[square(0), square(1), square(2)]));
            stored_energy += branch.spring.energy(&relaxed.powers);
            viscous_dissipation_rate += branch.dissipation(&branch.spring.stress(&relaxed.powers));
        }
        Some(Energetics { stored_energy, viscous_dissipation_rate })
    }
}

#[inline(always)]
pub(crate) fn add<T: Real>(into: &mut Voigt<T>, v: &Voigt<T>) {
    for (a, b) in into.iter_mut().zip(v) {
        *a += *b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tangent against central differences of the stress along a general velocity gradient `l`:
    /// `d tau = C : d + l tau + tau l^T`.
    #[test]
    fn tangent_matches_finite_differences() {
        for inverse_stress in [0.0, 5e-3] {
            let extensions = Extensions { inverse_stress, ..Default::default() };
            let material = PointMaterial::extended(&MaterialParameters::default(), &extensions, 0.0);
            matches_finite_differences(&material);
        }
    }

    fn matches_finite_differences(material: &PointMaterial) {
        let history = [[1.1, 0.93, 1.0 / (1.1 * 0.93 - 0.0025), 0.05], [0.9, 1.05, 1.06, -0.02]];
        let f = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
        let (dt, h) = (3e-3, 1e-6);
        let elasticity = material.elasticity(&f, &history, dt).unwrap();
        let tau = elasticity.kirchhoff_stress;
        for k in 0..5 {
            let mut l = [[0.0; 2]; 2];
            let mut l_hoop = 0.0;
            match k {
                0..4 => l[k / 2][k % 2] = 1.0,
                _ => l_hoop = 1.0,
            }
            let moved = |s: f64| {
                let mut g = f;
                for i in 0..2 {
                    for j in 0..2 {
                        g.plane[i][j] += s * (l[i][0] * f.plane[0][j] + l[i][1] * f.plane[1][j]);
                    }
                }
                g.hoop += s * l_hoop * f.hoop;
                material.elasticity(&g, &history, dt).unwrap().kirchhoff_stress
            };
            let (up, down) = (moved(h), moved(-h));
            let d = [l[0][0], l[1][1], l_hoop, l[0][1] + l[1][0]];
            let convected = [
                2.0 * (l[0][0] * tau[0] + l[0][1] * tau[3]),
                2.0 * (l[1][0] * tau[3] + l[1][1] * tau[1]),
                2.0 * l_hoop * tau[2],
                l[0][0] * tau[3] + l[0][1] * tau[1] + l[1][0] * tau[0] + l[1][1] * tau[3],
            ];
            for i in 0..4 {
                let analytic = convected[i] + (0..4).map(|j| elasticity.tangent[i][j] * d[j]).sum::<f64>();
                let numeric = (up[i] - down[i]) / (2.0 * h);
                approx::assert_relative_eq!(analytic, numeric, max_relative = 1e-6, epsilon = 1e-2);
            }
        }
    }

    #[test]
    fn viscous_flow_preserves_volume() {
        let material = PointMaterial::new(&MaterialParameters::default());
        let f = DeformationGradient { plane: [[1.2, 0.3], [0.1, 0.8]], hoop: 1.05 };
        let mut updated = [[0.0; 4]; 2];
        material.update(&f, &[super::super::IDENTITY; 2], 0.05, 1.0, &mut updated).unwrap();
        for c in updated {
            approx::assert_relative_eq!((c[0] * c[1] - c[3] * c[3]) * c[2], 1.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn a_compacted_point_is_refused() {
        let material = PointMaterial::new(&MaterialParameters { n0s: 0.5, ..Default::default() });
        let f = DeformationGradient { plane: [[1.0, 0.0], [0.0, 0.49]], hoop: 1.0 };
        assert!(material.elasticity(&f, &[super::super::IDENTITY; 2], 1.0).is_none());
    }
}
