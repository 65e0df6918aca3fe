//! A complete fit and its report in a second, without an FMU: a small-strain surrogate of the punch (generalised
//! Maxwell with a mild strain stiffening) is fitted to noisy data that it made itself.
//!
//! `cargo run --release -p runner --example surrogate_report -- OUTPUT_DIRECTORY`

use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use runner::fit::derived::{Values, material_quantities};
use runner::fit::multi_start::minimise_from_many;
use runner::fit::parameter::{Unit, internal_problem, values_at};
use runner::fit::{CommonError, EvaluationFailure, FitParameter, MultiStartOptions, Noise, Options, Problem};
use runner::report::{self, Assembly, MeasuredCurve, Role, RunStatistics, Setting};
use std::ops::ControlFlow;
use std::path::Path;

/// Noise of the median of ten specimens (mN).
const SIGMA_MN: f64 = 0.028;
/// Scatter of the specimens' amplitude, as the standard deviation of their median.
const AMPLITUDE: f64 = 0.12 * 1.25 / 3.162;

/// Times (s) and depths (mm) of one cycle's loading at `rate` [mm/s] and 90 s hold.
fn protocol(rate: f64) -> (Vec<f64>, Vec<f64>) {
    let end = 1.1 / rate;
    let ramp = (0..).map(|i| 0.02 * i as f64).take_while(|&t| t < end);
    let hold = (0..160).map(|i| end + 90.0 * (f64::from(i) / 159.0).powi(3));
    let time: Vec<f64> = ramp.chain(hold).collect();
    let depth = time.iter().map(|t| (rate * t - 0.1).min(1.0)).collect();
    (time, depth)
}

/// Force and its fluid part (mN): mu, alpha of equilibrium and two branches, two viscosities, permeability.
fn surrogate(p: &[f64], time: &[f64], depth: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let stiffness = |mu: f64, alpha: f64, d: f64| {
        8.0 * 2.0 * 0.5 * mu * alpha * 1e-3 * (1.0 + 0.002 * alpha.abs() * d * d)
    };
    let mut stress = [0.0; 2];
    let mut pressure = 0.0;
    let (mut force, mut fluid) = (vec![], vec![]);
    for i in 0..time.len() {
        let d = depth[i].max(0.0);
        let before = if i == 0 { 0.0 } else { depth[i - 1].max(0.0) };
        let dt = if i == 0 { 0.0 } else { time[i] - time[i - 1] };
        for (k, s) in stress.iter_mut().enumerate() {
            let (mu, alpha, eta) = (p[2 + 2 * k], p[3 + 2 * k], p[6 + k]);
            let tau = eta / (0.5 * mu * alpha);
            let decay = (-dt / tau).exp();
            let mean = if dt > 0.0 { (1.0 - decay) * tau / dt } else { 1.0 };
            *s = *s * decay + stiffness(mu, alpha, d) * (d - before) * mean;
        }
        let drain = 1.5 * (2.3e-15 / p[8]).powf(0.002);
        pressure = (pressure + 5.0 * (d - before)) * (-dt / drain).exp();
        let total = stiffness(p[0], p[1], d) * d + stress.iter().sum::<f64>();
        fluid.push(pressure.min(total) * 1.2);
        force.push(total + 0.02 * pressure);
    }
    (force, fluid)
}

struct Fit<'a> {
    parameters: &'a [FitParameter],
    time: &'a [f64],
    depth: &'a [f64],
    measured: &'a [f64],
    runs: usize,
}

impl Problem for Fit<'_> {
    fn dimension(&self) -> usize {
        self.parameters.len()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        self.runs += 1;
        let (force, _) = surrogate(&values_at(self.parameters, x), self.time, self.depth);
        Ok(force.iter().zip(self.measured).map(|(f, m)| (f - m) / SIGMA_MN).collect())
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let mut jacobian = DMatrix::zeros(r.len(), x.len());
        for j in 0..x.len() {
            let mut y = x.to_vec();
            y[j] += 1e-5;
            for (i, (a, b)) in self.residual(&y)?.iter().zip(r).enumerate() {
                jacobian[(i, j)] = (a - b) / 1e-5;
            }
        }
        Ok(jacobian)
    }
}

