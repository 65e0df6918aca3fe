//! How good starts from the data are: materials drawn at random, tests of them computed, noise added, starts read.
//!
//! `cargo run --release -p runner --example start_study -- 100 [fit]` draws a hundred materials (G_inf and two branches log-uniform
//! from 100 Pa to 1 MPa, tau from 0.01 to 1000 s, alpha from -12 to -1.5, lambda* from 3 to 300 instantaneous moduli, K0 over four
//! decades about the consolidation within the ramp), each under one of four indenters, with 0.3 to 3 % of noise, on `coarse`.
//! With `fit` each is fitted from that start and from the truth.

use runner::data::Measurement;
use runner::engine::{Engine, EngineOptions};
use runner::identification::{IdentificationError, identify};
use runner::inference::start::{Known, MOST_BRANCHES, Mentioned, Start};
use runner::inference::{Defaults, Requests, SearchPlan, Setup, Unknowns};
use runner::noise::{Observation, Weights};
use runner::pool::wiring::Names;
use runner::pool::{Job, Priority};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Uniform and normal numbers (SplitMix64, Box and Muller).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.uniform())
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Name, settings and depth (m) of a test.
type Rig = (&'static str, Vec<(&'static str, f64)>, f64);

/// Geometry and depth (m) of each indenter.
fn rigs() -> [Rig; 4] {
    [
        ("flat", vec![], 1e-3),
        ("sphere", vec![("indenter.profile", 2.0), ("indenter.sphere_radius", 4e-3)], 1e-3),
        ("cone", vec![("indenter.profile", 3.0)], 1e-3),
        (
            "platen",
            vec![
                ("geometry.punch_radius", 3e-3),
                ("geometry.sample_radius", 3e-3),
                ("geometry.sample_height", 4e-3),
            ],
            4e-4,
        ),
    ]
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let count: usize = arguments.get(1).and_then(|n| n.parse().ok()).unwrap_or(100);
    let fits = arguments.get(2).is_some_and(|a| a == "fit");
    let names = Names { sensitivities: true, ..Names::default() };
    let engine = Engine::new(&EngineOptions { names, ..EngineOptions::default() }).expect("the FMU");
    let mut random = Random(1);
    let mut near = Vec::new();
    println!("case,rig,tau_1,tau_2,failed,branches,log10 G_inf,log10 G_0 seen,chi ratio,iterations");
    for case in 0..count {
        let (rig, geometry, depth) = rigs()[case % 4].clone();
        let shear = [(); 3].map(|()| random.log(1e2, 1e6));
        let mut tau = [(); 2].map(|()| random.log(1e-2, 1e3));
        tau.sort_by(f64::total_cmp);
        let alpha = [(); 3].map(|()| -random.log(1.5, 12.0));
        let lambda = shear.iter().sum::<f64>() * random.log(3.0, 300.0);
        let (ramp, hold) = (random.log(0.3, 3.0), 300.0);
        let k0 = 0.89e-3 * 4e-6 / (lambda * ramp) * random.log(1e-2, 1e2);
        let noise = random.log(3e-3, 3e-2);
        let mut truth: BTreeMap<String, f64> = BTreeMap::from([
            ("material.equilibrium.mu".into(), 2.0 * shear[0] / alpha[0]),
            ("material.equilibrium.alpha".into(), alpha[0]),
            ("material.lambda_star".into(), lambda),
            ("material.permeability".into(), k0),
        ]);
        for i in 0..2 {
            let name = |leaf| format!("material.branch[{}].{leaf}", i + 1);
            truth.insert(name("mu"), 2.0 * shear[i + 1] / alpha[i + 1]);
            truth.insert(name("alpha"), alpha[i + 1]);
            truth.insert(name("eta"), shear[i + 1] * tau[i]);
        }
        let mut set: BTreeMap<String, f64> = BTreeMap::from([("mesh.preset".into(), 1.0)]);
        set.extend(geometry.iter().map(|(name, value)| ((*name).to_owned(), *value)));
        let path = vec![(0.0, 0.0), (ramp, depth), (ramp + hold, depth)];
        let mut time_s: Vec<f64> = (0..60).map(|k| ramp * f64::from(k) / 60.0).collect();
        time_s.extend((0..200).map(|k| ramp + 5e-3 * (hold / 5e-3).powf(f64::from(k) / 199.0)));
        let protocol = Arc::new(poropunch::motion::protocol::Protocol::new(path).expect("a motion"));
        let parameters = set.clone().into_iter().chain(truth.clone()).collect();
        let job = Job { parameters, protocol: Arc::clone(&protocol), time_s: time_s.clone().into() };
        let Ok(curve) = engine.submit(&job, Priority::Urgent).wait() else {
            println!("{case},{rig},{:.3},{:.3},yes", tau[0], tau[1]);
            continue;
        };
        let peak = curve.force_n().iter().copied().fold(0.0, f64::max);
        let sigma = noise * peak;
        let force_n: Vec<f64> = curve.force_n().iter().map(|f| f + sigma * random.normal()).collect();
        let displacement_m = time_s.iter().map(|t| protocol.displacement(*t)).collect();
        let spread_n = Some(vec![sigma; time_s.len()]);
        let m = Measurement { time_s, displacement_m, force_n, spread_n, ..Measurement::default() };
        let default = |name: &str| engine.wiring().parameters.get(name)?.start_number();
        let known = Known::of(&|name| set.get(name).copied().or_else(|| default(name))).expect("a rig");
        let Some(start) = Start::of(&[&m], &known, 1..=MOST_BRANCHES) else {
            println!("{case},{rig},{:.3},{:.3},no start", tau[0], tau[1]);
            continue;
        };
        let seen = |start: &[f64]| start.iter().sum::<f64>();
        // What is slower than the hold is equilibrium, what is faster than a hundredth of the ramp is not seen.
        let slow: f64 = (0..2).filter(|i| tau[*i] > hold).map(|i| shear[i + 1]).sum();
        let fast: f64 = (0..2).filter(|i| tau[*i] > 0.1 * ramp).map(|i| shear[i + 1]).sum();
        let lasting: Vec<f64> =
            start.branches.iter().filter(|b| b.tau_s > hold).map(|b| b.shear_pa).collect();
        let quick: Vec<f64> =
            start.branches.iter().filter(|b| b.tau_s > 0.1 * ramp).map(|b| b.shear_pa).collect();
        let long = ((start.equilibrium_pa + seen(&lasting)) / (shear[0] + slow)).log10();
        let instant = ((start.equilibrium_pa + seen(&quick)) / (shear[0] + fast)).log10();
        near.push((long, instant));
        let ratio = if fits { compared(&engine, &m, &start, &set, &truth) } else { Ok((f64::NAN, 0)) };
        let (ratio, iterations) = ratio.unwrap_or((f64::INFINITY, 0));
        println!(
            "{case},{rig},{:.3},{:.3},no,{},{long:.2},{instant:.2},{ratio:.4},{iterations}",
            tau[0],
            tau[1],
            start.branches.len()
        );
    }
    let within = |of: fn(&(f64, f64)) -> f64, f: f64| near.iter().filter(|e| of(e).abs() < f.log10()).count();
    println!(
        "of {} starts: long-term modulus within a factor of 1.5: {}, 3: {}; instantaneous 1.5: {}, 3: {}",
        near.len(),
        within(|e| e.0, 1.5),
        within(|e| e.0, 3.0),
        within(|e| e.1, 1.5),
        within(|e| e.1, 3.0)
    );
}

