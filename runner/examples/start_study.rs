//! How good starts from the data are: materials drawn at random, tests of them computed, noise added, starts read.
//!
//! `cargo run --release -p runner --example start_study -- 100 [fit]` draws a hundred materials (G_inf and two branches log-uniform
//! from 100 Pa to 1 MPa, tau from 0.01 to 1000 s, alpha from -12 to -1.5, lambda* from 3 to 300 instantaneous moduli, K0 over four
//! decades about the consolidation within the ramp), each under one of four indenters, with 0.3 to 3 % of noise, on `coarse`.
//! Every other round of indenters is measured on six specimens whose heights scatter by 10 %. With `fit` each is fitted from that
//! start and from the truth, and counted: chi^2 within 1 % of that of the same model begun at the truth (two branches that are fitted by
//! one: at what they are together); determined combinations inside their 95 % intervals; iterations; fits without an answer; numbers of
//! branches that are right, or which the data do not tell from it: chi^2 of the data against the model of two branches begun at the truth.
//! A third argument `N` begins at case N: the random numbers are those of a run from the beginning.

use runner::data::Measurement;
use runner::engine::{Engine, EngineOptions};
use runner::identification::IdentificationError;
use runner::inference::derived::{estimate, material_quantities};
use runner::inference::fit::search;
use runner::inference::start::{Known, MOST_BRANCHES, Mentioned, Start};
use runner::inference::statistics::Determination;
use runner::inference::valley::bends;
use runner::inference::{
    Defaults, Requests, Resolution, SearchPlan, Setup, Statistics, Unknowns, Values, noise_at_start,
};
use runner::noise::{Covariance, Observation, Weights};
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
    let first: usize = arguments.get(3).and_then(|n| n.parse().ok()).unwrap_or(0);
    let names = Names { sensitivities: true, ..Names::default() };
    let engine = Engine::new(&EngineOptions { names, ..EngineOptions::default() }).expect("the FMU");
    let mut random = Random(1);
    let (mut near, mut fitted) = (Vec::new(), Vec::new());
    println!(
        "case,rig,specimens,tau_1,tau_2,noise,failed,branches,log10 G_inf,log10 G_0 seen,chi^2,chi^2 from truth,of data,with two branches,iterations,converged,inside,determined,outside"
    );
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
        let displacement_m = time_s.iter().map(|t| protocol.displacement(*t)).collect();
        let mut m = Measurement { time_s, displacement_m, ..Measurement::default() };
        // The same noise of the mean, by specimens of different heights or by a known deviation.
        let specimens = if case / 4 % 2 == 1 { SPECIMENS } else { 0 };
        for k in 0..specimens {
            let factor = (SCATTER * random.normal()).exp();
            let own = sigma * (specimens as f64).sqrt();
            let values = curve.force_n().iter().map(|f| factor * f + own * random.normal()).collect();
            m.specimens_n.push(values);
            m.specimen_names.push(format!("s{k}"));
        }
        if specimens == 0 {
            m.force_n = curve.force_n().iter().map(|f| f + sigma * random.normal()).collect();
            m.spread_n = Some(vec![sigma; m.time_s.len()]);
        } else {
            let mean = |i: usize| m.specimens_n.iter().map(|s| s[i]).sum::<f64>() / specimens as f64;
            m.force_n = (0..m.time_s.len()).map(mean).collect();
        }
        if case < first {
            continue;
        }
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
        print!("{case},{rig},{specimens},{:.3},{:.3},{noise:.4},no", tau[0], tau[1]);
        print!(",{},{long:.2},{instant:.2}", start.branches.len());
        if fits {
            let fit = compared(&engine, &m, &start, &set, &truth);
            match &fit {
                Ok(f) => print!(
                    ",{:.1},{:.1},{:.1},{:.1},{},{},{},{},{}",
                    f.told,
                    f.from_truth,
                    f.of_data,
                    f.with_two_branches,
                    f.iterations,
                    f.converged,
                    f.inside,
                    f.determined,
                    f.outside.join(" ")
                ),
                Err(error) => print!(",,,,,,no answer,,,{error}"),
            }
            fitted.push(fit.ok());
        }
        println!();
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
    if fits {
        summarise(&fitted);
    }
}

/// Specimens of a case that has some, and the deviation of the logarithms of their heights.
const SPECIMENS: usize = 6;
const SCATTER: f64 = 0.1;
/// chi^2 of so many deviations more than with the true branches tells the branches apart: 95 % quantile of three parameters.
const TELLS_A_BRANCH: f64 = 7.81;

