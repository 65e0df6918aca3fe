//! Simulation-based calibration of the posterior (Talts et al. 2018): values drawn from the prior, their test computed on `coarse`, noise
//! added, the posterior sampled; the ranks of the values among the draws must be uniform.
//!
//! `cargo run --release -p runner --example posterior_study -- 60` makes sixty replicates of a standard linear solid under a flat punch:
//! mu, alpha of the equilibrium, mu, eta of the branch, each over a decade. A second argument is the first replicate to make.

use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use runner::data::Measurement;
use runner::engine::{Engine, EngineOptions};
use runner::inference::fit::search;
use runner::inference::posterior::{Method, SamplePlan, posterior};
use runner::inference::valley::bends;
use runner::inference::{Requests, SearchPlan, Setup, Statistics, Unknowns};
use runner::noise::{Covariance, Observation};
use runner::pool::Priority;
use runner::pool::wiring::Names;

/// White noise, as a part of the peak.
const NOISE: f64 = 0.02;
const BINS: usize = 5;

fn main() {
    let count: usize = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(60);
    let names = Names { sensitivities: true, ..Names::default() };
    let engine = Engine::new(&EngineOptions { names, ..EngineOptions::default() }).expect("the FMU");
    let text = |all: &[&str]| all.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
    let branch = "material.branch[1]";
    let requests = Requests {
        set: text(&["mesh.preset=coarse", "material.branch[2].mu=0Pa"]),
        free: text(&["material.equilibrium.mu", "material.equilibrium.alpha"])
            .into_iter()
            .chain([format!("{branch}.mu"), format!("{branch}.eta")])
            .collect(),
        bounds: text(&["material.equilibrium.mu=-600:-60Pa", "material.equilibrium.alpha=-9.5:-0.95"])
            .into_iter()
            .chain([format!("{branch}.mu=-600:-60Pa"), format!("{branch}.eta=200:2000Pa.s")])
            .collect(),
        start: text(&["material.equilibrium.mu=-189.7Pa", "material.equilibrium.alpha=-3.004"])
            .into_iter()
            .chain([format!("{branch}.mu=-189.7Pa"), format!("{branch}.eta=632Pa.s")])
            .collect(),
        ..Requests::default()
    };
    let unknowns =
        Unknowns::new(engine.wiring(), true, &requests).map_err(|e| e.to_string()).expect("unknowns");
    let first: usize = std::env::args().nth(2).and_then(|n| n.parse().ok()).unwrap_or(0);
    let mut ranks = vec![[0usize; BINS]; unknowns.len()];
    let mut done = 0;
    println!("replicate,method,k_hat,effective,share of draws below the truth (one column per value)");
    for replicate in first..count {
        let mut random = ChaCha8Rng::seed_from_u64(7 + replicate as u64);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let prior = unknowns.prior();
        let (lower, upper) = unknowns.bounds();
        let mut value = |j: usize| loop {
            let x = prior.mean[j] + prior.deviation[j] * normal();
            if (lower[j]..=upper[j]).contains(&x) {
                return x;
            }
        };
        let truth: Vec<f64> = (0..unknowns.len()).map(&mut value).collect();
        // 0.5 s of loading to 1 mm, 20 s of hold.
        let mut time_s: Vec<f64> = (0..15).map(|k| f64::from(k) / 30.0).collect();
        time_s.extend((0..30).map(|k| 0.5 + 0.02 * 1000f64.powf(f64::from(k) / 29.0)));
        let displacement_m = time_s.iter().map(|t| 1e-3 * (t / 0.5).min(1.0)).collect();
        let force_n = vec![0.0; time_s.len()];
        let mut m = Measurement { time_s, displacement_m, force_n, ..Measurement::default() };
        let Ok(force_mn) = ({
            let data = [Observation::new(&m, None).expect("data")];
            Setup::forces_mn(&Setup::new(&engine, &data, &unknowns).submit(
                &truth,
                &[],
                false,
                Priority::Urgent,
            ))
        }) else {
            println!("{replicate},no run");
            continue;
        };
        let sigma_mn = NOISE * force_mn.iter().copied().fold(0.0, f64::max);
        m.force_n = force_mn.iter().map(|f| 1e-3 * (f + sigma_mn * normal())).collect();
        let data = [Observation::new(&m, None).expect("data")];
        let setup = Setup::new(&engine, &data, &unknowns);
        let covariance = Covariance::new(DVector::from_element(m.len(), sigma_mn), vec![]);
        let plan = SearchPlan { starts: 1, seed: 1, others: vec![], evaluations: 60 };
        let found = search(setup, &covariance, &plan, &mut |_, _| {}).map(|found| found.fit);
        let Some(fit) = found.ok() else {
            println!("{replicate},no fit");
            continue;
        };
        let statistics = Statistics::new(&unknowns, &fit, &[m.len()]).expect("points");
        let bends = bends(setup, &fit, &statistics).expect("the bends");
        let statistics = statistics.along(&unknowns, &fit.solution.x, bends);
        let plan = SamplePlan { proposals: 250, draws: 99, tuning: 100, seed: replicate as u64 };
        let sampled = match posterior(setup, &fit, &statistics, &plan) {
            Ok(sampled) => sampled,
            Err(error) => {
                println!("{replicate},{error}");
                continue;
            }
        };
        let below = |j: usize| {
            let value = sampled.terms[j].to_internal(sampled.terms[j].to_value(truth[j]));
            sampled.draws.iter().filter(|d| sampled.terms[j].to_internal(d[j]) < value).count()
        };
        let below: Vec<usize> = (0..truth.len()).map(below).collect();
        below.iter().zip(&mut ranks).for_each(|(b, row)| row[(b * BINS / 100).min(BINS - 1)] += 1);
        done += 1;
        let method = if sampled.sample.method == Method::Nuts { "nuts" } else { "importance" };
        println!(
            "{replicate},{method},{:.2},{:.0},{below:?}",
            sampled.sample.k_hat, sampled.sample.effective
        );
    }
    for (term, row) in unknowns.variables().iter().zip(&ranks) {
        let expected = done as f64 / BINS as f64;
        let chi: f64 = row.iter().map(|n| (*n as f64 - expected).powi(2) / expected).sum();
        println!(
            "{}: ranks by fifths {row:?}, chi^2 {chi:.1} of {} degrees (95 % below 9.5)",
            term.symbol,
            BINS - 1
        );
    }
}
