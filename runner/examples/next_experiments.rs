//! Whether the test that a diagnosis proposes for a group would settle it.
//!
//! ```text
//! cargo run --release -p runner --example next_experiments MATTERS PATH ...     (folders with P1.csv and P2.csv, or files)
//! ```
//! Quick diagnoses on the coarse mesh, where a gap of less than MATTERS (% of the peak) does not matter. Where the answer is a group, each of
//! its members is taken to be true in turn: the test that is proposed first is simulated with it, and all members are refitted to what was
//! measured and to this test together. The group is settled where every other member's chi^2 is worse by what decides (`thresholds.rs`). A
//! stiff blank settles it where no other member is on the same side, of machine or specimen. Runs are kept where POROPUNCH_CACHE says.

mod common;

use common::{Error, begin, diagnosed};
use runner::diagnosis::experiments::{is_outside, rivals, told_apart};
use runner::diagnosis::result::Kind;
use runner::inference::Setup;
use std::path::Path;

/// Of the noise of the simulated tests.
const SEED: u64 = 20_261_125;

fn main() -> Result<(), Error> {
    let engine = begin()?;
    println!("| case | group | test | taken as true: worse by (chi^2) | settled |");
    println!("|---|---|---|---|---|");
    let (mut settled, mut asked) = (0, 0);
    let mut arguments = std::env::args().skip(1);
    let matters_percent: f64 = arguments.next().ok_or("what matters (%), then folders or files")?.parse()?;
    for path in arguments {
        let place = Path::new(&path);
        let files = match place.is_dir() {
            true => ["P1.csv", "P2.csv"].map(|test| place.join(test)).to_vec(),
            false => vec![place.to_owned()],
        };
        let (found, unknowns) = diagnosed(&engine, &files, matters_percent)?;
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
                let outside = |k: usize| is_outside(members[k], &found.candidates);
                let is_alone = (0..members.len()).all(|k| k == truth || outside(k) != outside(truth));
                settled += usize::from(is_alone);
                told.push(format!("{}: {}", name(truth), if is_alone { "by itself" } else { "not alone" }));
                continue;
            }
            let chi = told_apart(setup, &found.candidates, &found.noise, &members, proposal, (truth, SEED))?;
            let Some(chi) = chi else {
                told.push(format!("{}: the model fails", name(truth)));
                continue;
            };
            let others = (0..chi.len()).filter(|k| *k != truth).map(|k| chi[k] - chi[truth]);
            let least = others.fold(f64::INFINITY, f64::min);
            settled += usize::from(least > found.thresholds.decisive);
            told.push(format!("{}: {least:.0}", name(truth)));
        }
        let group: Vec<&str> = (0..members.len()).map(name).collect();
        println!(
            "| {path} | {} | {} | {} | {settled} of {asked} |",
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