/// A fit from the data's start beside the one from the truth.
struct Compared {
    /// chi^2 from the data's start, and of the same model from the truth.
    told: f64,
    from_truth: f64,
    /// chi^2 of the data alone, and that of two branches begun at the truth.
    of_data: f64,
    with_two_branches: f64,
    branches: usize,
    iterations: usize,
    converged: bool,
    /// Determined combinations, those inside their intervals, and the names of the others.
    determined: usize,
    inside: usize,
    outside: Vec<String>,
}

fn summarise(fitted: &[Option<Compared>]) {
    let found: Vec<&Compared> = fitted.iter().flatten().collect();
    let count = |of: &dyn Fn(&Compared) -> bool| found.iter().filter(|f| of(f)).count();
    let mut iterations: Vec<usize> = found.iter().map(|f| f.iterations).collect();
    iterations.sort_unstable();
    let (inside, determined) = found.iter().fold((0, 0), |(i, d), f| (i + f.inside, d + f.determined));
    let told = |f: &Compared| f.branches == 2 || f.of_data < f.with_two_branches + TELLS_A_BRANCH;
    println!(
        "of {}: without an answer {}, not converged {}; chi^2 within 1 % of the same model from the truth {}; median of the iterations {}; \
         combinations inside {inside} of {determined}; branches right or not told apart {}",
        fitted.len(),
        fitted.len() - found.len(),
        count(&|f| !f.converged),
        count(&|f| f.told < 1.01 * f.from_truth),
        iterations.get(iterations.len() / 2).copied().unwrap_or(0),
        count(&told)
    );
}

/// What a quantity of the fit stands for: of moduli all that relaxes within its scope, of a time the mean of these by modulus.
fn true_value(name: &str, resolution: &Resolution, own: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
    let branch =
        |i: usize| Some((own(&format!("relaxation_time[{i}]"))?, own(&format!("shear_modulus[{i}]"))?));
    let all: Vec<(f64, f64)> = (1..=2).map(branch).collect::<Option<_>>()?;
    let within = |[from, to]: [f64; 2]| all.iter().filter(move |(tau, _)| (from..=to).contains(tau));
    if let Some(scope) = resolution.scope_s(name) {
        let sum: f64 = within(scope).map(|(_, shear)| shear).sum();
        let equilibrium = if scope[1].is_infinite() { own("shear_modulus[inf]")? } else { 0.0 };
        return Some(sum + equilibrium);
    }
    match resolution.branch_of(name) {
        Some(of) => {
            let sum: f64 = within(of.times_s()).map(|(_, shear)| shear).sum();
            Some((within(of.times_s()).map(|(tau, shear)| shear * tau.ln()).sum::<f64>() / sum).exp())
        }
        None => own(name),
    }
}

/// What two branches are together: their moduli's sum, which relaxes in their mean time by modulus.
fn together(truth: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let of = |i: usize, leaf: &str| truth[&format!("material.branch[{i}].{leaf}")];
    let shear = [1, 2].map(|i| 0.5 * of(i, "mu") * of(i, "alpha"));
    let log_tau = [1, 2].map(|i| (of(i, "eta") / shear[i - 1]).ln());
    let sum = shear[0] + shear[1];
    let tau = ((shear[0] * log_tau[0] + shear[1] * log_tau[1]) / sum).exp();
    let alpha = of(if shear[0] > shear[1] { 1 } else { 2 }, "alpha");
    let mut values = truth.clone();
    values.retain(|name, _| !name.starts_with("material.branch"));
    values.insert("material.branch[1].mu".into(), 2.0 * sum / alpha);
    values.insert("material.branch[1].alpha".into(), alpha);
    values.insert("material.branch[1].eta".into(), sum * tau);
    values
}

/// The same model begun at these values, as far as its bounds let it.
fn at_truth(told: &Defaults, values: &BTreeMap<String, f64>) -> Defaults {
    let mut begun = told.clone();
    for (name, (start, [lower, upper])) in &mut begun.start {
        if let Some(value) = values.get(name) {
            *start = value.clamp(*lower, *upper);
        }
    }
    begun
}

