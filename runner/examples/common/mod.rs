//! A quick diagnosis at `coarse`, as examples begin.

use runner::data::{Reading, SpecimenFiles, Wanted};
use runner::diagnosis::diagnose::{Effort, Findings, Given, diagnose};
use runner::diagnosis::plain_start::PlainStarts;
use runner::diagnosis::thresholds::Thresholds;
use runner::engine::{Engine, EngineOptions};
use runner::inference::{Requests, Unknowns};
use runner::noise::observation::observe;
use runner::pool::wiring::Names;
use std::path::Path;

pub type Error = Box<dyn std::error::Error>;

/// Largest number of evaluations of a fit.
pub const EVALUATIONS: usize = 40;

/// The engine. Runs are kept where POROPUNCH_CACHE says.
pub fn begin() -> Result<Engine, Error> {
    let names = Names { sensitivities: true, ..Names::default() };
    let engine = Engine::new(&EngineOptions { names, ..EngineOptions::default() })?;
    if let Some(cache) = std::env::var_os("POROPUNCH_CACHE") {
        engine.keep_in(Path::new(&cache))?;
    }
    Ok(engine)
}

/// The diagnosis of these files, where a gap of this part of the peak matters (%), and what was fitted; every step is told on stderr.
pub fn diagnosed(
    engine: &Engine,
    files: &[impl AsRef<Path>],
    matters_percent: f64,
) -> Result<(Findings, Unknowns), Error> {
    let measured = |file: &Path| -> Result<_, Error> {
        Ok(SpecimenFiles::of(file)?.read(Wanted::MotionAndForce, &Reading::default())?.measurement)
    };
    let measurements = files.iter().map(|f| measured(f.as_ref())).collect::<Result<Vec<_>, _>>()?;
    let observations = observe(&measurements, None)?;
    let set = vec!["mesh.preset=coarse".to_owned()];
    let starts = PlainStarts::of(engine, &observations, &Requests { set, ..Requests::default() })?;
    let effort =
        Effort { quick: true, evaluations: EVALUATIONS, matters_percent, thresholds: Thresholds::default() };
    let found =
        diagnose(engine, observations, &starts, Given::default(), effort, &mut |what| eprintln!("{what}"))?;
    Ok((found, starts.unknowns))
}
