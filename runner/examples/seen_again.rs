//! What anybody could see of the causes of cases that were made before, by the present oracle.
//!
//! ```text
//! cargo run --release -p runner --example seen_again EFFECT LARGEST FOLDER KEY SECRET ...     (three for each batch)
//! ```
//! Each single case of the wide ground that is visible, up to LARGEST, is computed once more without its cause, which is asked for again;
//! EFFECT `all`, or one of the catalogue.

#[path = "common/batch.rs"]
mod batch;

use batch::opened;
use runner::challenge::by_maker::ByMaker;
use runner::challenge::key::{CASES, Solution, VISIBLE};
use runner::challenge::oracle::Oracle;
use runner::challenge::simulate::{Source, tests};
use runner::data::reader::{Wanted, read};
use runner::engine::{Engine, EngineOptions};
use runner::setting::settings_from;

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [effect, largest, batches @ ..] = &arguments[..] else {
        return Err("an effect, the largest score, then a folder, key and secret of each batch".into());
    };
    let largest: f64 = largest.parse()?;
    let is_asked = |case: &Solution| {
        let [named] = &case.effects[..] else { return false };
        (effect == "all" || effect == named) && (VISIBLE..=largest).contains(&case.visibility[0])
    };
    let engine = Engine::new(&EngineOptions::default())?;
    let numerics = settings_from(engine.wiring(), &["mesh.preset=coarse".to_owned()])?;
    let maker = ByMaker::new(1, &|| false)?;
    println!("| case | effects | score | now | gap (%) | now |\n|---|---|---|---|---|---|");
    for batch in batches.chunks(3) {
        let (folder, key) = opened(batch)?;
        let tests = tests(key.cycles)?;
        for case in key.cases.iter().filter(|case| is_asked(case)) {
            let drawn = &case.drawn;
            let plain_n = maker.readings_n(&drawn.material, &[vec![]], &tests, 1.0)?.remove(0);
            let change_mn =
                case.truth_mn.iter().flatten().zip(plain_n.iter().flatten()).map(|(mn, n)| mn - 1e3 * n);
            let folder = folder.join(CASES).join(&drawn.id);
            let measurements =
                ["P1", "P2"].map(|test| read(&folder.join(format!("{test}.csv")), Wanted::MotionAndForce));
            let measurements = measurements.into_iter().collect::<Result<Vec<_>, _>>()?;
            let seen = Oracle::new(&engine, drawn, &numerics, &measurements)?.seen(&[change_mn.collect()])?;
            println!(
                "| {} | {} | {:.1} | {:.1} | {:.2} | {:.2} |",
                drawn.id,
                case.effects[0],
                case.visibility[0],
                seen[0].score,
                case.gap_percent[0],
                seen[0].gap_percent
            );
        }
    }
    Ok(())
}
