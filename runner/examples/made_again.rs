//! Makes cases again whose keys are open, from the table that `challenge score` wrote: what its batches were drawn with tells the draws, and
//! its lines what could be seen of the causes, which is what takes long.
//!
//! ```text
//! cargo run --release -p runner --example made_again TABLE.json FOLDER
//! ```
//! Each batch becomes FOLDER/SEED with its cases, FOLDER/SEED.key.json and FOLDER/SEED.secret, for `challenge answer` and `challenge score`;
//! what is there is kept. Cases that are not counted, and batches of mixed kinds, are left out.

use runner::challenge::by_maker::{ByMaker, SHORT_STEPS};
use runner::challenge::draw::{Drawn, Kind, and_others, draw};
use runner::challenge::key::{CONTENT, Key, Secret, Solution};
use runner::challenge::make::{ATTEMPTS, LARGEST_ERROR_OF_STEPS, VISIBLE_ATTEMPTS, files, write_sealed};
use runner::challenge::score::{Batch, Line, Table};
use runner::challenge::simulate::{Source, tests};
use runner::output::write_file;
use std::path::Path;

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [table, out] = &arguments[..] else { return Err("a table of scores, and a folder".into()) };
    let table: Table = serde_json::from_slice(&std::fs::read(table)?)?;
    let maker = ByMaker::new(0, &|| false)?;
    for batch in &table.batches {
        let folder = Path::new(out).join(batch.seed.to_string());
        if !folder.exists() {
            make(&maker, batch, &table.lines, &folder)?;
        }
    }
    Ok(())
}

/// The draws of a batch that were taken, by their names.
fn taken(batch: &Batch) -> Vec<Drawn> {
    let &Batch { seed, ground, ref ids, .. } = batch;
    let kinds = [Kind::Null, Kind::Single, Kind::Pair, Kind::Outside, Kind::Weak];
    let all = kinds.into_iter().flat_map(|kind| draw(seed, ids.len(), &[kind], ground));
    let chosen = all.flat_map(|case| and_others(&case, ATTEMPTS + 1, ground).take(VISIBLE_ATTEMPTS as usize));
    let draws = chosen.flat_map(|case| and_others(&case, 1, ground).take(ATTEMPTS as usize + 1));
    let mut found: Vec<Drawn> = vec![];
    for drawn in draws.filter(|drawn| ids.contains(&drawn.id)) {
        if !found.iter().any(|other| other.id == drawn.id) {
            found.push(drawn);
        }
    }
    found
}

fn make(maker: &ByMaker, batch: &Batch, lines: &[Line], folder: &Path) -> Result<(), Error> {
    let tests = tests(batch.cycles)?;
    let mut cases = vec![];
    let line_of = |drawn: &Drawn| lines.iter().find(|line| line.id == drawn.id);
    for drawn in taken(batch) {
        // What is not counted has no line.
        let Some(line) = line_of(&drawn) else { continue };
        eprintln!("{}: {}", batch.seed, drawn.id);
        let (material, causes) = (&drawn.material, &drawn.causes);
        let of_tolerance = |part: f64| maker.readings_n(material, std::slice::from_ref(causes), &tests, part);
        let mut readings_n = of_tolerance(1.0)?.remove(0);
        if maker.error_of_steps(material, causes, &tests, &readings_n, 1.0)? > LARGEST_ERROR_OF_STEPS {
            readings_n = of_tolerance(SHORT_STEPS)?.remove(0);
        }
        for (path, text) in files(folder, &drawn, &tests, &readings_n) {
            write_file(&path, text.as_bytes())?;
        }
        let seen = |value: Option<f64>| value.map_or(vec![], |value| vec![value; causes.len()]);
        let (visibility, gap_percent) = (seen(line.visibility), seen(line.gap_percent));
        cases.push(Solution::new(drawn, visibility, gap_percent, &readings_n));
    }
    eprintln!("{}: {} of {} cases", batch.seed, cases.len(), batch.ids.len());
    let (schema, &Batch { seed, ground, cycles, .. }) = (CONTENT.to_owned(), batch);
    let key = Key { schema, seed, ground, cycles, cases, replaced: vec![] };
    let secret = Secret::random();
    write_sealed(&key, &secret, &folder.with_extension("key.json"), folder)?;
    write_file(&folder.with_extension("secret"), format!("{}\n", secret.text()).as_bytes())?;
    Ok(())
}
