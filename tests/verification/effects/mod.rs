//! The catalogue of effects: null, plausible scale, states; one file per place for the laws themselves.

mod adhesion;
mod contact;
mod machine;
mod permeability;
mod recipe;
mod sensitivities;
mod sensor;
mod specimen;

use poropunch::cosimulation::{Slave, SlaveState};
use poropunch::effect::{CATALOGUE, Course, Variant};
use poropunch::parameters::MeshKind;
use poropunch::variables::{Kind, Settings, Value, by_name};
use poropunch::{Instance, Model, Outputs, ParameterError, Parameters};
use tests::{arrive, check_restored, move_to, ramp_and_hold};

/// Gap at the start (m), loading rate of P2 (m/s), depth (m).
const GAP: f64 = 1e-4;
const RATE: f64 = 1.6e-3;
const DEPTH: f64 = 1e-3;
/// End of the ramp (s).
const RAMP: f64 = (GAP + DEPTH) / RATE;
/// Times of [`curve`] (s).
const TIMES: [f64; 8] = [0.03, 0.2, 0.5, RAMP, RAMP + 0.03, RAMP + 1.0, RAMP + 10.0, RAMP + 90.0];

/// Position of the punch in P2's first cycle (m).
fn position(time: f64) -> f64 {
    (-GAP + RATE * time).min(DEPTH)
}

/// Table 1 on the coarse mesh with some variables set by name; Booleans 0 or 1.
pub fn parameters(values: &[(&str, f64)]) -> Parameters {
    let mut settings = Settings::default();
    for &(name, value) in [("mesh.preset", 1.0)].iter().chain(values) {
        let (_, variable) = by_name(name).unwrap_or_else(|| panic!("{name}"));
        let value = match variable.kind {
            Kind::Real { .. } => Value::Real(value),
            Kind::Boolean => Value::Boolean(value != 0.0),
            _ => Value::Integer(value as i32),
        };
        variable.set(&mut settings, value).unwrap();
    }
    settings.parameters()
}

/// Results of P2's first cycle at [`TIMES`].
fn curve(parameters: &Parameters) -> Vec<Outputs> {
    curve_at(parameters, &TIMES)
}

fn curve_at(parameters: &Parameters, times: &[f64]) -> Vec<Outputs> {
    let mut instance = Instance::new(&Model::new(parameters.clone()).unwrap(), -GAP).unwrap();
    ramp_and_hold(&mut instance, RAMP, position, times)
}

/// Results while the punch leaves, which alone adhesion changes.
fn retraction(parameters: &Parameters) -> Vec<Outputs> {
    let mut instance = Instance::new(&Model::new(parameters.clone()).unwrap(), 0.0).unwrap();
    move_to(&mut instance, DEPTH, DEPTH / RATE);
    let mut go = |k: i32| {
        move_to(&mut instance, DEPTH * (1.0 - 0.1 * f64::from(k)), 0.1);
        instance.outputs()
    };
    (1..=15).map(&mut go).collect()
}

/// Largest difference of the forces (N).
fn distance(a: &[Outputs], b: &[Outputs]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a.force - b.force).abs()))
}

fn at(variant: &Variant, magnitude: f64) -> Vec<(&'static str, f64)> {
    variant.settings.iter().map(|s| (s.parameter, s.at(magnitude))).collect()
}

fn variants() -> impl Iterator<Item = (String, &'static Variant)> {
    let name = |e: &str, v: &str| format!("{e}, {v}");
    CATALOGUE.iter().flat_map(move |e| e.variants.iter().map(move |v| (name(e.name, v.name), v)))
}

/// Softer and more permeable than Table 1, so that seepage is seen.
const SEEPING: [(&str, f64); 2] = [("material.lambda_star", 3e3), ("material.permeability", 1e-12)];

/// Variants of seepage, for which Table 1 is blind.
fn needs_seepage(name: &str) -> bool {
    ["permeability", "drained_punch", "drainage"].iter().any(|e| name.starts_with(e))
}

