//! `runner inspect`: measurements in, what they say without a model out.

use super::exit::UsageError;
use super::idle::nothing_fitted;
use super::job::{Invocation, JobArguments};
use super::terminal;
use super::{CliResult, Ending};
use crate::data::{Reading, Wanted, read_tests};
use crate::inspection::{
    Options, Uncertain, WaterContent, WaterError, WaterMeasurement, cycles_csv, examine, page, phases_csv,
    table, water_content,
};
use crate::output::{Folder, json};
use clap::Args;
use std::path::PathBuf;

/// Show what measurements say without a model: cycles, peaks, relaxation, contact, noise.
#[derive(Debug, Args)]
pub struct Arguments {
    /// CSV file; or a directory with one file per specimen of a test; or NAME=FILE,FILE,... (* in quotes)
    #[arg(value_name = "MEASUREMENT", required_unless_present = "job")]
    measurements: Vec<PathBuf>,
    /// Directory for inspection.json, cycles.csv, phases.csv and inspection.html; none are written without it
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Force that means contact (mN)
    #[arg(long, value_name = "MN", default_value_t = 1.0)]
    contact_threshold_mn: f64,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    water: WaterArguments,
    #[command(flatten)]
    job: JobArguments,
}

/// What gives the volume fraction of solid.
#[derive(Debug, Args)]
#[command(next_help_heading = "Water content (Eq. 1)")]
struct WaterArguments {
    /// Wet mass of a sample, of several separated by commas, each with or without +-SD (g)
    #[arg(long, value_name = "G", value_delimiter = ',', requires = "dry_mass_g")]
    wet_mass_g: Vec<Uncertain>,
    /// Dry mass of the same samples (g)
    #[arg(long, value_name = "G", value_delimiter = ',', requires = "wet_mass_g")]
    dry_mass_g: Vec<Uncertain>,
    /// Water fraction by mass, in place of the masses, e.g. 0.968+-0.002
    #[arg(long, value_name = "FRACTION", conflicts_with_all = ["wet_mass_g", "dry_mass_g"])]
    water_fraction: Option<Uncertain>,
    /// Density of the solid (kg/m^3); the paper takes that of water
    #[arg(long, value_name = "DENSITY", default_value_t = 1000.0)]
    solid_density: f64,
    /// Density of the water (kg/m^3)
    #[arg(long, value_name = "DENSITY", default_value_t = 1000.0)]
    water_density: f64,
}

impl WaterArguments {
    fn content(&self) -> Result<Option<WaterContent>, WaterError> {
        let measured = match (self.water_fraction, self.wet_mass_g.is_empty()) {
            (Some(fraction), _) => WaterMeasurement::Fraction(fraction),
            (None, false) => {
                WaterMeasurement::Masses { wet: self.wet_mass_g.clone(), dry: self.dry_mass_g.clone() }
            }
            (None, true) => return Ok(None),
        };
        water_content(&measured, self.solid_density, self.water_density).map(Some)
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, call: &Invocation) -> CliResult {
    nothing_fitted(&arguments.reading, "inspect")?;
    let threshold_mn = arguments.contact_threshold_mn;
    if threshold_mn.is_nan() || threshold_mn <= 0.0 {
        return Err(UsageError(format!("--contact-threshold-mn {threshold_mn}: must be positive")).into());
    }
    let options = Options {
        contact_threshold_n: threshold_mn * 1e-3,
        water: arguments.water.content()?,
        command: call.command(),
    };
    let tests = read_tests(&arguments.measurements, Wanted::MotionAndForce, &arguments.reading)?;
    for doubt in tests.iter().flat_map(|t| t.measurement.doubts()) {
        say!("warning: {doubt}");
    }
    let inspection = examine(&tests, &options)?;
    say!("{}", table(&inspection));
    terminal::result(&inspection)?;
    let Some(directory) = &arguments.out else { return Ok(Ending::Complete) };
    let folder = Folder::begin(directory, "inspect")?;
    call.keep(&folder)?;
    let views = [
        ("inspection.json", json(&directory.join("inspection.json"), &inspection)?),
        ("cycles.csv", cycles_csv(&inspection).into_bytes()),
        ("phases.csv", phases_csv(&inspection).into_bytes()),
        ("inspection.html", page(&inspection).into_bytes()),
    ];
    for (name, text) in &views {
        folder.write(name, text)?;
    }
    say!("wrote inspection.json, cycles.csv, phases.csv and inspection.html to {}", directory.display());
    Ok(Ending::Complete)
}
