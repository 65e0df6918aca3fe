//! Everything that an identification's result depends on, kept beside it so that it can be resumed.
//!
//! Resuming is a replay: the optimiser is deterministic and every run that was made is in the cache, so the
//! same settings lead through the same runs to where the work ended, and on from there.

use crate::cli::engine_args::EngineArguments;
use crate::data::{DataError, Phase, Reading, SpecimenFiles};
use crate::inference::{Requests, SearchPlan};
use crate::noise::{Uncertainty, Weights};
use crate::output::{Folder, OutputError, json};
use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Everything that the result depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Version of this layout.
    pub version: u32,
    /// What is fitted.
    pub measurements: Vec<Source>,
    /// What is predicted.
    pub validation: Vec<Source>,
    /// The FMU.
    pub engine: EngineArguments,
    /// The fit.
    pub fit: FitSettings,
    /// How the files are read.
    #[serde(default)]
    pub reading: Reading,
}

/// A measurement's file, or files, as they were when they were read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Absolute path of the file or the directory, or `NAME=FILE,FILE,...` with absolute paths.
    pub file: PathBuf,
    /// blake3 of the bytes; of the files' hashes where there are several.
    pub hash: String,
}

/// What is fitted, from where, and how.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
#[command(next_help_heading = "Fit")]
pub struct FitSettings {
    /// Parameters to fit, exactly these [default: equilibrium, permeability, and as many branches as the data ask for]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Parameter not to fit, at this value or its default (repeatable)
    #[arg(long, value_name = "NAME[=VALUE[UNIT]]")]
    pub fix: Vec<String>,
    /// Parameter that follows another one, e.g. material.branch\[2\].mu=material.branch\[1\].mu*0.5 (repeatable)
    #[arg(long, value_name = "NAME=OTHER*FACTOR")]
    pub tie: Vec<String>,
    /// Bounds of a fitted parameter [default: five decades around the start]; it is
    /// then fitted under its own name, not through G and tau (repeatable)
    #[arg(long, value_name = "NAME=LOWER:UPPER")]
    pub bounds: Vec<String>,
    /// Start of a fitted parameter [default: told by the data] (repeatable)
    #[arg(long, value_name = "NAME=VALUE[UNIT]")]
    pub start: Vec<String>,
    /// Which uncertainty weighs the points; none is the plain chi^2 of Eq. 16
    #[arg(long, value_enum, default_value_t)]
    pub noise: Uncertainty,
    /// Number of specimens behind the file's spread, where it does not hold the specimens themselves
    #[arg(long, value_name = "N", value_parser = crate::cli::count::specimens)]
    pub specimens: Option<usize>,
    /// Weight of a phase (approach, ramp, hold, unload, recovery; or hold-early, hold-middle, hold-late alone) in
    /// chi^2 [default: 1 each] (repeatable)
    #[arg(long, value_name = "PHASE=WEIGHT")]
    pub weight: Vec<String>,
    /// Starts: the first is --start, the others are drawn within the bounds
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = crate::cli::count::starts)]
    pub starts: usize,
    /// Seed of the drawn starts
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// Take the interval of this value from the profile of the likelihood: a parameter by its name, or a symbol such as G_1, tau_2,
    /// alpha_1, K0 (repeatable). Without being asked this is done where a linearised interval is open or curved; `none` leaves that out
    #[arg(long, value_name = "NAME")]
    #[serde(default)]
    pub profile: Vec<String>,
    /// Points that lie far from the rest count less (Huber's loss)
    #[arg(long)]
    #[serde(default)]
    pub robust: bool,
    /// Sample the posterior: posterior.csv and a corner plot (a thousand runs and more)
    #[arg(long)]
    #[serde(default)]
    pub posterior: bool,
    /// Where derivatives come from
    #[arg(long, value_enum, default_value_t)]
    pub jacobian: JacobianSource,
    /// Finite-difference step, relative to the parameter
    #[arg(long, value_name = "STEP", default_value_t = 0.01)]
    pub fd_step: f64,
    /// Largest number of evaluations per start (those inside a Jacobian are not counted)
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = crate::cli::count::evaluations)]
    pub max_evaluations: usize,
}

/// Where the derivatives of the force by the parameters come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
pub enum JacobianSource {
    /// The FMU's own where it has them, finite differences for the other parameters
    #[default]
    Auto,
    /// The FMU's own for all parameters, or an error
    Sensitivity,
    /// Finite differences for all parameters
    Fd,
}

