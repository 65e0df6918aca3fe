//! Unilateral contact: the punch separates, stays away and touches again.

use poropunch::contact::status::Status;
use poropunch::motion::protocol::{Protocol, Trapezoid};
use poropunch::parameters::MeshPreset;
use poropunch::specimen::{Discretisation, Motion, Patience, Sample, Stepper};
use poropunch::{Instance, Model, Outputs, Parameters, Statistics, StepError};
use runner::data::{Wanted, protocol_of, read};
use tests::{DEPTH, arrive, coarse, follow, move_to, try_follow};

/// Goal: all six cycles of both protocols are simulated; the punch never pulls, is free of force while it is
/// above the surface, and the energies balance through every opening and closing. Set-up: Table 1, coarse mesh,
/// 20 results per leg. Tolerance: pull below 1e-4 mN; balance 0.5 % of the work; no peak 0.2 % above the one
/// before it; a later peak at least half the first (published: 9 of 11 mN in cycle 6 of P1).
#[test]
fn six_cycles() {
    check_six_cycles(MeshPreset::Coarse, &[Trapezoid::p2()]);
}

/// Goal: the same of the other protocol.
#[test]
#[ignore = "long: six cycles"]
fn six_cycles_of_p1() {
    check_six_cycles(MeshPreset::Coarse, &[Trapezoid::p1()]);
}

/// Goal: the same on the finer meshes.
#[test]
#[ignore = "long: a minute and a half"]
fn six_cycles_standard_and_fine() {
    check_six_cycles(MeshPreset::Standard, &[Trapezoid::p1(), Trapezoid::p2()]);
    check_six_cycles(MeshPreset::Fine, &[Trapezoid::p1(), Trapezoid::p2()]);
}

fn check_six_cycles(preset: MeshPreset, protocols: &[Trapezoid]) {
    for &trapezoid in protocols {
        let mut parameters = coarse();
        parameters.mesh.preset = preset;
        let results = follow(&parameters, &Trapezoid { cycles: 6, ..trapezoid }.protocol().unwrap(), 20);
        for (time, o) in &results {
            assert!(o.force > -1e-7, "{} N at {time} s", o.force);
            assert!(o.displacement > 0.0 || o.force == 0.0, "{} N above the surface at {time} s", o.force);
            let spent = o.stored_energy + o.viscous_dissipation + o.porous_dissipation;
            assert!((spent - o.external_work).abs() < 5e-3 * o.external_work + 1e-12, "{time} s: {o:?}");
        }
        let peak = |cycle: &[(f64, Outputs)]| cycle.iter().map(|r| r.1.force).fold(0.0, f64::max);
        let peaks: Vec<f64> = results.chunks(6 * 20).map(peak).collect();
        assert_eq!(peaks.len(), 6);
        assert!(peaks.windows(2).all(|p| p[1] <= p[0] * (1.0 + 2e-3)), "{peaks:?}");
        assert!(peaks[5] > 0.5 * peaks[0], "{peaks:?}");
    }
}

/// Goal: force and energy are continuous through separation. Set-up: P2's first unloading in 400 results, coarse
/// mesh; the punch travels 2.75 um between two of them while it is in contact. Tolerance: the force changes by at
/// most 5 % of the peak (it falls by 40 % within the first 0.1 mm), the work by at most
/// 1.5 times force times travel and 1e-4 of itself, its error within a step that opens the face.
#[test]
fn separation_is_continuous() {
    let model = Model::new(coarse()).unwrap();
    let mut instance = Instance::new(&model, 0.0).unwrap();
    move_to(&mut instance, DEPTH, 0.625);
    let peak = instance.outputs().force;
    instance.advance(90.0).unwrap();
    let mut last = instance.outputs();
    for k in 1..=400 {
        move_to(&mut instance, DEPTH * (1.0 - f64::from(k) / 400.0), 1.0 / 400.0);
        let o = instance.outputs();
        assert!((o.force - last.force).abs() < 0.05 * peak, "{k}: {} after {}", o.force, last.force);
        let largest = o.force.max(last.force) * DEPTH / 400.0;
        let change = (o.external_work - last.external_work).abs();
        assert!(change < 1.5 * largest + 1e-4 * o.external_work, "{k}: {change:e} J, {largest:e} J");
        last = o;
    }
    assert_eq!(last.force, 0.0);
}

