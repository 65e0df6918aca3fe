//! Objectivity: a rotation after the deformation rotates the stress and changes no scalar and no history.
//!
//! Goal: F -> Q F turns the Kirchhoff stress and the tangent with Q and leaves energy, dissipation and `Cv^-1` alone. Set-up: one point with two branches in
//! the middle of their flow, large shear, with and without Eyring flow; rotations by angles up to half a turn in the (r, z) plane, and any rotation in three dimensions.
//! Tolerance: 1e-12 of the largest component.

use poropunch::Parameters;
use poropunch::law::PointMaterial;
use poropunch::law::point::DeformationGradient;

type Plane = [[f64; 2]; 2];

fn times(a: &Plane, b: &Plane) -> Plane {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// `Q a Q^T` of a symmetric tensor [rr, zz, tt, rz], whose shear is `shear` times the last component.
fn turned(q: &Plane, a: &[f64; 4], shear: f64) -> [f64; 4] {
    let plane = [[a[0], shear * a[3]], [shear * a[3], a[1]]];
    let transpose = [[q[0][0], q[1][0]], [q[0][1], q[1][1]]];
    let t = times(&times(q, &plane), &transpose);
    [t[0][0], t[1][1], a[2], t[0][1] / shear]
}

fn close(a: &[f64], b: &[f64], what: &str) {
    let largest = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-12 * largest, "{what}: {a:e}, {b:e} of {largest:e}");
    }
}

#[test]
fn a_rotated_point_is_a_rotated_point() {
    const DT: f64 = 0.05;
    let history =
        [[1.1, 0.93, 1.0 / (1.1 * 0.93 - 0.0025), 0.05], [0.9, 1.05, 1.0 / (0.9 * 1.05 - 4e-4), -0.02]];
    let f = DeformationGradient { plane: [[1.1, 0.35], [-0.1, 0.85]], hoop: 1.07 };
    let mut parameters = Parameters::default();
    for inverse_stress in [0.0, 5e-3] {
        parameters.effect.eyring.inverse_stress = inverse_stress;
        let material = PointMaterial::extended(&parameters.material, &parameters.setup().extensions, 0.0);
        let plain = material.elasticity(&f, &history, DT).unwrap();
        let mut updated = [[0.0; 4]; 2];
        let energies = material.update(&f, &history, DT, 1.0, &mut updated).unwrap();
        for angle in [0.3, 1.0, 2.0, 3.1] {
            let (sin, cos) = f64::sin_cos(angle);
            let q = [[cos, -sin], [sin, cos]];
            let g = DeformationGradient { plane: times(&q, &f.plane), hoop: f.hoop };
            let rotated = material.elasticity(&g, &history, DT).unwrap();
            close(&rotated.kirchhoff_stress, &turned(&q, &plain.kirchhoff_stress, 1.0), "stress");
            // The tangent on a strain that is turned, too; strains have twice the shear.
            for strain in
                [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.2, -0.1, 0.3, 0.7]]
            {
                let on = |c: &[[f64; 4]; 4], d: [f64; 4]| -> [f64; 4] {
                    std::array::from_fn(|i| (0..4).map(|j| c[i][j] * d[j]).sum())
                };
                let expected = turned(&q, &on(&plain.tangent, strain), 1.0);
                close(&on(&rotated.tangent, turned(&q, &strain, 0.5)), &expected, "tangent");
            }
            let mut other = [[0.0; 4]; 2];
            let turned_energies = material.update(&g, &history, DT, 1.0, &mut other).unwrap();
            close(other.as_flattened(), updated.as_flattened(), "history");
            close(&[turned_energies.stored_energy], &[energies.stored_energy], "energy");
            let rates = [turned_energies.viscous_dissipation_rate, energies.viscous_dissipation_rate];
            close(&rates[..1], &rates[1..], "dissipation");
        }
    }
}
