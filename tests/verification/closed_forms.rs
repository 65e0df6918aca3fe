//! The closed forms of `analytical/` against values that were published or computed independently (the project's verification list).

use approx::assert_relative_eq;
use tests::analytical::{consolidation, half_space, layer, partial_slip, sphere, unconfined};

/// All published with four or five digits. Tolerance: one in the last.
#[test]
fn published_values() {
    for (t, expected) in [(0.05, 0.2523), (0.2, 0.5041), (0.5, 0.7640)] {
        assert!((consolidation::degree(t) - expected).abs() < 1e-4, "Terzaghi, {t}");
    }
    for (tau, expected) in
        [(0.001, 1.3491), (0.01, 1.3166), (0.05, 1.2550), (0.1, 1.2075), (0.2, 1.1423), (0.5, 1.0469)]
    {
        assert!((unconfined::relaxation(0.1, tau) - expected).abs() < 1e-4, "Armstrong, {tau}");
    }
    for (t, expected) in [(0.01, 1.1758), (0.05, 1.3637), (0.1, 1.1941), (0.2, 0.6817), (0.5, 0.1111)] {
        assert!((sphere::centre_pressure(0.2, t) - expected).abs() < 1e-4, "Cryer, {t}");
    }
    for (nu, ratio, expected) in
        [(0.3, 0.2, 1.2066), (0.45, 0.2, 1.2523), (0.5, 0.2, 1.2806), (0.5, 0.4, 1.6837)]
    {
        let kappa = layer::kappa(nu, ratio);
        assert!((kappa - expected).abs() < 2e-4, "Hayes, nu = {nu}, a/h = {ratio}: {kappa}");
    }
    for (x, expected) in [(0.1, 0.654), (1.0, 0.244), (5.0, 0.054)] {
        assert!((half_space::relaxation_fit(x) - expected).abs() < 1e-3, "Hu, {x}");
    }
}

/// Limits that the forms share.
#[test]
fn limits() {
    assert_relative_eq!(half_space::bonded_punch(1.0, 0.5 - 1e-7, 1.0, 1.0), 8.0, max_relative = 1e-6);
    assert_relative_eq!(half_space::flat_punch(1.0, 0.5, 1.0, 1.0), 8.0);
    assert_relative_eq!(layer::kappa(0.3, 1e-3), 1.0, max_relative = 2e-3);
    // Without a flat part the rounded punch is a sphere while the contact is small.
    let (d, force) = half_space::rounded_punch(0.0, 1.0, 0.01);
    assert_relative_eq!(2.0 / 0.7 * force, half_space::sphere(1.0, 0.3, 1.0, d), max_relative = 1e-3);
    // A face slips up to its middle without friction and sticks up to its edge with much; what the shear does to the pressure vanishes
    // with Dundurs' constant.
    let (stick, force) = partial_slip::flat_punch(0.2, 0.06);
    assert!(stick < 0.02 && force < 1.01, "{stick} {force}");
    let (stick, force) = partial_slip::flat_punch(0.2, 2.0);
    let bonded = half_space::bonded_punch(1.0, 0.2, 1.0, 1.0) / half_space::flat_punch(1.0, 0.2, 1.0, 1.0);
    assert!(stick > 0.999, "{stick}");
    assert_relative_eq!(force, bonded, max_relative = 2e-3);
    let friction = 0.8 * partial_slip::dundurs(0.49);
    let (stick, _) = partial_slip::flat_punch(0.49, friction);
    assert_relative_eq!(stick, partial_slip::uncoupled_stick_radius(0.49, friction), max_relative = 1e-3);
    // A disc that has not drained yet is incompressible: 3 G over E.
    assert_relative_eq!(unconfined::relaxation(0.1, 1e-4), 1.5 / 1.1, max_relative = 5e-3);
    // Late, the ramp's stresses are those of the drained strain; early, the sealed end carries none.
    let ramp = consolidation::Ramp { modulus: 2.0, consolidation: 1.0, height: 1.0, velocity: 1e-3 };
    assert_relative_eq!(ramp.effective_stress(500.0), 2.0 * 1e-3 * 500.0, max_relative = 1e-3);
    assert!(ramp.effective_stress(0.01) < 1e-6 * ramp.stress(0.01));
}