/// Goal: results do not depend on how a master slices time, through separation and a second touch. Set-up: one
/// and a half cycles of P2, coarse mesh, 3 and 50 communication steps per leg. Tolerance: 1 % of the peak.
#[test]
fn slices_do_not_matter_through_contact() {
    let trapezoid = Trapezoid { cycles: 2, ..Trapezoid::p2() };
    let [few, many] = [3, 51].map(|n| follow(&coarse(), &trapezoid.protocol().unwrap(), n));
    let peak = few.iter().map(|r| r.1.force).fold(0.0, f64::max);
    for (k, (time, o)) in few.iter().enumerate() {
        let other = many[17 * (k + 1) - 1].1.force;
        assert!((o.force - other).abs() < 1e-2 * peak, "{time} s: {} and {other}", o.force);
    }
}

/// Goal: saving and restoring is bit-identical in the middle of peeling and in flight.
#[test]
fn restored_runs_are_bit_identical() {
    let model = Model::new(coarse()).unwrap();
    let mut first = Instance::new(&model, 0.0).unwrap();
    move_to(&mut first, DEPTH, 0.625);
    first.advance(10.0).unwrap();
    for depth in [0.75 * DEPTH, 0.7 * DEPTH, -0.2 * DEPTH] {
        let duration = (first.outputs().displacement - depth) / 1e-3;
        move_to(&mut first, depth, duration);
        let snapshot = first.save();
        let run = |instance: &mut Instance| -> Vec<u64> {
            instance.restore(&snapshot).unwrap();
            (0..30)
                .map(|k| {
                    move_to(instance, depth + DEPTH * 0.05 * f64::from(k - 15).abs() - 0.75 * DEPTH, 0.05);
                    instance.outputs().force.to_bits()
                })
                .collect()
        };
        let reference = run(&mut first);
        assert_eq!(reference, run(&mut first));
        assert_eq!(reference, run(&mut Instance::new(&model, 0.0).unwrap()));
        first.restore(&snapshot).unwrap();
    }
}

/// Goal: unusual motions. A punch that leaves for ever, a displacement that jumps by 1 mm within 1 ms, a history
/// that ends while the surface is half peeled: right behaviour; indentation deeper than the sample: its error.
#[test]
fn unusual_motions() {
    let model = Model::new(coarse()).unwrap();
    let mut instance = Instance::new(&model, -1e-4).unwrap();
    move_to(&mut instance, 0.5 * DEPTH, 1e-3);
    assert!(instance.outputs().force > 0.0);
    move_to(&mut instance, -0.5, 1e-3);
    instance.advance(1e5).unwrap();
    assert_eq!(instance.outputs().force, 0.0);
    assert!(instance.outputs().stored_energy < 1e-3 * instance.outputs().external_work);
    instance.set_displacement(0.02);
    assert!(matches!(instance.advance(1.0), Err(StepError::TooDeep { .. })));
    move_to(&mut instance, 0.3 * DEPTH, 1.0);
    assert!(instance.outputs().force > 0.0);
}

/// Goal: robust without tuning: every parameter half as large and half as large again. Set-up: P2, two cycles,
/// coarse mesh; three that matter most to the force here, all of them in the sweeps below.
#[test]
fn parameters_may_vary_by_half() {
    for (name, change) in CHANGES.iter().filter(|(name, _)| QUICK.contains(name)) {
        let twice = Trapezoid { cycles: 2, ..Trapezoid::p2() };
        let failures = vary(name, *change, &BY_HALF, twice, MeshPreset::Coarse);
        assert!(failures.is_empty(), "{failures:#?}");
    }
}

/// Goal: the same for all parameters, six cycles of both protocols. Every case is printed when it is done.
#[test]
#[ignore = "long: four minutes"]
fn whole_sweep_coarse() {
    sweep(MeshPreset::Coarse, |_| &BY_HALF);
}

