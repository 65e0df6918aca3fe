//! A quick diagnosis at `coarse`, as examples begin.

use runner::data::{Reading, SpecimenFiles, Wanted};
use runner::diagnosis::diagnose::{Effort, Findings, Given, diagnose};
use runner::diagnosis::thresholds::Thresholds;
use runner::engine::{Engine, EngineOptions};
use runner::inference::{Requests, Unknowns};
use runner::noise::observation::observe;
use runner::pool::wiring::Names;
use std::path::Path;

pub type Error = Box<dyn std::error::Error>;

/// Largest number of evaluations of a fit.
pub const EVALUATIONS: usize = 40;

/// Engine and unknowns. Runs are kept where POROPUNCH_CACHE says.
pub fn begin() -> Result<(Engine, Unknowns), Error> {
    let names = Names { sensitivities: true, ..Names::default() };
    let engine = Engine::new(&EngineOptions { names, ..EngineOptions::default() })?;
    if let Some(cache) = std::env::var_os("POROPUNCH_CACHE") {
        engine.keep_in(Path::new(&cache))?;
    }
    let set = vec!["mesh.preset=coarse".to_owned()];
    let requests = Requests { set, ..Requests::default() };
    let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
    Ok((engine, unknowns))
}

/// The diagnosis of these files; every step is told on stderr.
pub fn diagnosed(
    engine: &Engine,
    unknowns: &Unknowns,
    files: &[impl AsRef<Path>],
) -> Result<Findings, Error> {
    let measured = |file: &Path| -> Result<_, Error> {
        Ok(SpecimenFiles::of(file)?.read(Wanted::MotionAndForce, &Reading::default())?.measurement)
    };
    let measurements = files.iter().map(|f| measured(f.as_ref())).collect::<Result<Vec<_>, _>>()?;
    let observations = observe(&measurements, None)?;
    let effort = Effort {
        quick: true,
        evaluations: EVALUATIONS,
        matters_percent: 1.0,
        thresholds: Thresholds::default(),
    };
    Ok(diagnose(engine, observations, unknowns, Given::default(), effort, &mut |what| eprintln!("{what}"))?)
}