/// Fits from the data's start and from the truth.
fn compared(
    engine: &Engine,
    m: &Measurement,
    start: &Start,
    set: &BTreeMap<String, f64>,
    truth: &BTreeMap<String, f64>,
) -> Result<Compared, IdentificationError> {
    let branches = start.branches.len();
    let none = Mentioned { free: false, lambda_star: false, branch: 0 };
    let told = start.defaults(none);
    let mut known = told.clone();
    known.fixed = (3..=MOST_BRANCHES).map(|n| (format!("material.branch[{n}].mu"), 0.0)).collect();
    // In the order of the other fit, so that both are one problem where they free the same.
    known.free = told.free.iter().filter(|name| truth.contains_key(*name)).cloned().collect();
    known.free.extend(truth.keys().filter(|name| !told.free.contains(name)).cloned());
    let wide = |value: f64| [value / 316.0, value * 316.0];
    let bounds = |name: &str, v: f64| match wide(v) {
        _ if name.ends_with("alpha") => [-30.0, -1.0],
        [a, b] => [a.min(b), a.max(b)],
    };
    known.start = truth.iter().map(|(n, v)| (n.clone(), (*v, bounds(n, *v)))).collect();
    let data = vec![Observation::new(m, None).expect("data")];
    let map = |mut defaults: Defaults| {
        defaults.fixed.extend(set.clone());
        if !defaults.free.contains(&"material.lambda_star".to_owned()) {
            let lambda = "material.lambda_star".to_owned();
            defaults.free.push(lambda.clone());
            let value = truth[&lambda].max(10.0 * start.instantaneous_pa());
            defaults.start.insert(lambda, (value, wide(value)));
        }
        let requests = Requests { defaults, ..Requests::default() };
        Unknowns::new(engine.wiring(), true, &requests).map_err(|e| e.to_string()).expect("a map")
    };
    let fit = |map: &Unknowns, covariance: &Covariance, others: &[Vec<f64>]| {
        let plan = SearchPlan { starts: 1, seed: 1, others: others.to_vec(), evaluations: 60 };
        search(Setup::new(engine, &data, map), covariance, &plan, &mut |_, _| {})
    };
    let elsewhere = [map(start.clone().hardly_draining().defaults(none)).start().to_vec()];
    let begun_at_truth = at_truth(&told, &if branches == 1 { together(truth) } else { truth.clone() });
    let (told, known, begun_at_truth) = (map(told), map(known), map(begun_at_truth));
    let covariance = noise_at_start(Setup::new(engine, &data, &told), &Weights::default())?.covariance;
    let found = fit(&told, &covariance, &elsewhere)?.fit;
    let linear = Statistics::new(&told, &found, &[m.len()])?;
    let setup = Setup::new(engine, &data, &told);
    let bends = bends(setup, &found, &linear)?;
    let resolution = Resolution::of(setup, &found, &linear);
    let quantities = material_quantities(branches, &resolution);
    let true_quantities = material_quantities(2, &Resolution { branches: vec![], ..resolution.clone() });
    let statistics = linear.resolved(resolution).along(&told, &found.solution.x, bends);
    let derived = estimate(&quantities, &told, &found.solution.x, &statistics, &|_: &mut Values| {});
    let from_truth = fit(&begun_at_truth, &covariance, &[])?.fit.solution.chi_square;
    let of_data = statistics.chi_square;
    let with_two_branches = match branches {
        2 => of_data,
        _ => Statistics::new(&known, &fit(&known, &covariance, &[])?.fit, &[m.len()])?.chi_square,
    };
    let solution = found.solution;
    let values: Values = truth.iter().map(|(name, value)| (name.clone(), *value)).collect();
    let (mut inside, mut determined, mut outside) = (0, 0, Vec::new());
    for d in derived.iter().filter(|d| d.determination == Determination::Determined) {
        let own = |name: &str| {
            let quantity = true_quantities.iter().find(|q| q.name == name)?;
            (quantity.evaluate)(&values)
        };
        let Some(true_value) = true_value(&d.name, &statistics.resolution, &own) else { continue };
        determined += 1;
        if (d.interval.lower..=d.interval.upper).contains(&true_value) {
            inside += 1;
        } else {
            let far = (d.value / true_value).ln() / d.half_width;
            outside.push(format!("{} {far:.3} ({:.4e} for {true_value:.4e})", d.symbol, d.value));
        }
    }
    Ok(Compared {
        told: solution.chi_square,
        from_truth,
        of_data,
        with_two_branches,
        branches,
        iterations: solution.iteration_count(),
        converged: solution.stop.converged(),
        determined,
        inside,
        outside,
    })
}
