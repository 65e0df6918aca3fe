//! How stress, history and seepage at a point change with the magnitudes of the extensions, at fixed deformation and history.
//!
//! A factor on all stresses - moduli and viscosities alike - leaves the flow as it is, and the stress grows with it.

use super::Voigt;
use super::magnitude::Magnitude;
use super::point::{PointMaterial, add};
use super::sensitivity::ConvergedStep;
use super::spectral::{Spectral, deviator};
use crate::number::{Real, closure, each};

impl PointMaterial {
    /// Adds the changes of the isochoric Kirchhoff stress, which is `undamaged` before it softens, to one tensor per magnitude
    /// (Pa per unit of the magnitude). `None` as in `elasticity`.
    #[inline(always)]
    pub fn add_stress_by_magnitude<T: Real>(
        &self,
        ConvergedStep { f, history, dt }: ConvergedStep<'_, T>,
        undamaged: &Voigt<T>,
        stress: &mut [Voigt<T>],
    ) -> Option<()> {
        add(&mut stress[Magnitude::Amplitude.index()], undamaged);
        let grown = each(undamaged, closure!(|tau: T| tau * self.time()));
        add(&mut stress[Magnitude::GrowthRate.index()], &grown);
        for (branch, cv_inverse) in self.branch_laws().iter().zip(history) {
            if branch.is_linear() {
                continue;
            }
            let frame = Spectral::of(&f.push(cv_inverse))?;
            let relaxed = branch.relax(&deviator(&frame.log_strains()), dt)?;
            let [_, beta] = branch.by_inverse_stress(&relaxed, dt);
            add(&mut stress[Magnitude::InverseStress.index()], &frame.compose(&beta));
        }
        Some(())
    }

    /// Changes of the history over a converged step by the inverse stress of Eyring flow, branch by branch; no other magnitude
    /// changes it. `None` as in `update`.
    #[inline(always)]
    pub fn history_by_inverse_stress<T: Real>(
        &self,
        ConvergedStep { f, history, dt }: ConvergedStep<'_, T>,
        reach: f64,
        mut change: impl FnMut(usize, Voigt<T>),
    ) -> Option<()> {
        let f_inverse = f.inverse();
        for (index, (branch, cv_inverse)) in self.branch_laws().iter().zip(history).enumerate() {
            if branch.is_linear() {
                continue;
            }
            let frame = Spectral::of(&f.push(cv_inverse))?;
            let trial = deviator(&frame.log_strains());
            let relaxed = branch.relax(&trial, dt)?;
            let [strain, _] = branch.by_inverse_stress(&relaxed, dt);
            let square = closure!(|a: usize| {
                let flow = (relaxed.strain[a] - trial[a]) * (2.0 * reach);
                frame.squares[a] * flow.exp() * strain[a] * (2.0 * reach)
            });
            change(index, f_inverse.push(&frame.compose(&[square(0), square(1), square(2)])));
        }
        Some(())
    }

    /// Changes of the volumetric Kirchhoff stress (Pa) by the magnitudes that have any.
    #[inline(always)]
    pub fn volumetric_by_magnitude<T: Real>(&self, j: T) -> [(Magnitude, T); 2] {
        let (tau, _) = self.volumetric.stress(j - 1.0);
        [(Magnitude::Amplitude, tau), (Magnitude::GrowthRate, tau * self.time())]
    }

    /// Changes of the referential mobility by the magnitudes that have any.
    #[inline(always)]
    pub fn mobility_by_magnitude<T: Real>(&self, j: T) -> [(Magnitude, T); 2] {
        let (mobility, _) = self.darcy.referential_mobility(j);
        [(Magnitude::Amplitude, -mobility), (Magnitude::PermeabilityExponent, self.darcy.by_exponent(j))]
    }
}

#[cfg(test)]
mod tests {
    use super::super::extensions::Extensions;
    use super::super::parameters::MaterialParameters;
    use super::super::point::DeformationGradient;
    use super::*;

    const DT: f64 = 3e-3;
    const REACH: f64 = 2.414;
    const TIME: f64 = 20.0;
    const F: DeformationGradient = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
    const HISTORY: [Voigt; 2] = [[1.1, 0.93, 1.0 / (1.1 * 0.93 - 0.0025), 0.05], [0.9, 1.05, 1.06, -0.02]];
    const STEP: ConvergedStep<'static> = ConvergedStep { f: &F, history: &HISTORY, dt: DT };