/// chi^2 of the fit from the data's start over that of the fit from the truth, and the former's iterations.
fn compared(
    engine: &Engine,
    m: &Measurement,
    start: &Start,
    set: &BTreeMap<String, f64>,
    truth: &BTreeMap<String, f64>,
) -> Result<(f64, usize), IdentificationError> {
    let none = Mentioned { free: false, lambda_star: false, branch: 0 };
    let told = start.defaults(none);
    let mut known = told.clone();
    known.fixed = (3..=MOST_BRANCHES).map(|n| (format!("material.branch[{n}].mu"), 0.0)).collect();
    known.free = truth.keys().cloned().collect();
    let wide = |value: f64| [value / 316.0, value * 316.0];
    let bounds = |name: &str, v: f64| match wide(v) {
        _ if name.ends_with("alpha") => [-30.0, -1.0],
        [a, b] => [a.min(b), a.max(b)],
    };
    known.start = truth.iter().map(|(n, v)| (n.clone(), (*v, bounds(n, *v)))).collect();
    let fit = |mut defaults: Defaults| {
        defaults.fixed.extend(set.clone());
        if !defaults.free.contains(&"material.lambda_star".to_owned()) {
            let lambda = "material.lambda_star".to_owned();
            defaults.free.push(lambda.clone());
            let value = truth[&lambda].max(10.0 * start.instantaneous_pa());
            defaults.start.insert(lambda, (value, wide(value)));
        }
        let requests = Requests { defaults, ..Requests::default() };
        let map = Unknowns::new(engine.wiring(), true, &requests).map_err(|e| e.to_string()).expect("a map");
        let data = vec![Observation::new(m, None).expect("data")];
        let plan = SearchPlan { starts: 1, seed: 1, evaluations: 60 };
        identify(Setup::new(engine, &data, &map), &Weights::default(), &plan, false, &mut |_, _| {})
    };
    let (told, known) = (fit(told)?, fit(known)?);
    let (told, known) = (&told.found.fit.solution, &known.found.fit.solution);
    Ok((told.chi_square / known.chi_square, told.iteration_count()))
}
