//! `runner validate`: given parameters against measurements, without fitting.

use super::assumed;
use super::engine_args::RunArguments;
use super::heading::Heading;
use super::identify::{observations, sample_height};
use super::idle::nothing_fitted;
use super::job::Invocation;
use super::parameter_sets::file_name;
use super::terminal;
use super::{CliResult, Ending};
use crate::data::{Wanted, read_tests};
use crate::identification::curves;
use crate::noise::{Uncertainty, Weights, noise_model};
use crate::output::{Folder, curve_csv};
use crate::report::{Pair, columns};
use crate::score::Score;
use crate::setting::settings_from;
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Score given parameters against measurements, without fitting.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Measurements: CSV files with time_s,displacement_mm,force_mN; or a directory with one file per specimen of
    /// a test; or NAME=FILE,FILE,...
    #[arg(value_name = "MEASUREMENT", required_unless_present = "job")]
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
    run: RunArguments,
}

/// How given parameters meet measurements: what `--json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Validation {
    /// `poropunch.validation/1`.
    pub schema: String,
    /// Which command, which model, which parameters.
    #[serde(flatten)]
    pub heading: Heading,
    /// Each measurement whose run did not fail.
    pub tests: Vec<ValidatedTest>,
    /// Why runs failed.
    pub failures: Vec<String>,
}

/// One measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ValidatedTest {
    /// Its name.
    pub name: String,
    /// Number of points.
    pub points: usize,
    /// Sum of squared differences over the noise.
    pub chi_square: f64,
    /// Root mean square of the difference (mN).
    pub rms_mn: f64,
    /// Peak force (mN).
    pub peak_mn: Pair,
    /// Relaxation, (peak - end) / peak (%); absent where there is no peak.
    pub relaxation_percent: Option<Pair>,
    /// What the noise is taken to be, in words.
    pub noise: Vec<String>,
}

impl ValidatedTest {
    fn of(name: &str, s: &Score, noise: Vec<String>) -> Self {
        let (measured, model) = (s.measured.relaxation * 100.0, s.model.relaxation * 100.0);
        let is_known = measured.is_finite() && model.is_finite();
        Self {
            name: name.to_owned(),
            points: s.points,
            chi_square: s.chi_square,
            rms_mn: s.rms_n * 1e3,
            peak_mn: Pair { measured: s.measured.peak_n * 1e3, model: s.model.peak_n * 1e3 },
            relaxation_percent: is_known.then_some(Pair { measured, model }),
            noise,
        }
    }

    fn row(&self) -> Vec<String> {
        let pair = |p: &Pair, digits: usize| format!("{:.digits$} / {:.digits$}", p.measured, p.model);
        vec![
            self.name.clone(),
            self.points.to_string(),
            format!("{:.3}", self.chi_square / self.points as f64),
            format!("{:.4}", self.rms_mn),
            pair(&self.peak_mn, 3),
            self.relaxation_percent.as_ref().map_or_else(|| "-".to_owned(), |r| pair(r, 1)),
        ]
    }
}

/// Headings of [`ValidatedTest::row`].
const HEADER: [&str; 6] =
    ["measured / model", "points", "chi^2 per point", "rms mN", "peak force mN", "relaxation %"];

/// Runs the command.
pub fn run(arguments: &Arguments, call: &Invocation) -> CliResult {
    nothing_fitted(&arguments.run.reading, "validate")?;
    let recorded = ["force_solid", "force_fluid"].map(str::to_owned);
    let tests = read_tests(&arguments.measurements, Wanted::MotionAndForce, &arguments.run.reading)?;
    let engine = arguments.run.engine.engine(&recorded, false, None, &call.stop)?;
    let values = settings_from(engine.wiring(), &arguments.run.engine.settings(engine.wiring())?)?;
    let weights =
        Weights { uncertainty: arguments.noise, specimens: arguments.specimens, ..Weights::default() };
    let height = sample_height(&engine, &arguments.run.engine)?;
    let tests = observations(tests, height)?;
    let assumptions = assumed::of(&engine, &values, &[]);
    let assumed = assumed::say_before(&assumptions);
    let folder = arguments.out.as_ref().map(|d| Folder::begin(d, "validate")).transpose()?;
    let mut validated = Vec::new();
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
        let told = noise.tests.iter().map(|t| t.description.clone()).collect();
        let found = ValidatedTest::of(name, &s, told);
        validated.push(found);
        if let Some(folder) = &folder {
            let text = curve_csv(&curve, &[format!("model at the times of {name}")]);
            folder.write(&format!("{}.csv", file_name(name)), text.as_bytes())?;
        }
    }
    if let Some(folder) = &folder {
        call.keep(folder)?;
    }
    let mut table = String::new();
    columns(&mut table, HEADER, &validated.iter().map(ValidatedTest::row).collect::<Vec<_>>());
    say!("{}", table.trim_start_matches('\n').trim_end());
    for test in &validated {
        test.noise.iter().for_each(|n| say!("{}: {n}", test.name));
    }
    if let Some(assumed) = assumed {
        say!("{assumed}");
    }
    let validation = Validation {
        schema: "poropunch.validation/1".to_owned(),
        heading: Heading::new(call, &engine, assumptions),
        tests: validated,
        failures,
    };
    terminal::result(&validation)?;
    let failures = &validation.failures;
    if failures.is_empty() { Ok(Ending::Complete) } else { Err(failures.join("\n").into()) }
}
