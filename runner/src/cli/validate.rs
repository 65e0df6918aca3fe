//! `runner validate`: given parameters against measurements, without fitting.

use super::assumed;
use super::engine_args::EngineArguments;
use super::identify::{observations, sample_height};
use super::{CliResult, Ending};
use crate::data::Reading;
use crate::identification::curves;
use crate::noise::{Uncertainty, Weights, noise_model};
use crate::output::{Folder, curve_csv};
use crate::score::Score;
use crate::setting::settings_from;
use clap::Args;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Score given parameters against measurements, without fitting.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Measurements: CSV files with time_s,displacement_mm,force_mN; or a directory with one file per specimen of
    /// a test; or NAME=FILE,FILE,...
    #[arg(value_name = "MEASUREMENT", required = true)]
    measurements: Vec<PathBuf>,
    /// Which uncertainty weighs the points; none is the plain chi^2 of Eq. 16
    #[arg(long, value_enum, default_value_t)]
    noise: Uncertainty,
    /// Number of specimens behind the file's spread, where it does not hold the specimens themselves
    #[arg(long, value_name = "N", value_parser = super::count::specimens)]
    specimens: Option<usize>,
    /// Directory for the curves; none are written without it
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    engine: EngineArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments, stop: &Arc<AtomicBool>) -> CliResult {
    let recorded = ["force_solid", "force_fluid"].map(str::to_owned);
    let engine = arguments.engine.engine(&recorded, false, None, stop)?;
    let values = settings_from(engine.wiring(), &arguments.engine.settings())?;
    let weights =
        Weights { uncertainty: arguments.noise, specimens: arguments.specimens, ..Weights::default() };
    let height = sample_height(&engine, &arguments.engine)?;
    let tests = observations(&arguments.measurements, height, &arguments.reading)?;
    for line in assumed::lines(&engine, &values, &[]) {
        say!("{line}");
    }
    let folder = arguments.out.as_ref().map(|d| Folder::begin(d, "validate")).transpose()?;
    say!("measurement  points  chi^2/point  rms [mN]  peak [mN] (measured)  relaxation [%] (measured)");
    let mut failures = Vec::new();
    for (test, curve) in tests.iter().zip(curves(&engine, &tests, &values, false)) {
        let name = test.name();
        let curve = match curve {
            Ok(curve) => curve,
            Err(_) if engine.is_stopped() => return Ok(Ending::Interrupted),
            Err(reason) => {
                failures.push(format!("{name}: {reason}"));
                continue;
            }
        };
        let force_mn: Vec<f64> = curve.force_n().iter().map(|f| f * 1e3).collect();
        let noise = noise_model(std::slice::from_ref(test), &force_mn, vec![], &weights)?;
        let s = Score::of(test, &curve, &noise.covariance);
        say!(
            "{name:11}  {:6}  {:11.3}  {:8.4}  {:9.3} ({:8.3})  {:14.1} ({:8.1})",
            s.points,
            s.chi_square / s.points as f64,
            s.rms_n * 1e3,
            s.model.peak_n * 1e3,
            s.measured.peak_n * 1e3,
            s.model.relaxation * 100.0,
            s.measured.relaxation * 100.0
        );
        noise.tests.iter().for_each(|t| say!("  {}", t.description));
        if let Some(folder) = &folder {
            let text = curve_csv(&curve, &[format!("model at the times of {name}")]);
            folder.write(&format!("{name}.csv"), text.as_bytes())?;
        }
    }
    if failures.is_empty() { Ok(Ending::Complete) } else { Err(failures.join("\n").into()) }
}
