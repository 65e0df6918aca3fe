//! What an identification costs: exact derivatives against parallel finite differences (the paper's scheme), and
//! the multifrontal LU against faer's sparse LU. One run, so that the ratios do not depend on the machine.
//!
//! ```text
//! cargo run --release -p runner --example cost_table [MEASUREMENT]     (about ten minutes)
//! ```
//! The fit is `runner identify` with its defaults: nine parameters, standard mesh, as many instances as cores.

use runner::data::{Wanted, read};
use runner::engine::{Engine, EngineOptions};
use runner::identification::identify;
use runner::inference::setup::job;
use runner::inference::{Requests, SearchPlan, Setup, Unknowns};
use runner::noise::{Observation, Weights};
use runner::pool::wiring::Names;
use runner::pool::{Priority, Run};
use runner::setting::written;
use std::path::Path;
use std::time::Instant;

type Error = Box<dyn std::error::Error>;

/// Starts away from the solution, the same for all: the parameters of Table 1 times these.
const STARTS: [(&str, f64); 4] = [
    ("material.equilibrium.mu", -300.0),
    ("material.branch[1].eta", 30.0),
    ("material.branch[2].mu", -100.0),
    ("material.branch[2].eta", 8000.0),
];

fn main() -> Result<(), Error> {
    let file = std::env::args().nth(1).unwrap_or("data/measurement/table1-one-cycle/P2.csv".to_owned());
    let test = Observation::new(&read(Path::new(&file), Wanted::MotionAndForce)?, None)?;
    println!(
        "| linear solver | derivatives | wall s | runs | one run, s | simulation-equivalents | chi^2 | steps |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for solver in ["multifrontal", "faer"] {
        for sensitivities in [true, false] {
            let names = Names { sensitivities, ..Names::default() };
            let engine = Engine::new(&EngineOptions { names, ..EngineOptions::default() })?;
            let requests = Requests {
                set: vec![format!("solver.linear_solver={solver}")],
                start: STARTS.iter().map(|(name, value)| written(engine.wiring(), name, *value)).collect(),
                ..Requests::default()
            };
            let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
            let single = single_run(&engine, &test, &unknowns)?;
            let plan = SearchPlan { starts: 1, seed: 1, others: vec![], evaluations: 60 };
            let setup = Setup::new(&engine, std::slice::from_ref(&test), &unknowns);
            let (start, before) = (Instant::now(), engine.pool().run_seconds());
            let found = identify(setup, &Weights::default(), &plan, false, &mut |_, _| {})?.found;
            let (wall, busy) = (start.elapsed().as_secs_f64(), engine.pool().run_seconds() - before);
            println!(
                "| {solver} | {} | {wall:.1} | {} | {single:.2} | {:.0} | {:.2} | {} |",
                if sensitivities { "exact" } else { "finite differences" },
                engine.cache().statistics().runs,
                busy / single,
                found.fit.solution.iterations.last().map_or(0.0, |i| i.chi_square),
                found.fit.solution.iterations.len().saturating_sub(1)
            );
        }
    }
    Ok(())
}

/// Wall time of one run without derivatives (s), the better of two.
fn single_run(engine: &Engine, test: &Observation, unknowns: &Unknowns) -> Result<f64, Error> {
    let mut least = f64::INFINITY;
    for shift in [1e-6, 2e-6] {
        // Points that the fit does not visit, so that nothing comes from the cache.
        let x: Vec<f64> = unknowns.start().iter().map(|x| x + shift).collect();
        let start = Instant::now();
        let run: Run = engine.submit(&job(test, &unknowns.settings(&x)), Priority::Urgent);
        run.wait()?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}