/// Goal: with every parameter of every effect set to its null, the model is the plain one.
/// Tolerance: none, bit for bit.
#[test]
fn null_is_the_plain_model() {
    let plain = curve(&parameters(&[]));
    // The mesh is the test's own.
    let null: Vec<_> = variants()
        .flat_map(|(_, v)| at(v, 0.0))
        .filter(|(name, _)| !name.starts_with("mesh.") && *name != "material.branch[3].eta")
        .chain([("effect.softening.strain", 0.05), ("effect.softening.delay", 3.0)])
        .collect();
    assert!(null.len() > 15);
    assert_eq!(plain, curve(&parameters(&null)));
}

/// Goal: the plain model is the limit of every effect's own code. Set-up: every continuous effect at a
/// thousand-millionth of its plausible scale. Tolerance: 1e-5 mN, of the solver's tolerances.
#[test]
fn null_is_the_limit_of_small_effects() {
    let plain = curve(&parameters(&[]));
    for (name, variant) in variants().filter(|(_, v)| !v.is_switch()) {
        let small = curve(&parameters(&at(variant, 1e-9)));
        assert!(distance(&plain, &small) < 1e-8, "{name}: {:e} N", distance(&plain, &small));
    }
}

/// Goal: every effect does something at its plausible scale, and less at half of it. Set-up: P2's first cycle;
/// effects of seepage on a skeleton that seeps. Tolerance: at least 1e-3 mN somewhere.
#[test]
#[ignore = "long: three cycles for each effect"]
fn plausible_scales_matter() {
    for (name, variant) in variants() {
        let mut plain = if needs_seepage(&name) { SEEPING.to_vec() } else { Vec::new() };
        if variant.settings.iter().any(|s| s.parameter == "mesh.preset") {
            plain.push(("mesh.preset", 2.0));
        }
        let with = |magnitude: f64| {
            let values: Vec<_> = plain.iter().copied().chain(at(variant, magnitude)).collect();
            if name.starts_with("adhesion") {
                retraction(&parameters(&values))
            } else {
                curve(&parameters(&values))
            }
        };
        let (null, whole) = (with(0.0), with(1.0));
        let effect = distance(&null, &whole);
        assert!(effect > 1e-6, "{name}: {effect:e} N");
        // The estimate of the time error is no measure of this kind.
        let monotone = !variant.is_switch() && !name.starts_with("discretisation");
        if monotone {
            let half = distance(&null, &with(0.5));
            assert!(half > 0.2 * effect && half < effect, "{name}: {half:e}, {effect:e} N");
        }
    }
}

/// All effects together that can be.
fn everything() -> Vec<(&'static str, f64)> {
    vec![
        ("effect.eyring.inverse_stress", 5e-3),
        ("effect.permeability.exponent", 5.0),
        ("effect.softening.loss", 0.3),
        ("effect.modulus_drift.rate", 1e-3),
        ("effect.amplitude.log_factor", -0.2),
        ("effect.slip.compliance", 1e-6),
        ("effect.adhesion.strength", 100.0),
        ("effect.offset.height", 5e-5),
        ("effect.compliance.per_newton", 5e-3),
        ("effect.load_cell_drift.rate", 1e-5),
        ("effect.load_cell_lag.time", 0.05),
    ]
}

/// Goal: with all effects on, what is read does not depend on how a master slices time.
/// Set-up: ramp and 10 s of hold in 1, 7 and 200 communication steps each. Tolerance: 1e-9.
#[test]
fn communication_steps_do_not_matter() {
    let model = Model::new(parameters(&everything())).unwrap();
    let sliced = |slices: usize| {
        let mut instance = Instance::new(&model, -GAP).unwrap();
        let mut forces = [0.0; 2];
        for (phase, end) in [RAMP, RAMP + 10.0].into_iter().enumerate() {
            let start = instance.time();
            for k in 1..=slices {
                let time = start + (end - start) * k as f64 / slices as f64;
                arrive(&mut instance, position(time), time);
            }
            forces[phase] = instance.outputs().force;
        }
        forces
    };
    let one = sliced(1);
    for slices in [7, 200] {
        for (a, b) in one.iter().zip(sliced(slices)) {
            approx::assert_relative_eq!(*a, b, max_relative = 1e-9);
        }
    }
}

