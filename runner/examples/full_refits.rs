//! Whether the linearised bootstrap of the shrinkage agrees with full refits.
//!
//! ```text
//! cargo run --release -p runner --example full_refits P1.csv P2.csv [DRAWS]     (coarse mesh, --quick; minutes)
//! ```
//! The model with the effect that the diagnosis finds is taken to be true. For each draw of the noise both models are fitted anew,
//! by all of the theory, to what the split fits, and predict the rest; beside it what the linearised models make of the same draw.

mod common;

use common::{EVALUATIONS, Error, begin, diagnosed};
use runner::diagnosis::shrinkage::{Comparison, part_removed, percentile};
use runner::inference::fit::fit;
use runner::inference::{Candidate, Fit, FitPlan, Setup};
use runner::noise::Observation;

fn main() -> Result<(), Error> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let draws: usize = match arguments.last().map(|last| last.parse()) {
        Some(Ok(draws)) => {
            arguments.pop();
            draws
        }
        _ => 20,
    };
    let engine = begin()?;
    let (found, unknowns) = diagnosed(&engine, &arguments, 1.0)?;
    let Some(refit) = found.conclusion.decision.refit.map(|k| &found.round.refits[k]) else {
        return Err("no effect explains a gap of these data: there is no shrinkage".into());
    };
    let active = refit.active(&found.candidates);
    let with: Vec<&str> = active.iter().map(|c| c.name.as_str()).collect();
    println!("with {}; part of the gap that goes, of the same draws of the noise", with.join(" and "));
    println!("| split | full refits: median [5, 95 %] | linearised | largest difference | correlation |");
    println!("|---|---|---|---|---|");
    for (split, _) in &found.splits {
        let Some(linear) = Comparison::new(&found.round.plain, &refit.fit, split, &found.thresholds)
            .filter(|c| c.informative)
        else {
            continue;
        };
        let mut pairs: Vec<(f64, f64)> = Vec::new();
        for noise in linear.noise_mn().take(draws) {
            let drawn = with_change(&found.observations, &(&noise - &refit.fit.gap_mn));
            let setup = Setup::new(&engine, &drawn, &unknowns);
            let covariance = &found.noise.covariance;
            let again = |start: &Fit, active: &[&Candidate]| -> Result<Fit, Error> {
                let plan = FitPlan::to_minimum(&start.solution.x, EVALUATIONS);
                let known = covariance.without(&split.predicted);
                let fitted = fit(setup, active, &known, &plan, &mut |_| {})?;
                Ok(fitted.seen_with(setup, active, covariance)?)
            };
            let (plain, extended) = (again(&found.round.plain, &[])?, again(&refit.fit, &active)?);
            let full = Comparison::new(&plain, &extended, split, &found.thresholds)
                .and_then(|c| part(&c.distances_mn([&plain.gap_mn, &extended.gap_mn], &noise)));
            pairs.extend(full.zip(part(&linear.linear_distances_mn(&noise))));
        }
        report(&split.name, &pairs);
    }
    Ok(())
}

/// Part of the distance from the force without noise that goes.
fn part([before, after]: &[nalgebra::DVector<f64>; 2]) -> Option<f64> {
    part_removed(before.norm(), after.norm())
}

/// The same tests with their forces changed (mN, all points).
fn with_change(observations: &[Observation], change_mn: &nalgebra::DVector<f64>) -> Vec<Observation> {
    let mut changed = observations.to_vec();
    let forces = changed.iter_mut().flat_map(|o| o.measurement.force_n.iter_mut());
    forces.zip(change_mn.iter()).for_each(|(force_n, change)| *force_n += 1e-3 * change);
    changed
}

/// A row of the table.
fn report(split: &str, pairs: &[(f64, f64)]) {
    let of = |values: Vec<f64>| {
        let mut sorted = values;
        sorted.sort_by(f64::total_cmp);
        let at = |part: f64| 100.0 * percentile(&sorted, part).unwrap_or(f64::NAN);
        format!("{:.1} % [{:.1}, {:.1}]", at(0.5), at(0.05), at(0.95))
    };
    let n = pairs.len() as f64;
    let mean = |values: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(values).sum::<f64>() / n;
    let (full, linear) = (mean(&|p| p.0), mean(&|p| p.1));
    let product = mean(&|p| (p.0 - full) * (p.1 - linear));
    let squares = mean(&|p| (p.0 - full).powi(2)) * mean(&|p| (p.1 - linear).powi(2));
    let largest = pairs.iter().map(|p| (p.0 - p.1).abs()).fold(0.0, f64::max);
    println!(
        "| {split} | {} | {} | {:.1} % | {:.2} |",
        of(pairs.iter().map(|p| p.0).collect()),
        of(pairs.iter().map(|p| p.1).collect()),
        100.0 * largest,
        product / squares.sqrt()
    );
}
