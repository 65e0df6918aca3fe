//! By how much the data of a challenge depend on the time steps of the solver that made them.
//!
//! ```text
//! cargo run --release -p runner --example error_of_steps FOLDER KEY SECRET ...     (three for each batch)
//! ```
//! Each case of the wide ground is computed once more with a tenth of the steps' tolerance. `challenge make` shortens the steps of draws beyond
//! `LARGEST_ERROR_OF_STEPS` now, or replaces them; batches that were made before it did so are checked here, once their keys are open.

#[path = "common/batch.rs"]
mod batch;

use batch::opened;
use runner::challenge::by_maker::ByMaker;
use runner::challenge::make::LARGEST_ERROR_OF_STEPS;
use runner::challenge::simulate::{Source, tests};

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let maker = ByMaker::new(1, &|| false)?;
    println!("| batch | case | kind | error of the steps | |\n|---|---|---|---|---|");
    for batch in arguments.chunks(3) {
        let (folder, key) = opened(batch)?;
        let tests = tests(key.cycles)?;
        for case in key.cases {
            let drawn = &case.drawn;
            let found = maker.error_of_steps(&drawn.material, &drawn.causes, &tests, &case.truth_n(), 1.0);
            let (told, is_too_large) = match found {
                Ok(error) => (format!("{:.2} %", 100.0 * error), error > LARGEST_ERROR_OF_STEPS),
                Err(failed) => (failed.to_string(), true),
            };
            let left_out = if is_too_large { "left out" } else { "" };
            println!("| {} | {} | {:?} | {told} | {left_out} |", folder.display(), drawn.id, drawn.kind);
        }
    }
    Ok(())
}