/// Sum of twelve uniform numbers, shifted: normal enough for a picture.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64).sum::<f64>() - 6.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let directory = std::env::args().nth(1).ok_or("usage: surrogate_report OUTPUT_DIRECTORY")?;
    let truth = [-217.0, -2.16, -418.0, -13.5, -161.0, -2.97, 300.0, 4680.0, 2.3e-15];
    let pascal = || Unit::new("Pa", 1.0);
    let none = || Unit::new("", 1.0);
    let mut parameters = vec![];
    for (group, symbol) in [("equilibrium", "inf"), ("branch[1]", "1"), ("branch[2]", "2")] {
        let name = |what: &str| format!("material.{group}.{what}");
        let (mu, alpha) = (format!("mu_{symbol}"), format!("alpha_{symbol}"));
        parameters.push(FitParameter::new(&name("mu"), &mu, pascal(), -300.0, [-1000.0, -1.0])?);
        parameters.push(FitParameter::new(&name("alpha"), &alpha, none(), -5.0, [-30.0, -1.0])?);
    }
    for (i, start) in [(1, 100.0), (2, 3000.0)] {
        let (name, symbol) = (format!("material.branch[{i}].eta"), format!("eta_{i}"));
        parameters.push(FitParameter::new(&name, &symbol, Unit::new("Pa s", 1.0), start, [1.0, 1e5])?);
    }
    let mm2 = Unit::new("mm^2", 1e-6);
    parameters.push(FitParameter::new("material.permeability", "K0", mm2, 1e-14, [1e-20, 1e-8])?);

    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut data = vec![];
    for rate in [1.6, 1.0] {
        let (time, depth) = protocol(rate);
        let (force, _) = surrogate(&truth, &time, &depth);
        let measured: Vec<f64> = force.iter().map(|f| 1.03 * f + SIGMA_MN * normal(&mut rng)).collect();
        data.push((time, depth, measured));
    }
    let (time, depth, measured) = &data[0];
    let mut fit = Fit { parameters: &parameters, time, depth, measured, runs: 0 };
    let (start, bounds) = internal_problem(&parameters)?;
    let many = MultiStartOptions { starts: 24, refined: 11, seed: 1 };
    let go = &mut |_, _: &_| ControlFlow::Continue(());
    let found = minimise_from_many(&mut fit, &start, &bounds, &Options::for_log_parameters(1e-5), &many, go)?;

    let values = values_at(&parameters, &found.best.x);
    let curve = |name: &str, role, (time, depth, measured): &(Vec<f64>, Vec<f64>, Vec<f64>)| {
        let (force, fluid) = surrogate(&values, time, depth);
        MeasuredCurve {
            name: name.to_owned(),
            file: format!("data/{name}.csv"),
            role,
            provenance: Some("Synthetic: made by the surrogate itself, with noise".to_owned()),
            time_s: time.clone(),
            displacement_mm: depth.clone(),
            measured_mn: measured.clone(),
            spread_mn: Some(measured.iter().map(|f| (0.07f64.powi(2) + (0.12 * f).powi(2)).sqrt()).collect()),
            sigma_mn: vec![SIGMA_MN; time.len()],
            model_solid_mn: Some(force.iter().zip(&fluid).map(|(f, p)| f - p).collect()),
            model_mn: force,
            model_fluid_mn: Some(fluid),
        }
    };
    let curves = vec![curve("P2", Role::Fit, &data[0]), curve("P1", Role::Validation, &data[1])];
    let amplitude = curves[0].model_mn.iter().map(|f| AMPLITUDE * f / SIGMA_MN).collect();
    let noise = Noise {
        known: true,
        common: vec![CommonError {
            name: "amplitude of ten specimens (4.7 %)".to_owned(),
            residual: amplitude,
        }],
        stretches: vec![time.len()],
    };
    let runs = fit.runs;
    let report = Assembly {
        title: "Material parameters of a surrogate".to_owned(),
        created: "2026-01-01T00:00:00Z".to_owned(),
        command: "surrogate_report".to_owned(),
        model: "small-strain surrogate".to_owned(),
        parameters: &parameters,
        fixed: vec![report::FixedRow {
            name: "material.fluid_viscosity".to_owned(),
            symbol: "mu_FR".to_owned(),
            unit: "Pa s".to_owned(),
            value: 0.89e-3,
            how: "fixed".to_owned(),
        }],
        solution: &found.best,
        noise: &noise,
        derived: &material_quantities(2),
        complete: &|v: &mut Values| v.set("material.fluid_viscosity", 0.89e-3),
        first_holds: vec![],
        curves,
        runs: RunStatistics { runs, mean_in_flight: 1.0, ..RunStatistics::default() },
        starts: found.records,
        assumptions: vec![],
        settings: vec![Setting { name: "starts".to_owned(), value: "24, seed 1".to_owned() }],
    }
    .build()?;
    let directory = Path::new(&directory);
    std::fs::create_dir_all(directory)?;
    std::fs::write(directory.join("report.html"), report::page(&report))?;
    std::fs::write(directory.join("result.json"), serde_json::to_string_pretty(&report)?)?;
    std::fs::write(directory.join("parameters.csv"), report::parameters_csv(&report))?;
    std::fs::write(directory.join("curves.csv"), report::curves_csv(&report))?;
    println!("{}", report::table(&report));
    Ok(())
}
