//! Makes cases again whose keys are open, from the table that `challenge score` wrote: what its batches were drawn with tells the draws, and
//! its lines what could be seen of the causes, which is what takes long.
//!
//! ```text
//! cargo run --release -p runner --example made_again TABLE.json FOLDER
//! ```
//! Each batch becomes FOLDER/SEED with its cases, FOLDER/SEED.key.json and FOLDER/SEED.secret, for `challenge answer` and `challenge score`;
//! what is there is kept. Cases that are not counted, and batches of mixed kinds, are left out.

use runner::challenge::by_maker::{ByMaker, SHORT_STEPS};
use runner::challenge::draw::{Drawn, Kind, again, draw};
use runner::challenge::key::{CASES, CONTENT, Key, SEAL, Secret, Solution, hash, sealed};
use runner::challenge::make::{ATTEMPTS, LARGEST_ERROR_OF_STEPS, VISIBLE_ATTEMPTS};
use runner::challenge::noise::{csv, measured_n};
use runner::challenge::score::{Batch, Line, Table};
use runner::challenge::simulate::{Source, tests};
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
    let kinds = [Kind::Null, Kind::Single, Kind::Pair, Kind::Outside, Kind::Weak];
    let replacements = |of: Drawn| {
        let further =
            (0..=ATTEMPTS).map(move |k| if k == 0 { of.clone() } else { again(&of, k, batch.ground) });
        further.collect::<Vec<_>>()
    };
    let all = kinds.into_iter().flat_map(|kind| draw(batch.seed, batch.ids.len(), &[kind], batch.ground));
    let draws = all.flat_map(|case| {
        (0..VISIBLE_ATTEMPTS).flat_map(move |k| match k {
            0 => replacements(case.clone()),
            _ => replacements(again(&case, k * (ATTEMPTS + 1), batch.ground)),
        })
    });
    let mut found: Vec<Drawn> = vec![];
    for drawn in draws.filter(|drawn| batch.ids.contains(&drawn.id)) {
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
        for (test, measured) in tests.iter().zip(&measured_n(&drawn, &tests, &readings_n)) {
            let path = folder.join(CASES).join(&drawn.id);
            std::fs::create_dir_all(&path)?;
            std::fs::write(path.join(format!("{}.csv", test.name)), csv(test, measured))?;
        }
        let seen = |value: Option<f64>| value.map_or(vec![], |value| vec![value; causes.len()]);
        cases.push(Solution {
            effects: causes.iter().filter_map(|c| c.effect().map(str::to_owned)).collect(),
            visibility: seen(line.visibility),
            gap_percent: seen(line.gap_percent),
            truth_mn: readings_n.iter().map(|r| r.iter().map(|f| f * 1e3).collect()).collect(),
            drawn,
        });
    }
    eprintln!("{}: {} of {} cases", batch.seed, cases.len(), batch.ids.len());
    let (schema, &Batch { seed, ground, cycles, .. }) = (CONTENT.to_owned(), batch);
    let key = Key { schema, seed, ground, cycles, cases, replaced: vec![] };
    let secret = Secret::random();
    let bytes = sealed(&key, &secret).ok_or("the key cannot be sealed")?;
    std::fs::write(folder.with_extension("key.json"), &bytes)?;
    std::fs::write(folder.join(SEAL), format!("{}\n", hash(&bytes)))?;
    std::fs::write(folder.with_extension("secret"), format!("{}\n", secret.text()))?;
    Ok(())
}
