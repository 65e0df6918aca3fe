//! Snapshots of solver statistics: a loss of efficiency fails a test, without timing anything.

use poropunch::parameters::MeshPreset;
use poropunch::specimen::Sample;
use poropunch::{Instance, Model, Parameters, Statistics};
use tests::{DEPTH, move_to};

/// Counts differ a little between processors, whose vector instructions round differently.
const SLACK: f64 = 0.03;

fn parameters(preset: MeshPreset, sensitivities: bool) -> Parameters {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = preset;
    parameters.solver.sensitivities = sensitivities;
    parameters
}

fn cycle(parameters: Parameters) -> Statistics {
    let mut instance = Instance::new(&Model::new(parameters).unwrap(), -1e-4).unwrap();
    for (duration, displacement) in [(1.1 / 1.6, DEPTH), (90.0, DEPTH)] {
        move_to(&mut instance, displacement, duration);
    }
    instance.statistics()
}

#[track_caller]
fn at_most(name: &str, count: u64, snapshot: u64) {
    let limit = snapshot as f64 * (1.0 + SLACK);
    assert!(count as f64 <= limit, "{name}: {count}, it was {snapshot}");
    // A snapshot that is far too high would not notice a loss: it is to be lowered after a gain.
    assert!(
        count as f64 >= 0.8 * snapshot as f64,
        "{name}: {count} is much better than {snapshot}: lower it"
    );
}

/// Goal: P2's first cycle takes no more steps, iterations and factorisations than it did. Reference: counts of 2026-11-26.
#[test]
fn steps_and_iterations() {
    for (preset, steps, iterations, factorisations, cuts) in [
        (MeshPreset::Coarse, 68, 355, 153, 1),
        (MeshPreset::Standard, 69, 444, 181, 1),
        (MeshPreset::Fine, 69, 613, 256, 3),
    ] {
        let s = cycle(parameters(preset, false));
        at_most(&format!("steps, {preset:?}"), s.steps, steps);
        at_most(&format!("iterations, {preset:?}"), s.iterations, iterations);
        at_most(&format!("factorisations, {preset:?}"), s.factorisations, factorisations);
        assert!(s.cuts <= cuts, "{preset:?}: {} steps cut", s.cuts);
    }
}

/// Goal: sensitivities cost one more factorisation per stage of the two-stage scheme and no iteration.
#[test]
fn sensitivities_cost_one_factorisation_per_stage() {
    let plain = cycle(parameters(MeshPreset::Coarse, false));
    let with = cycle(parameters(MeshPreset::Coarse, true));
    assert_eq!((with.steps, with.iterations), (plain.steps, plain.iterations));
    // Repeated steps and those that only lead to a change of velocity are not among the accepted ones.
    let (extra, stages) = (with.factorisations - plain.factorisations, 2 * plain.steps);
    assert!((stages..=stages + 2 * (plain.cuts + 2)).contains(&extra), "{extra} for {stages} stages");
}

/// Goal: the ordering keeps fill and work low. Reference: counts of 2026-11-21, the same on every processor.
#[test]
fn fill_of_the_factors() {
    for (preset, factor_entries, largest_front) in FILL {
        let p = parameters(preset, false);
        let s = Sample::shared(&p.geometry, &p.mesh).unwrap().structure.statistics();
        at_most(&format!("factor entries, {preset:?}"), s.factor_entries as u64, factor_entries);
        at_most(&format!("largest front, {preset:?}"), s.largest_front as u64, largest_front);
    }
}

/// Numbers in the factors and order of the largest front.
const FILL: [(MeshPreset, u64, u64); 3] =
    [(MeshPreset::Coarse, 62_212, 77), (MeshPreset::Standard, 103_010, 92), (MeshPreset::Fine, 223_777, 126)];
