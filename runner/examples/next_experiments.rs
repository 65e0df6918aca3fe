//! Whether the test that a diagnosis proposes for a group would settle it.
//!
//! ```text
//! cargo run --release -p runner --example next_experiments FOLDER ...     (each with P1.csv and P2.csv; coarse mesh, --quick)
//! ```
//! Where the answer is a group, each of its members is taken to be true in turn: the test that is proposed first is simulated with it, and all
//! members are refitted to what was measured and to this test together. The group is settled where every other member's chi^2 is worse by what
//! decides (`thresholds.rs`). A test that decides by itself (a stiff blank) counts as settling it. Runs are kept where POROPUNCH_CACHE says.

use runner::data::{Reading, SpecimenFiles, Wanted};
use runner::diagnosis::diagnose::{Effort, Given, diagnose};
use runner::diagnosis::experiments::{rivals, told_apart};
use runner::diagnosis::result::Kind;
use runner::diagnosis::thresholds::Thresholds;
use runner::engine::{Engine, EngineOptions};
use runner::inference::{Requests, Setup, Unknowns};
use runner::noise::observation::observe;
use runner::pool::wiring::Names;
use std::path::Path;

type Error = Box<dyn std::error::Error>;

/// Largest number of evaluations of a fit.
const EVALUATIONS: usize = 40;
/// Of the noise of the simulated tests.
const SEED: u64 = 20_261_125;

fn main() -> Result<(), Error> {
    let names = Names { sensitivities: true, ..Names::default() };
    let engine = Engine::new(&EngineOptions { names, ..EngineOptions::default() })?;
    if let Some(cache) = std::env::var_os("POROPUNCH_CACHE") {
        engine.keep_in(Path::new(&cache))?;
    }
    let set = vec!["mesh.preset=coarse".to_owned()];
    let requests = Requests { set, ..Requests::default() };
    let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
    let thresholds = Thresholds::default();
    let effort = Effort { quick: true, evaluations: EVALUATIONS, matters_percent: 1.0, thresholds };
    println!("| case | group | test | taken as true: worse by (chi^2) | settled |");
    println!("|---|---|---|---|---|");
    let (mut settled, mut asked) = (0, 0);
    for folder in std::env::args().skip(1) {
        let measured = |test: &str| -> Result<_, Error> {
            let file = Path::new(&folder).join(test);
            Ok(SpecimenFiles::of(&file)?.read(Wanted::MotionAndForce, &Reading::default())?.measurement)
        };
        let observations = observe(&[measured("P1.csv")?, measured("P2.csv")?], None)?;
        let found = diagnose(&engine, observations, &unknowns, Given::default(), effort, &mut |what| {
            eprintln!("{what}")
        })?;
        if found.conclusion.decision.kind != Kind::Group {
            continue;
        }
        let members = rivals(&found.round.refits, &found.conclusion.decision.members, &found.candidates);
        let Some(proposal) = found.conclusion.proposals.first().filter(|_| members.len() > 1) else {
            continue;
        };
        let setup = Setup::new(&engine, &found.observations, &unknowns);
        let name = |k: usize| found.candidates[members[k].members[0]].name.as_str();
        let mut told = Vec::new();
        for truth in 0..members.len() {
            asked += 1;
            if proposal.evidence.is_none() {
                settled += 1;
                told.push(format!("{}: by itself", name(truth)));
                continue;
            }
            let chi = told_apart(setup, &found.candidates, &found.noise, &members, proposal, (truth, SEED))?;
            let Some(chi) = chi else {
                told.push(format!("{}: the model fails", name(truth)));
                continue;
            };
            let others = (0..chi.len()).filter(|k| *k != truth).map(|k| chi[k] - chi[truth]);
            let least = others.fold(f64::INFINITY, f64::min);
            settled += usize::from(least > thresholds.decisive);
            told.push(format!("{}: {least:.0}", name(truth)));
        }
        let group: Vec<&str> = (0..members.len()).map(name).collect();
        println!(
            "| {folder} | {} | {} | {} | {settled} of {asked} |",
            group.join(", "),
            proposal.what,
            told.join("; ")
        );
    }
    println!(
        "\n{settled} of {asked} members, each taken as true, are told from the others by the test that is proposed first."
    );
    Ok(())
}
