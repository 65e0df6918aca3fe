//! The material point against finite differences and against the axisymmetric one.

use super::*;
use crate::law::PointMaterial;
use crate::law::point::DeformationGradient;

fn product(a: &Tensor, b: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `d tau = C : d + l tau + tau l^T` against central differences, for all nine velocity gradients.
fn check_tangent(f: &Tensor, history: &[Voigt; 2], tolerance: f64) {
    let material = SolidMaterial::new(&MaterialParameters::default());
    let (dt, h) = (3e-3, 1e-6);
    let exact = material.elasticity(f, history, dt).unwrap();
    let tau: Tensor = std::array::from_fn(|i| std::array::from_fn(|j| exact.kirchhoff_stress[PLACE[i][j]]));
    let largest = exact.tangent.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    for k in 0..9 {
        let mut l = [[0.0; 3]; 3];
        l[k / 3][k % 3] = 1.0;
        let moved = |s: f64| {
            let lf = product(&l, f);
            let g = std::array::from_fn(|i| std::array::from_fn(|j| f[i][j] + s * lf[i][j]));
            material.elasticity(&g, history, dt).unwrap().kirchhoff_stress
        };
        let (up, down) = (moved(h), moved(-h));
        let sym = |i: usize, j: usize| l[i][j] + l[j][i];
        let d = [l[0][0], l[1][1], l[2][2], sym(0, 1), sym(1, 2), sym(2, 0)];
        let lt = product(&l, &tau);
        for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)] {
            let place = PLACE[i][j];
            let analytic = lt[i][j] + lt[j][i] + (0..6).map(|m| exact.tangent[place][m] * d[m]).sum::<f64>();
            let numeric = (up[place] - down[place]) / (2.0 * h);
            assert!((analytic - numeric).abs() < tolerance * largest, "{k} ({i},{j}): {analytic} {numeric}");
        }
    }
}

/// Goal: the tangent is the stress's derivative. Set-up: a general F and flown branches.
/// Reference: central differences. Tolerance: 1e-6 of the largest entry.
#[test]
fn tangent_matches_finite_differences() {
    let f = [[1.1, 0.2, -0.05], [-0.1, 0.9, 0.15], [0.02, -0.12, 1.05]];
    let history = [[1.1, 0.93, 0.98, 0.05, -0.03, 0.02], [0.9, 1.05, 1.06, -0.02, 0.04, 0.01]];
    check_tangent(&f, &history, 1e-6);
}

/// Goal: the spectral derivative at equal eigenvalues. Set-up: triple, double, and nearly equal
/// stretches in a rotated frame. Reference: central differences. Tolerance: 1e-6 of the largest entry.
#[test]
fn tangent_at_equal_stretches_matches_finite_differences() {
    let (c, s) = (0.8, 0.6);
    let turn = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
    let tilt = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]];
    for stretches in
        [[1.0, 1.0, 1.0], [1.1, 1.1, 0.8], [0.9, 1.2, 0.9], [1.1, 1.1 + 1e-8, 0.8], [1.1, 1.1 + 1e-6, 0.8]]
    {
        let diagonal: Tensor =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { stretches[i] } else { 0.0 }));
        let f = product(&product(&turn, &tilt), &diagonal);
        check_tangent(&f, &[IDENTITY; 2], 1e-6);
    }
}

/// Goal: the 3D point is the axisymmetric one. Set-up: an axisymmetric F (x = r, y = hoop, z = z) with
/// flown branches. Reference: [`PointMaterial`]: stress, tangent, updated history, energies.
/// Tolerance: 1e-11 relative to the largest entry.
#[test]
fn equals_the_axisymmetric_point() {
    let p = MaterialParameters::default();
    let (solid, plane) = (SolidMaterial::new(&p), PointMaterial::new(&p));
    let f2 = DeformationGradient { plane: [[1.1, 0.2], [-0.1, 0.85]], hoop: 1.07 };
    let f3 = [[1.1, 0.0, 0.2], [0.0, 1.07, 0.0], [-0.1, 0.0, 0.85]];
    let history2 = [[1.1, 0.93, 1.0 / (1.1 * 0.93 - 0.0025), 0.05], [0.9, 1.05, 1.06, -0.02]];
    // [rr, zz, tt, rz] -> [xx, yy, zz, xy, yz, zx]
    let to3 = |a: &[f64; 4]| [a[0], a[2], a[1], 0.0, 0.0, a[3]];
    let history3 = history2.map(|h| to3(&h));
    let dt = 3e-3;
    let (e2, e3) =
        (plane.elasticity(&f2, &history2, dt).unwrap(), solid.elasticity(&f3, &history3, dt).unwrap());
    const OF: [usize; 4] = [0, 2, 1, 5];
    let size = e2.tangent.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    for i in 0..4 {
        assert!((e2.kirchhoff_stress[i] - e3.kirchhoff_stress[OF[i]]).abs() < 1e-11 * size);
        for j in 0..4 {
            assert!((e2.tangent[i][j] - e3.tangent[OF[i]][OF[j]]).abs() < 1e-11 * size, "{i} {j}");
        }
    }
    let (mut new2, mut new3) = ([[0.0; 4]; 2], [[0.0; 6]; 2]);
    let energies2 = plane.update(&f2, &history2, dt, 2.4, &mut new2).unwrap();
    let energies3 = solid.update(&f3, &history3, dt, 2.4, &mut new3).unwrap();
    for (a, b) in new2.iter().zip(&new3) {
        for (x, y) in to3(a).iter().zip(b) {
            assert!((x - y).abs() < 1e-11);
        }
    }
    approx::assert_relative_eq!(energies2.stored_energy, energies3.stored_energy, max_relative = 1e-11);
    approx::assert_relative_eq!(
        energies2.viscous_dissipation_rate,
        energies3.viscous_dissipation_rate,
        max_relative = 1e-11
    );
}

#[test]
fn a_compacted_or_inverted_point_is_refused() {
    let material = SolidMaterial::new(&MaterialParameters { n0s: 0.5, ..Default::default() });
    let with = |z: f64| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, z]];
    assert!(material.elasticity(&with(0.51), &[IDENTITY; 2], 1.0).is_some());
    assert!(material.elasticity(&with(0.49), &[IDENTITY; 2], 1.0).is_none());
    assert!(material.elasticity(&with(-1.0), &[IDENTITY; 2], 1.0).is_none());
}
