//! The whole solid skeleton at one integration point, in three dimensions.
//!
//! The laws of [`crate::law`] work on principal strains; only the frame is new.

use super::spectral::Spectral;
use super::{IDENTITY, PLACE, Tensor, Voigt, Voigt2};
use crate::law::branch::Branch;
use crate::law::darcy::Darcy;
use crate::law::ogden::Ogden;
use crate::law::parameters::MaterialParameters;
use crate::law::point::Energetics;
use crate::law::spectral::deviator;
use crate::law::volumetric::Volumetric;

/// `det f`.
#[inline]
pub fn determinant(f: &Tensor) -> f64 {
    f[0][0] * (f[1][1] * f[2][2] - f[1][2] * f[2][1]) - f[0][1] * (f[1][0] * f[2][2] - f[1][2] * f[2][0])
        + f[0][2] * (f[1][0] * f[2][1] - f[1][1] * f[2][0])
}

/// `f^-1`, given its determinant.
#[inline]
pub fn inverse(f: &Tensor, determinant: f64) -> Tensor {
    let d = 1.0 / determinant;
    let minor = |a: usize, b: usize, c: usize, e: usize| d * (f[a][b] * f[c][e] - f[a][e] * f[c][b]);
    [
        [minor(1, 1, 2, 2), minor(0, 2, 2, 1), minor(0, 1, 1, 2)],
        [minor(1, 2, 2, 0), minor(0, 0, 2, 2), minor(0, 2, 1, 0)],
        [minor(1, 0, 2, 1), minor(0, 1, 2, 0), minor(0, 0, 1, 1)],
    ]
}

/// `F a F^T` for symmetric `a`.
#[inline]
pub fn push(f: &Tensor, a: &Voigt) -> Voigt {
    let mut fa = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            fa[i][j] = (0..3).map(|k| f[i][k] * a[PLACE[k][j]]).sum();
        }
    }
    let entry = |i: usize, j: usize| -> f64 { (0..3).map(|k| fa[i][k] * f[j][k]).sum() };
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(2, 0)]
}

/// Isochoric Kirchhoff stress, i.e. without `tau_vol` and `-p J 1`, and its spatial tangent.
#[derive(Debug, Clone, Copy)]
pub struct Elasticity {
    /// Isochoric Kirchhoff stress (Pa).
    pub kirchhoff_stress: Voigt,
    /// Spatial tangent (Oldroyd rate) (Pa).
    pub tangent: Voigt2,
}

/// All laws of one material.
#[derive(Debug, Clone)]
pub struct SolidMaterial {
    equilibrium: Ogden,
    branches: Vec<Branch>,
    /// Volumetric law.
    pub volumetric: Volumetric,
    /// Seepage law.
    pub darcy: Darcy,
    n0s: f64,
}

impl SolidMaterial {
    /// The laws of a parameter set.
    pub fn new(p: &MaterialParameters) -> Self {
        Self {
            equilibrium: Ogden::new(&p.equilibrium),
            branches: p.branches.iter().map(Branch::new).collect(),
            volumetric: Volumetric::new(p.lambda_star, p.n0s),
            darcy: Darcy::new(p.permeability, p.fluid_viscosity, p.n0s),
            n0s: p.n0s,
        }
    }

    /// Number of viscous branches, i.e. of history tensors `Cv^-1` per point.
    pub fn branches(&self) -> usize {
        self.branches.len()
    }

    /// Isochoric stress and consistent tangent at the end of a step of `dt` (s) (Eqs. 8, 9, 12).
    ///
    /// `history` holds `Cv^-1` of every branch at the start of the step. `None` when the pores are
    /// closed, the point is turned inside out or strained beyond the laws' range.
    pub fn elasticity(&self, f: &Tensor, history: &[Voigt], dt: f64) -> Option<Elasticity> {
        let j = determinant(f);
        if !(j > self.n0s && j > 0.0) {
            return None;
        }
        let mut result = Elasticity { kirchhoff_stress: [0.0; 6], tangent: [[0.0; 6]; 6] };
        let frame = Spectral::of(&push(f, &IDENTITY))?;
        let q = self.equilibrium.powers(&deviator(&frame.log_strains()));
        result.add(&frame, &self.equilibrium.stress(&q), &self.equilibrium.tangent(&q));
        for (branch, cv_inverse) in self.branches.iter().zip(history) {
            let frame = Spectral::of(&push(f, cv_inverse))?;
            let relaxed = branch.relax(&deviator(&frame.log_strains()), dt)?;
            let beta = branch.spring.stress(&relaxed.powers);
            result.add(&frame, &beta, &branch.tangent(&relaxed.powers, dt));
        }
        Some(result)
    }

    /// Volumetric Kirchhoff stress and `J d tau / dJ` (Pa) at the dilatation `J - 1` (Eq. 10); `None` at compaction.
    #[inline]
    pub fn volumetric_stress(&self, dilatation: f64) -> Option<(f64, f64)> {
        (dilatation > self.n0s - 1.0).then(|| self.volumetric.stress(dilatation))
    }

    /// Advances the history over a converged step and returns the energies at its end; `reach` as in
    /// [`crate::law::PointMaterial::update`].
    pub fn update(
        &self,
        f: &Tensor,
        history: &[Voigt],
        dt: f64,
        reach: f64,
        updated: &mut [Voigt],
    ) -> Option<Energetics> {
        let frame = Spectral::of(&push(f, &IDENTITY))?;
        let q = self.equilibrium.powers(&deviator(&frame.log_strains()));
        let mut energetics =
            Energetics { stored_energy: self.equilibrium.energy(&q), viscous_dissipation_rate: 0.0 };
        let f_inverse = inverse(f, determinant(f));
        for ((branch, cv_inverse), new) in self.branches.iter().zip(history).zip(updated) {
            let frame = Spectral::of(&push(f, cv_inverse))?;
            let deviatoric = deviator(&frame.log_strains());
            let relaxed = branch.relax(&deviatoric, dt)?;
            let flow: [f64; 3] = std::array::from_fn(|a| reach * (relaxed.strain[a] - deviatoric[a]));
            let squares: [f64; 3] = std::array::from_fn(|a| frame.squares[a] * (2.0 * flow[a]).exp());
            *new = push(&f_inverse, &frame.compose(&squares));
            energetics.stored_energy += branch.spring.energy(&relaxed.powers);
            energetics.viscous_dissipation_rate += branch.dissipation(&branch.spring.stress(&relaxed.powers));
        }
        Some(energetics)
    }
}

impl Elasticity {
    #[inline]
    fn add(&mut self, frame: &Spectral, beta: &[f64; 3], dbeta: &[[f64; 3]; 3]) {
        for (a, b) in self.kirchhoff_stress.iter_mut().zip(frame.compose(beta)) {
            *a += b;
        }
        frame.add_tangent(beta, dbeta, &mut self.tangent);
    }
}

#[cfg(test)]
#[path = "point_tests.rs"]
mod tests;
