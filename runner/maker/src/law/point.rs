//! All laws together at one point of the solid skeleton (Eq. 7).

use super::branch::{self, Flow, Thinning};
use super::porous::{Seepage, Volumetric};
use super::{ONE, Symmetric, Tensor, determinant, inverse, push};
use crate::error::Failure;
use crate::specimen::Material;
use crate::time::Formula;

/// Loss of stiffness with the largest energy that the equilibrium spring has stored so far (Mullins):
/// stresses times `1 - loss (1 - exp(-W/W0))`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softening {
    /// Share that is lost in the end [-].
    pub loss: f64,
    /// `W0` over the spring's shear modulus [-].
    pub energy: f64,
}

/// The laws of a specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Laws {
    /// Parameters.
    pub material: Material,
    /// Eq. 10 or another.
    pub volumetric: Volumetric,
    /// Eq. 11 or another.
    pub seepage: Seepage,
    /// Nonlinear viscosity of every branch.
    pub thinning: Option<Thinning>,
    /// Softening of all springs and dashpots.
    pub softening: Option<Softening>,
}

/// What a point remembers from one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Past {
    /// `C` of every branch.
    pub viscous: Vec<Symmetric>,
    /// J.
    pub volume: f64,
    /// Largest energy so far, over the equilibrium's shear modulus.
    pub energy: f64,
}

impl Past {
    /// Undeformed.
    pub fn new(branches: usize) -> Self {
        Self { viscous: vec![ONE; branches], volume: 1.0, energy: 0.0 }
    }
}

/// A point in a step: the two last times.
#[derive(Debug, Clone, Copy)]
pub struct Point<'a> {
    /// At the beginning of the step.
    pub last: &'a Past,
    /// One step earlier.
    pub before: &'a Past,
}

/// Response of a point.
#[derive(Debug, Clone)]
pub struct Response {
    /// F^-1.
    pub inverse: Tensor,
    /// J.
    pub volume: f64,
    /// J that the step's formula starts from: `dJ/dt = (J - J*) / gamma`.
    pub volume_start: f64,
    /// Effective Kirchhoff stress (without `-p J`) (Pa).
    pub tau: Symmetric,
    /// Its derivative by `l = dF F^-1` (Pa).
    pub tangent: [[f64; 5]; 4],
    /// Mobility K/mu (m^2/(Pa s)).
    pub mobility: f64,
}

