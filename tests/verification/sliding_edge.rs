//! A sharp edge of a face on which the sample slides: how finely it is resolved, and what that does to the force.

use poropunch::parameters::MeshPreset;
use poropunch::{Instance, Model, Parameters, Trapezoid};

fn parameters(preset: MeshPreset, change: &dyn Fn(&mut Parameters)) -> Parameters {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = preset;
    change(&mut parameters);
    parameters
}

/// Largest force (N) at the corners of these cycles.
fn peak(parameters: Parameters, trapezoid: Trapezoid, cycles: i32) -> f64 {
    let protocol = Trapezoid { cycles, ..trapezoid }.protocol().unwrap();
    let mut instance = Instance::new(&Model::new(parameters).unwrap(), protocol.points()[0].1).unwrap();
    let mut peak = 0.0_f64;
    for &(time, displacement) in &protocol.points()[1..] {
        instance.set_displacement(displacement);
        instance.advance(time - instance.time()).unwrap();
        peak = peak.max(instance.outputs().force);
    }
    peak
}

const PRESETS: [MeshPreset; 3] = [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine];

fn frictionless(parameters: &mut Parameters) {
    parameters.boundary.bonded_punch = false;
}

fn hardly_rough(parameters: &mut Parameters) {
    (parameters.boundary.partial_slip, parameters.boundary.friction) = (true, 0.05);
}

fn compliant(parameters: &mut Parameters) {
    parameters.effect.slip.compliance = 1e-6;
}

/// Goal: a face that holds the sample hardly or not at all does not end the simulation, whatever the mesh, and the edge's resolution
/// hardly matters to the force. Set-up: first cycle of P2, frictionless, friction of 0.05 alone, a compliant layer. Tolerance: the
/// peaks on all presets agree within 1 %; frictionless, the peak on `standard` moves by less than 1 % between edges of 0.03 and 0.05 R.
#[test]
fn a_sliding_face_is_no_obstacle() {
    for change in [frictionless, hardly_rough, compliant] {
        let [coarse, standard, fine] =
            PRESETS.map(|preset| peak(parameters(preset, &change), Trapezoid::p2(), 1));
        assert!((coarse / standard - 1.0).abs() < 1e-2, "{coarse} {standard}");
        assert!((fine / standard - 1.0).abs() < 1e-2, "{fine} {standard}");
    }
    let edge = |size: f64| {
        let wider = |p: &mut Parameters| {
            frictionless(p);
            p.mesh.edge_size = size * p.geometry.punch_radius;
        };
        peak(parameters(MeshPreset::Standard, &wider), Trapezoid::p2(), 1)
    };
    let [narrow, wide] = [0.03, 0.05].map(edge);
    assert!((wide / narrow - 1.0).abs() < 1e-2, "{narrow} {wide}");
}

/// Goal: the edge gets coarser with the length by which a layer slides, from the preset's up to 3 % of the radius; a bonded face, one that
/// friction holds and a given size keep theirs. Set-up: layers of 0.05 to 50 % of the radius. Tolerance: none.
#[test]
fn the_edge_follows_the_sliding_length() {
    let size = |change: &dyn Fn(&mut Parameters)| {
        let parameters = parameters(MeshPreset::Fine, change);
        parameters.resolved_mesh().edge_size / parameters.geometry.punch_radius
    };
    // Table 1: 3.3 kPa, so a compliance of 1e-9 m/Pa slides 0.16 % of 2 mm.
    let sizes = [3e-10, 3e-9, 1e-7].map(|compliance| size(&|p| p.effect.slip.compliance = compliance));
    assert_eq!(sizes[0], 0.0);
    assert!((0.01..0.02).contains(&sizes[1]), "{}", sizes[1]);
    assert!((sizes[2] - 0.03).abs() < 1e-12, "{}", sizes[2]);
    assert_eq!(size(&|_| ()), 0.0);
    assert!((size(&frictionless) - 0.03).abs() < 1e-12);
    assert!((size(&hardly_rough) - 0.03).abs() < 1e-12);
    assert_eq!(size(&|p| (p.boundary.partial_slip, p.boundary.friction) = (true, 0.3)), 0.0);
    let given = size(&|p| {
        frictionless(p);
        p.mesh.edge_size = 1e-5;
    });
    assert!((given - 0.005).abs() < 1e-12);
}

/// Goal: the same through whole tests. Set-up: six cycles of P1 and P2 on every preset.
#[test]
#[ignore = "long: a minute"]
fn a_sliding_face_through_six_cycles() {
    for trapezoid in [Trapezoid::p1(), Trapezoid::p2()] {
        for change in [frictionless, hardly_rough, compliant] {
            for preset in PRESETS {
                assert!(peak(parameters(preset, &change), trapezoid, 6) > 0.0);
            }
        }
    }
}