/// Goal: with all effects on, saving and restoring is bit-identical, in another instance too; a state of the
/// plain model, which has no past strains, is refused.
#[test]
fn restored_runs_are_bit_identical() {
    let model = Model::new(parameters(&everything())).unwrap();
    let outputs = |o: &Outputs| vec![o.force, o.force_specimen, o.force_fluid, o.stored_energy];
    let snapshot = check_restored(&model, [-GAP, -GAP], outputs);
    let mut plain = Instance::new(&Model::new(parameters(&[])).unwrap(), -GAP).unwrap();
    assert_eq!(plain.restore(&snapshot), Err(ParameterError::ForeignSnapshot));
}

/// Goal: what cannot be computed is refused by name: sensitivities with an effect that says so, effects inside
/// the specimen in three dimensions, values out of range, slip of a punch that is not bonded.
#[test]
fn refusals() {
    for (name, variant) in variants() {
        let mut values = at(variant, 1.0);
        values.push(("solver.sensitivities", 1.0));
        let built = Model::new(parameters(&values));
        assert_eq!(built.is_ok(), variant.differentiable, "{name}");
        if !variant.differentiable {
            assert!(matches!(built, Err(ParameterError::NoSensitivities(_))), "{name}");
        }
        let own =
            variant.settings.iter().any(|s| s.parameter.starts_with("effect.") && s.course != Course::Switch);
        if own {
            let mut values = parameters(&at(variant, 1.0));
            values.mesh.kind = MeshKind::Paper3d;
            let inside = !["offset", "load_cell"].iter().any(|e| name.starts_with(e));
            let refused = values.validate();
            assert_eq!(matches!(refused, Err(ParameterError::NotIn3d(_))), inside, "{name}: {refused:?}");
        }
    }
    let mut bad = Parameters::default();
    bad.effect.load_cell_lag.time = -1.0;
    assert!(matches!(bad.validate(), Err(ParameterError::OutOfRange { .. })));
    bad.effect.load_cell_lag.time = f64::NAN;
    assert!(matches!(bad.validate(), Err(ParameterError::OutOfRange { .. })));
    let sliding = parameters(&[("effect.slip.compliance", 1e-6), ("boundary.bonded_punch", 0.0)]);
    assert!(matches!(sliding.validate(), Err(ParameterError::Contradiction(..))));
}

/// Goal: the co-simulation slave knows the effects by name; its serialised state, written in the middle of a
/// step that was integrated ahead, goes on bit-identically in another slave; in air the load cell drifts.
#[test]
fn serialised_states_go_on() {
    let mut slave = Slave::new();
    let reference = |name: &str| by_name(name).unwrap().0;
    let mut values: Vec<_> = everything().into_iter().map(|(n, v)| (reference(n), Value::Real(v))).collect();
    values.push((reference("mesh.preset"), Value::Integer(1)));
    values.push((reference("protocol.source"), Value::Integer(2)));
    values.push((reference("protocol.start_gap"), Value::Real(GAP)));
    slave.set(&values).unwrap();
    let real = |slave: &Slave, name: &str| match slave.get(reference(name)).unwrap() {
        Value::Real(value) => value,
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(real(&slave, "indentation"), real(&slave, "punch_displacement") + 5e-5);
    slave.initialise(5.0).unwrap();
    slave.step(5.0, 0.02).unwrap();
    assert_eq!(real(&slave, "force_specimen"), 0.0);
    approx::assert_relative_eq!(real(&slave, "force"), 0.02 * 1e-5, max_relative = 1e-12);
    slave.step(5.02, 0.3).unwrap();
    let (state, _) = SlaveState::from_bytes(&slave.save().to_bytes(&[]).unwrap()).unwrap();
    let mut other = Slave::new();
    other.restore(&state).unwrap();
    for k in 0..10 {
        let time = 5.32 + 0.07 * f64::from(k);
        slave.step(time, 0.07).unwrap();
        other.step(time, 0.07).unwrap();
        for name in ["force", "force_specimen", "force_fluid", "indentation"] {
            assert_eq!(real(&slave, name).to_bits(), real(&other, name).to_bits(), "{name} at {time}");
        }
    }
    assert!(real(&slave, "force_specimen") > 0.0);
}