/// Goal: the same on the standard mesh.
#[test]
#[ignore = "long: five minutes"]
fn whole_sweep_standard() {
    sweep(MeshPreset::Standard, |_| &BY_HALF);
}

/// Goal: the same on the fine mesh.
#[test]
#[ignore = "long: half an hour"]
fn whole_sweep_fine() {
    sweep(MeshPreset::Fine, |_| &BY_HALF);
}

/// Goal: the same for every parameter of the material at a third and at three times its value, and lambda* from
/// 300 Pa to 1 MPa. The fluid's viscosity acts through its ratio to K0 alone.
#[test]
#[ignore = "long: ten minutes"]
fn wide_sweep_coarse() {
    sweep(MeshPreset::Coarse, wide);
}

/// Goal: the same on the standard mesh.
#[test]
#[ignore = "long: twenty minutes"]
fn wide_sweep_standard() {
    sweep(MeshPreset::Standard, wide);
}

/// Goal: the same on the fine mesh.
#[test]
#[ignore = "long: eight minutes"]
fn wide_sweep_fine() {
    sweep(MeshPreset::Fine, wide);
}

/// Goal: a skeleton that is weak in volume does not end the simulation, whatever the mesh, and the edge's resolution
/// hardly matters to the force. Set-up: lambda* = 500 Pa, first cycle of P2. Tolerance: the peaks on all presets agree
/// within 1 %; on `standard` they move by less than 0.2 % between edges of 0.02 and 0.06 R, and by less than 0.3 %
/// where lambda* passes the value below which the edge is broken.
#[test]
fn a_weak_skeleton_is_no_obstacle() {
    let peak = |preset: MeshPreset, lambda_star: f64, edge_size: f64| {
        let mut parameters = coarse();
        parameters.mesh.preset = preset;
        parameters.mesh.edge_size = edge_size * parameters.geometry.punch_radius;
        parameters.material.lambda_star = lambda_star;
        let results = follow(&parameters, &Trapezoid { cycles: 1, ..Trapezoid::p2() }.protocol().unwrap(), 5);
        results.iter().map(|r| r.1.force).fold(0.0, f64::max)
    };
    let [quick, standard, fine] =
        [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine].map(|preset| peak(preset, 500.0, 0.0));
    assert!((quick / standard - 1.0).abs() < 1e-2, "{quick} {standard}");
    assert!((fine / standard - 1.0).abs() < 1e-2, "{fine} {standard}");
    let [narrow, wide] = [0.02, 0.06].map(|edge| peak(MeshPreset::Standard, 500.0, edge));
    assert!((wide / narrow - 1.0).abs() < 2e-3, "{narrow} {wide}");
    let shear = Parameters::default().material.instantaneous_shear_modulus();
    let [below, above] = [0.9999, 1.0001].map(|f| peak(MeshPreset::Standard, f * 1.3 * shear, 0.0));
    assert!((below / above - 1.0).abs() < 3e-3 && below != above, "{below} {above}");
}