/// Settings that cannot be used.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// A measurement that cannot be read.
    #[error("{}: cannot be read: {source}; check the path", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// Nothing to resume.
    #[error("{} has no {FILE}: there is nothing to resume; leave out --resume", directory.display())]
    NothingToResume {
        /// The output directory.
        directory: PathBuf,
    },
    /// A settings file that is damaged or of another version.
    #[error("{}: cannot be used: {reason}; begin anew without --resume (runs in the cache are kept)", file.display())]
    Damaged {
        /// The settings file.
        file: PathBuf,
        /// Reason.
        reason: String,
    },
    /// A measurement that is not what it was.
    #[error("{} has changed since the identification began: begin anew without --resume", file.display())]
    Changed {
        /// The measurement.
        file: PathBuf,
    },
    /// The command line asks for something else.
    #[error(
        "--resume continues what was begun, but the command line differs in {what}; give the same options, or only --resume and --out"
    )]
    Differs {
        /// Which part.
        what: &'static str,
    },
    /// A phase weight that cannot be read.
    #[error(
        "--weight {0}: write PHASE=WEIGHT with PHASE one of approach, ramp, hold (or hold-early, hold-middle, hold-late), unload, recovery and WEIGHT >= 0"
    )]
    BadWeight(String),
    /// A step that is not small and positive.
    #[error("--fd-step {0}: must be between 1e-6 and 0.2")]
    BadStep(f64),
    /// A directory or a list of files without files.
    #[error(transparent)]
    Files(#[from] DataError),
    /// Writing.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Name of the settings file in the output directory.
pub const FILE: &str = "settings.json";
const VERSION: u32 = 2;

impl Source {
    /// A measurement as it is now.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn of(argument: &Path) -> Result<Self, SettingsError> {
        let source = SpecimenFiles::of(argument)?;
        let hash = |file: &PathBuf| match std::fs::read(file) {
            Ok(bytes) => Ok(blake3::hash(&bytes)),
            Err(source) => Err(SettingsError::Unreadable { file: file.clone(), source }),
        };
        let hashes = source.files.iter().map(hash).collect::<Result<Vec<_>, _>>()?;
        let all = match hashes.as_slice() {
            [one] => *one,
            several => {
                blake3::hash(several.iter().map(blake3::Hash::to_string).collect::<String>().as_bytes())
            }
        };
        Ok(Self { file: source.argument, hash: all.to_hex().to_string() })
    }
}

impl Settings {
    /// Settings of a new identification.
    ///
    /// # Errors
    /// When a measurement cannot be read.
    pub fn new(
        measurements: &[PathBuf],
        validation: &[PathBuf],
        engine: &EngineArguments,
        fit: &FitSettings,
        reading: &Reading,
    ) -> Result<Self, SettingsError> {
        let sources = |files: &[PathBuf]| files.iter().map(|f| Source::of(f)).collect::<Result<Vec<_>, _>>();
        Ok(Self {
            version: VERSION,
            measurements: sources(measurements)?,
            validation: sources(validation)?,
            engine: EngineArguments { jobs: 0, ..engine.clone() },
            fit: fit.clone(),
            reading: reading.clone(),
        })
    }

    /// Those that an identification in `directory` began with.
    ///
    /// # Errors
    /// When there are none, they are damaged, or a measurement has changed since.
    pub fn load(directory: &Path) -> Result<Self, SettingsError> {
        let file = directory.join(FILE);
        let text = std::fs::read_to_string(&file)
            .map_err(|_| SettingsError::NothingToResume { directory: directory.to_owned() })?;
        let damaged = |reason: String| SettingsError::Damaged { file: file.clone(), reason };
        let settings: Self = serde_json::from_str(&text).map_err(|e| damaged(e.to_string()))?;
        if settings.version != VERSION {
            return Err(damaged(format!("version {} instead of {VERSION}", settings.version)));
        }
        for source in settings.measurements.iter().chain(&settings.validation) {
            if Source::of(&source.file)? != *source {
                return Err(SettingsError::Changed { file: source.file.clone() });
            }
        }
        Ok(settings)
    }

    /// Keeps them in the output directory.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, folder: &Folder) -> Result<(), SettingsError> {
        let text = json(&folder.path().join(FILE), self)?;
        Ok(folder.write(FILE, &text)?)
    }

    /// Checks that the command line asks for the same thing.
    ///
    /// # Errors
    /// Names what differs.
    pub fn check_same(&self, asked: &Self) -> Result<(), SettingsError> {
        let parts = [
            ("the measurements", self.measurements == asked.measurements),
            ("--validate", self.validation == asked.validation),
            ("the model's options", self.engine == asked.engine),
            ("the fit's options", self.fit == asked.fit),
            ("how the files are read", self.reading == asked.reading),
        ];
        match parts.iter().find(|(_, same)| !same) {
            Some((what, _)) => Err(SettingsError::Differs { what }),
            None => Ok(()),
        }
    }

    /// What is fitted, fixed and tied.
    pub fn requests(&self) -> Requests {
        let f = self.fit.clone();
        let set = self.engine.settings();
        Requests {
            set,
            free: f.free,
            fix: f.fix,
            tie: f.tie,
            bounds: f.bounds,
            start: f.start,
            ..Requests::default()
        }
    }
}

impl FitSettings {
    /// How points are weighed.
    ///
    /// # Errors
    /// When a weight cannot be read.
    pub fn weights(&self) -> Result<Weights, SettingsError> {
        let one = |text: &String| {
            let bad = || SettingsError::BadWeight(text.clone());
            let (phase, weight) = text.split_once('=').ok_or_else(bad)?;
            let named = Phase::named(phase.trim()).ok_or_else(bad)?;
            let weight = weight.trim().parse::<f64>().ok().filter(|w| w.is_finite() && *w >= 0.0);
            let weight = weight.ok_or_else(bad)?;
            Ok(named.iter().map(move |phase| (*phase, weight)))
        };
        let phases = self.weight.iter().map(one).collect::<Result<Vec<_>, SettingsError>>()?;
        let phases: BTreeMap<Phase, f64> = phases.into_iter().flatten().collect();
        Ok(Weights { uncertainty: self.noise, specimens: self.specimens, phases })
    }

    /// How the fit is made.
    ///
    /// # Errors
    /// When the finite-difference step is not usable.
    pub fn plan(&self) -> Result<SearchPlan, SettingsError> {
        if !(1e-6..=0.2).contains(&self.fd_step) {
            return Err(SettingsError::BadStep(self.fd_step));
        }
        Ok(SearchPlan { starts: self.starts, seed: self.seed, evaluations: self.max_evaluations })
    }
}