impl Laws {
    /// Response to F at the end of a step of the formula, stresses times `stiffening`; writes the new memory.
    ///
    /// # Errors
    /// When the point is inverted or its flow cannot be solved.
    pub fn respond(
        &self,
        f: &Tensor,
        point: Point<'_>,
        formula: &Formula,
        stiffening: f64,
        now: &mut Past,
    ) -> Result<Response, Failure> {
        let m = &self.material;
        let volume = determinant(f);
        if !(volume > m.solid_fraction && f[0] * f[3] - f[1] * f[2] > 0.0 && f[4] > 0.0) {
            return Err(Failure::Inverted);
        }
        let inverse = inverse(f);
        let spring =
            branch::respond(&m.equilibrium, &Flow { per_stress: 0.0, thinning: None }, &push(f, &ONE))?;
        let (mut tau, mut tangent) = (spring.tau, spring.tangent);
        for (i, b) in m.branches.iter().enumerate() {
            let start = formula.start(&point.last.viscous[i], &point.before.viscous[i]);
            let flow = Flow { per_stress: formula.gamma / b.eta, thinning: self.thinning };
            let stress = branch::respond(&b.spring, &flow, &push(f, &start))?;
            now.viscous[i] = branch::state(&inverse, &stress.elastic);
            for (k, row) in stress.tangent.iter().enumerate() {
                tau[k] += stress.tau[k];
                for (sum, slope) in tangent[k].iter_mut().zip(row) {
                    *sum += slope;
                }
            }
        }
        let energy = spring.energy / m.equilibrium.shear_modulus();
        now.energy = point.last.energy.max(energy);
        now.volume = volume;
        if let Some(s) = &self.softening {
            let decay = (-now.energy / s.energy).exp();
            let left = 1.0 - s.loss * (1.0 - decay);
            if energy > point.last.energy {
                let slope = -s.loss * decay / s.energy / m.equilibrium.shear_modulus();
                let by_gradient = [spring.tau[0], spring.tau[2], spring.tau[2], spring.tau[1], spring.tau[3]];
                for k in 0..4 {
                    for q in 0..5 {
                        tangent[k][q] = left * tangent[k][q] + slope * tau[k] * by_gradient[q];
                    }
                }
            } else {
                tangent.iter_mut().flatten().for_each(|t| *t *= left);
            }
            tau.iter_mut().for_each(|t| *t *= left);
        }
        tau.iter_mut().chain(tangent.iter_mut().flatten()).for_each(|t| *t *= stiffening);
        let (pressure, slope) = self.volumetric.stress(m.lambda, m.solid_fraction, volume);
        for k in [0, 1, 3] {
            tau[k] += pressure;
            for q in [0, 3, 4] {
                tangent[k][q] += slope * volume;
            }
        }
        let mobility = m.permeability / m.fluid_viscosity * self.seepage.factor(m.solid_fraction, volume);
        Ok(Response {
            inverse,
            volume,
            volume_start: formula.start(&[point.last.volume], &[point.before.volume])[0],
            tau,
            tangent,
            mobility,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laws() -> Laws {
        Laws {
            material: Material::table1(),
            volumetric: Volumetric::Compaction,
            seepage: Seepage::Linear,
            thinning: Some(Thinning { stress: 50.0, exponent: 0.7 }),
            softening: Some(Softening { loss: 0.3, energy: 0.05 }),
        }
    }

    /// `dF F^-1` from finite differences against the tangent, also where principal stretches coincide.
    #[test]
    fn tangent_is_the_derivative() {
        let formula = Formula::second_order(0.05, 0.04);
        let mut past = Past::new(2);
        past.viscous[0] = [1.1, 0.95, 0.05, 1.0];
        for f in [[1.1, 0.2, -0.1, 0.8, 1.05], [1.0, 0.3, 0.3, 1.0, 0.9], [1.2, 0.0, 0.0, 1.2, 0.7]] {
            let point = Point { last: &past, before: &past };
            let at = |f: &Tensor| laws().respond(f, point, &formula, 1.1, &mut past.clone()).unwrap();
            let here = at(&f);
            for k in 0..5 {
                let mut l = [0.0; 5];
                l[k] = 1e-6;
                let moved = |sign: f64| {
                    let l = l.map(|l| sign * l);
                    let df = [
                        l[0] * f[0] + l[1] * f[2],
                        l[0] * f[1] + l[1] * f[3],
                        l[2] * f[0] + l[3] * f[2],
                        l[2] * f[1] + l[3] * f[3],
                        l[4] * f[4],
                    ];
                    at(&std::array::from_fn(|i| f[i] + df[i]))
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                for i in 0..4 {
                    let slope = (up.tau[i] - down.tau[i]) / 2e-6;
                    assert!(
                        (slope - here.tangent[i][k]).abs() < 2e-2,
                        "{i} {k}: {slope} {}",
                        here.tangent[i][k]
                    );
                }
            }
        }
    }

    #[test]
    fn a_branch_relaxes_exponentially_at_small_strain() {
        let mut laws = Laws { thinning: None, softening: None, ..laws() };
        laws.material.branches.remove(0);
        let time = laws.material.branches[0].relaxation_time();
        let f = [1.0, 1e-4, 0.0, 1.0, 1.0];
        let (mut last, mut before) = (Past::new(1), Past::new(1));
        let stress_of = |tau: &Symmetric| tau[2] - 1e-4 * laws.material.equilibrium.shear_modulus();
        let (n, dt) = (100, 0.01 * time);
        let mut tau = 0.0;
        for i in 0..n {
            let formula = if i == 0 {
                Formula::first_order(1e-3 * dt)
            } else {
                Formula::second_order(dt, if i == 1 { 1e-3 * dt } else { dt })
            };
            let mut now = Past::new(1);
            tau = stress_of(
                &laws
                    .respond(&f, Point { last: &last, before: &before }, &formula, 1.0, &mut now)
                    .unwrap()
                    .tau,
            );
            before = std::mem::replace(&mut last, now);
        }
        let exact = 1e-4 * 0.5 * 161.0 * 2.97 * (-(n as f64 - 1.0) * 0.01f64).exp();
        assert!((tau / exact - 1.0).abs() < 2e-3, "{tau} {exact}");
    }
}