fn sweep(preset: MeshPreset, factors: fn(&str) -> &'static [f64]) {
    let six = |protocol: Trapezoid| Trapezoid { cycles: 6, ..protocol };
    let all = |protocol: Trapezoid| -> Vec<String> {
        let vary = |(name, change): &Change| vary(name, *change, factors(name), protocol, preset);
        CHANGES.iter().flat_map(vary).collect()
    };
    let failures = std::thread::scope(|scope| {
        let other = scope.spawn(|| all(six(Trapezoid::p2())));
        [all(six(Trapezoid::p1())), other.join().unwrap()].concat()
    });
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Goal: loading and holding in unilateral contact is loading with the face's displacement prescribed. Set-up: P1
/// and P2; an adhesion of 1 MPa keeps the face closed whatever pulls at it. Tolerance: 1e-6 of the force.
#[test]
fn the_first_cycle_is_that_of_prescribed_displacements() {
    for trapezoid in [Trapezoid::p1(), Trapezoid::p2()] {
        let mut prescribed = coarse();
        prescribed.effect.adhesion.strength = 1e6;
        let [contact, prescribed] = [coarse(), prescribed].map(|p| {
            let loading = trapezoid.first_hold().unwrap();
            let mut instance = Instance::new(&Model::new(p).unwrap(), loading.points()[0].1).unwrap();
            let mut at = |time: f64| {
                arrive(&mut instance, loading.displacement(time), time);
                instance.outputs().force
            };
            let peak = loading.points()[1].0;
            [0.5 * peak, peak, peak + 1.0, peak + 10.0, loading.end_time()].map(&mut at)
        });
        for (a, b) in contact.into_iter().zip(prescribed) {
            assert!((a - b).abs() < 1e-6 * b, "{a} {b}");
        }
    }
}

/// Goal: what the contact does not have: partial slip. A face that is pressed down everywhere sticks everywhere, where Spence's
/// would slip in a ring; friction acts beside parts that open. Set-up: P2's ramp. Tolerance: none, bit for bit.
#[test]
fn a_pressed_face_does_not_slip_whatever_the_friction() {
    let force = |friction: f64| {
        let mut parameters = coarse();
        parameters.boundary.friction = friction;
        let mut instance = Instance::new(&Model::new(parameters).unwrap(), 0.0).unwrap();
        move_to(&mut instance, DEPTH, 0.625);
        instance.outputs().force.to_bits()
    };
    assert_eq!(force(0.01), force(10.0));
}

/// Goal: no stage is accepted with forces out of balance. Set-up: P2's ramp, hold and unloading in steps of 10 um,
/// through peeling, coarse mesh; steps are halved until they converge. Tolerance: `solver.newton_tolerance`, 1e-9 of
/// the force scale of 13 mN.
#[test]
fn residuals_are_below_the_tolerance_while_peeling() {
    let parameters = coarse();
    let sample = Sample::shared(&parameters.geometry, &parameters.mesh).unwrap();
    let mut stepper = Stepper::new(&parameters.setup(), sample);
    let mut state = stepper.undeformed(0.0);
    let (mut at, mut opened, mut statistics) = (0.0, false, Statistics::default());
    for (to, velocity, largest) in [(DEPTH, 1.6e-3, 1e-5), (DEPTH, 0.0, 5.0), (0.0, -1e-3, 1e-5)] {
        let mut left: f64 = if velocity == 0.0 { 90.0 } else { (to - at) / velocity };
        while left > 1e-9 && state.contact.any() {
            let mut dt = left.min(if velocity == 0.0 { largest } else { largest / velocity.abs() });
            state = loop {
                let motion = Motion { start: at, velocity };
                match stepper.step(&state, motion, dt, Patience::Little, &mut statistics) {
                    Ok(next) => break next.state,
                    Err(reason) => assert!(dt > 1e-7, "{at}: {reason}"),
                }
                dt *= 0.5;
            };
            let residual = *stepper.residual_norms().last().unwrap();
            assert!(residual <= parameters.solver.newton_tolerance, "{at}: {residual:e}");
            at += velocity * dt;
            left -= dt;
            opened |= state.contact.corners().contains(&Status::Open);
        }
    }
    assert!(opened && !state.contact.any());
}

/// Goal: six cycles cost six times the first one. Set-up: iterations of P2 on the coarse mesh, with the
/// built-in trapezoids, with the displacements of the shipped test as they are, and with noise of 1 um rms on them.
/// Tolerance: a tenth around the 6.1 that is seen; 8 is the aim.
#[test]
#[ignore = "long: eight seconds"]
fn six_cycles_cost_six_times_the_first() {
    for (history, first, all) in costs(MeshPreset::Coarse) {
        let ratio = all as f64 / first as f64;
        assert!((ratio - 6.1).abs() < 0.6, "{history}: {all} iterations, {first} in the first cycle");
    }
}

/// Prints the same for the standard mesh.
#[test]
#[ignore = "long: prints the numbers of the README"]
fn cost_of_six_cycles() {
    for preset in [MeshPreset::Coarse, MeshPreset::Standard] {
        for (history, first, all) in costs(preset) {
            println!("{preset:?}, {history}: {first}, {all}, {:.2}", all as f64 / first as f64);
        }
    }
}

/// Newton iterations of the first cycle of P2 and of all six, by history.
fn costs(preset: MeshPreset) -> Vec<(&'static str, u64, u64)> {
    let file =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/measurement/table1-six-cycles/P2.csv");
    let measured = read(&file, Wanted::Motion).unwrap();
    let mut noisy = measured.clone();
    let mut state = 1_u64;
    for d in &mut noisy.displacement_m {
        // Sum of twelve uniform numbers: a normal one.
        let mut normal = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            normal += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        *d += 1e-6 * normal;
    }
    let histories = [
        ("trapezoids", Trapezoid { cycles: 6, ..Trapezoid::p2() }.protocol().unwrap()),
        ("measured", protocol_of(&measured).unwrap()),
        ("noisy", protocol_of(&noisy).unwrap()),
    ];
    let second = Trapezoid::p2().protocol().unwrap().end_time();
    let cost = |(name, protocol): (&'static str, Protocol)| {
        let mut parameters = coarse();
        parameters.mesh.preset = preset;
        let (start, gap) = protocol.points()[0];
        let mut instance = Instance::new(&Model::new(parameters).unwrap(), gap.min(0.0)).unwrap();
        let mut first = 0;
        for &(time, displacement) in &protocol.points()[1..] {
            arrive(&mut instance, displacement, time - start);
            if time - start <= second + 0.5 {
                first = instance.statistics().iterations;
            }
        }
        (name, first, instance.statistics().iterations)
    };
    histories.into_iter().map(cost).collect()
}

/// Follows a protocol with multiples of a parameter; what fails, or pulls at the sample.
fn vary(
    name: &str,
    change: fn(&mut Parameters, f64),
    factors: &[f64],
    trapezoid: Trapezoid,
    preset: MeshPreset,
) -> Vec<String> {
    let mut failures = Vec::new();
    for &factor in factors {
        let mut parameters = coarse();
        parameters.mesh.preset = preset;
        change(&mut parameters, factor);
        let case = format!("{preset:?}, {} cycles, {name} x {factor}", trapezoid.cycles);
        match try_follow(&parameters, &trapezoid.protocol().unwrap(), 5) {
            Ok(results) => {
                let least = results.iter().map(|r| r.1.force).fold(0.0, f64::min);
                println!("{case}: done");
                failures.extend((least < -1e-7).then(|| format!("{case}: pull of {least} N")));
            }
            Err(reason) => {
                println!("{case}: {reason}");
                failures.push(format!("{case}: {reason}"));
            }
        }
    }
    failures
}

const BY_HALF: [f64; 2] = [0.5, 1.5];

fn wide(name: &str) -> &'static [f64] {
    match name {
        "lambda*" => &[3e-3, 5e-3, 1e-2, 3e-2, 0.1, 1.0, 10.0],
        "radius" | "sample radius" | "sample height" | "friction" => &[],
        _ => &[1.0 / 3.0, 3.0],
    }
}

const QUICK: [&str; 3] = ["G_1", "eta_2", "radius"];

type Change = (&'static str, fn(&mut Parameters, f64));
const CHANGES: &[Change] = &[
    ("n0S", |p, f| p.material.n0s *= f),
    ("lambda*", |p, f| p.material.lambda_star *= f),
    ("K0", |p, f| p.material.permeability *= f),
    ("G_inf", |p, f| p.material.equilibrium.mu *= f),
    ("alpha_inf", |p, f| p.material.equilibrium.alpha *= f),
    ("G_1", |p, f| p.material.branches[0].ogden.mu *= f),
    ("alpha_1", |p, f| p.material.branches[0].ogden.alpha *= f),
    ("eta_1", |p, f| p.material.branches[0].eta *= f),
    ("G_2", |p, f| p.material.branches[1].ogden.mu *= f),
    ("alpha_2", |p, f| p.material.branches[1].ogden.alpha *= f),
    ("eta_2", |p, f| p.material.branches[1].eta *= f),
    ("radius", |p, f| p.geometry.punch_radius *= f),
    ("sample radius", |p, f| p.geometry.sample_radius *= f),
    ("sample height", |p, f| p.geometry.sample_height *= f),
    ("friction", |p, f| p.boundary.friction *= f),
];
