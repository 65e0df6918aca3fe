//! The engine and the independent solver of `challenge make`: the same plain model by two programs that share no code.

use runner::challenge::by_engine::ByEngine;
use runner::challenge::by_maker::ByMaker;
use runner::challenge::draw::{Drawn, Kind, draw};
use runner::challenge::ground::Ground;
use runner::challenge::simulate::{Source as _, Test, tests};
use runner::engine::{Engine, EngineOptions};
use std::collections::BTreeMap;
use std::time::Instant;

/// Nobody stops these runs.
fn never() -> bool {
    false
}

/// Largest difference (% of the peak) in each test without any cause.
fn differences(engine: &Engine, drawn: &Drawn, tests: &[Test; 2], preset: f64) -> [f64; 2] {
    let numerics = BTreeMap::from([("mesh.preset".to_owned(), preset)]);
    let by_engine = ByEngine { engine, numerics: &numerics };
    let plain = [vec![]];
    let model = by_engine.readings_n(&drawn.material, &plain, tests, 1.0).unwrap();
    let maker = ByMaker::new(0, &never).unwrap().readings_n(&drawn.material, &plain, tests, 1.0).unwrap();
    [0, 1].map(|test| {
        let (ours, theirs) = (&model[0][test], &maker[0][test]);
        let peak = ours.iter().copied().fold(0.0, f64::max);
        let off = |k: &usize| 100.0 * (theirs[*k] - ours[*k]) / peak;
        let worst = (0..ours.len()).max_by(|a, b| off(a).abs().total_cmp(&off(b).abs())).unwrap();
        println!(
            "  {} peak {:9.4} mN, largest difference {:+7.3} % at {:7.2} s, at the end {:+7.3} %",
            tests[test].name,
            1e3 * peak,
            off(&worst),
            tests[test].time_s[worst],
            off(&(ours.len() - 1))
        );
        off(&worst).abs()
    })
}

/// Goal: a null case of the wide ground is the plain model, whichever program computes it. Set-up: drawn materials, both protocols.
/// Criterion: within `most` % of the peak at every sample.
fn nulls_agree(seed: u64, cases: usize, cycles: i32, most: f64) {
    let engine = Engine::new(&EngineOptions::default()).unwrap();
    let tests = tests(cycles).unwrap();
    let mut worst = 0.0f64;
    for drawn in draw(seed, cases, &[Kind::Null], Ground::Wide) {
        println!("{} {}", drawn.id, materials(&drawn));
        worst = differences(&engine, &drawn, &tests, 2.0).into_iter().fold(worst, f64::max);
    }
    assert!(worst < most, "{worst} % of the peak");
}

/// Parameters as `--set` takes them.
fn materials(drawn: &Drawn) -> String {
    drawn.material.iter().map(|(name, value)| format!("--set {name}={value:.4e} ")).collect()
}

#[test]
#[ignore = "long: two programs, twelve materials"]
fn nulls_of_one_cycle_agree() {
    nulls_agree(4001, 12, 1, 0.35);
}

#[test]
#[ignore = "long: two programs, three materials, three cycles"]
fn nulls_of_three_cycles_agree() {
    nulls_agree(4002, 3, 3, 0.5);
}

/// Goal: what is drawn can nearly always be computed, so that no kind of case is missing. Set-up: 60 draws of all kinds, one cycle.
/// Criterion: at most 3 fail.
#[test]
#[ignore = "long: sixty cases by the independent solver"]
fn draws_of_the_wide_ground_are_computable() {
    let tests = tests(1).unwrap();
    let maker = ByMaker::new(0, &never).unwrap();
    let mut failed = 0;
    for drawn in draw(4003, 60, &[], Ground::Wide) {
        let start = Instant::now();
        let made = maker.readings_n(&drawn.material, std::slice::from_ref(&drawn.causes), &tests, 1.0);
        let wall = start.elapsed().as_secs_f64();
        println!("{wall:6.1} s {:?} {:?}", drawn.kind, drawn.causes);
        if let Err(e) = made {
            failed += 1;
            println!("  FAILED {e}: {}", materials(&drawn));
        }
    }
    assert!(failed <= 3, "{failed} of 60");
}