    fn extensions() -> Extensions {
        Extensions {
            inverse_stress: 5e-3,
            permeability_exponent: 4.0,
            amplitude: 1.5,
            growth_rate: 1e-2,
            softening: None,
        }
    }

    fn made(extensions: &Extensions) -> PointMaterial {
        PointMaterial::extended(&MaterialParameters::default(), extensions, TIME)
    }

    type Move = fn(&mut Extensions, f64);

    /// The magnitudes of the laws, how the extensions move with them, and steps for differences.
    fn moves() -> [(Magnitude, Move, f64); 4] {
        [
            (Magnitude::InverseStress, |e, by| e.inverse_stress += by, 1e-7),
            (Magnitude::PermeabilityExponent, |e, by| e.permeability_exponent += by, 1e-4),
            (Magnitude::GrowthRate, |e, by| e.growth_rate += by, 1e-6),
            (Magnitude::Amplitude, |e, by| e.amplitude *= by.exp(), 1e-5),
        ]
    }

    /// Compares derivatives with differences, 1e-7 of the largest, or of what rounding hides.
    fn compare(exact: &[f64], slopes: &[f64], least: f64) {
        let largest = slopes.iter().fold(least, |m, s| m.max(s.abs()));
        for (exact, slope) in exact.iter().zip(slopes) {
            assert!((exact - slope).abs() <= 1e-7 * largest, "{exact:e} {slope:e}");
        }
    }

    /// Isochoric and volumetric stress, mobility and updated history against central differences; the weaker of the two flows is
    /// nearly that of linear dashpots.
    #[test]
    fn changes_match_finite_differences() {
        for start in [extensions(), Extensions { inverse_stress: 2e-4, ..Extensions::default() }] {
            let material = made(&start);
            let undamaged = material.elasticity(&F, &HISTORY, DT).unwrap().kirchhoff_stress;
            let mut stress = vec![[0.0; 4]; Magnitude::ALL.len()];
            material.add_stress_by_magnitude(STEP, &undamaged, &mut stress).unwrap();
            let mut history = [[0.0; 4]; 2];
            material.history_by_inverse_stress(STEP, REACH, |branch, new| history[branch] = new).unwrap();
            for (magnitude, change, h) in moves() {
                let at = |by: f64| {
                    let mut moved = start;
                    change(&mut moved, by);
                    let material = made(&moved);
                    let mut updated = [[0.0; 4]; 2];
                    material.update(&F, &HISTORY, DT, REACH, &mut updated).unwrap();
                    let stress = material.elasticity(&F, &HISTORY, DT).unwrap().kirchhoff_stress;
                    let (mobility, _) = material.darcy.referential_mobility(0.9);
                    (stress, [material.volumetric.stress(-0.1).0], [mobility], updated.concat())
                };
                let (up, down) = (at(h), at(-h));
                let slopes = |up: &[f64], down: &[f64]| -> Vec<f64> {
                    up.iter().zip(down).map(|(up, down)| (up - down) / (2.0 * h)).collect()
                };
                let of = |pairs: [(Magnitude, f64); 2]| {
                    pairs.into_iter().find(|(m, _)| *m == magnitude).map_or(0.0, |(_, value)| value)
                };
                compare(&stress[magnitude.index()], &slopes(&up.0, &down.0), 1e-2);
                let volumetric = of(material.volumetric_by_magnitude(0.9));
                compare(&[volumetric], &slopes(&up.1, &down.1), 1e-2);
                let mobility = of(material.mobility_by_magnitude(0.9));
                compare(&[mobility], &slopes(&up.2, &down.2), 1e-3 * up.2[0]);
                let flows = if magnitude == Magnitude::InverseStress { 1.0 } else { 0.0 };
                let history: Vec<f64> = history.concat().iter().map(|change| flows * change).collect();
                compare(&history, &slopes(&up.3, &down.3), 1e-2);
            }
        }
    }

    /// A linear dashpot is the limit of an even function of the inverse stress: the derivative is 0 there.
    #[test]
    fn a_linear_dashpot_has_no_slope() {
        let material = made(&Extensions::default());
        let mut stress = vec![[0.0; 4]; Magnitude::ALL.len()];
        material.add_stress_by_magnitude(STEP, &[0.0; 4], &mut stress).unwrap();
        assert_eq!(stress[Magnitude::InverseStress.index()], [0.0; 4]);
        material.history_by_inverse_stress(STEP, REACH, |_, _| panic!("a change")).unwrap();
    }
}
