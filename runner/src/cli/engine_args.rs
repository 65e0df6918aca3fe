//! Options shared by all commands that run the FMU.

use super::job::JobArguments;
use super::terminal;
use crate::data::{Measurement, Reading};
use crate::engine::{Engine, EngineError, EngineOptions};
use crate::inference::{Requests, Unknowns};
use crate::parameter_set::{ParameterSet, ParameterSetError};
use crate::pool::Wiring;
use crate::pool::wiring::Names;
use clap::Args;
use poropunch::variables::{self, Causality, Kind, Variable};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Which FMU, and how many instances of it.
#[derive(Debug, Clone, Default, PartialEq, Args)]
#[command(next_help_heading = "Model")]
pub struct EngineArguments {
    /// FMU to run (FMI 2.0 co-simulation); poropunch's own when absent
    #[arg(long, value_name = "FILE")]
    pub fmu: Option<PathBuf>,
    /// Input that is the punch's displacement, with its unit or factor to SI where the FMU names none
    #[arg(long, value_name = "NAME[:UNIT]")]
    pub input: Option<String>,
    /// Output that is the force, with its unit or factor to SI where the FMU names none
    #[arg(long, value_name = "NAME[:UNIT]")]
    pub output: Option<String>,
    /// Parameter that is not fitted, e.g. material.permeability=2.3e-9mm^2 (repeatable; all in --help)
    #[arg(long = "set", value_name = "NAME=VALUE[UNIT]")]
    pub set: Vec<String>,
    /// Parameter set of such values: an SSV file (System Structure Parameter Values), as other FMI tools and `identify` write it
    /// (repeatable; a later one wins, --set wins over all)
    #[arg(long, value_name = "FILE")]
    pub parameters: Vec<PathBuf>,
    /// Mesh: coarse, standard or fine (the same as --set mesh.preset=...), or paper-3d, the paper's
    /// three-dimensional model (--set mesh.kind=paper-3d): minutes instead of seconds, 2 GB per job
    #[arg(long, value_name = "PRESET")]
    pub mesh: Option<String>,
    /// FMU instances that run at a time [default: one per core]
    #[arg(long, short, value_name = "N", default_value_t = 0, hide_default_value = true,
        value_parser = super::count::jobs)]
    pub jobs: usize,
}

/// What a command takes that runs the model beside tests that it reads.
#[derive(Debug, Clone, Default, Args)]
pub struct RunArguments {
    #[command(flatten)]
    pub(super) reading: Reading,
    #[command(flatten)]
    pub(super) engine: EngineArguments,
    #[command(flatten)]
    job: JobArguments,
}

impl EngineArguments {
    /// Loads the FMU and starts the workers; records `extra` outputs and, where the FMU has them with these settings, the
    /// derivatives of the force. Runs are kept in `cache`.
    ///
    /// # Errors
    /// As [`Engine::new`] and [`Engine::keep_in`].
    pub fn engine(
        &self,
        extra: &[String],
        sensitivities: bool,
        cache: Option<&Path>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Engine, EngineError> {
        let (input, output) = (self.input.clone(), self.output.clone());
        let names = |sensitivities| Names {
            input: input.clone(),
            output: output.clone(),
            extra: extra.to_vec(),
            sensitivities,
            ..Names::default()
        };
        let mut engine = self.engine_of(names(sensitivities), stop)?;
        if sensitivities && !self.offers_derivatives(&engine) {
            engine = self.engine_of(names(false), stop)?;
        }
        // After the run that told it: a usage error must leave nothing behind.
        cache.map_or(Ok(()), |directory| engine.keep_in(directory))?;
        self.show_notes(engine.wiring());
        Ok(engine)
    }

    /// Whether derivatives are there with these settings; those that cannot be used are the caller's to report.
    fn offers_derivatives(&self, engine: &Engine) -> bool {
        let Ok(set) = self.settings(engine.wiring()) else { return true };
        let requests = Requests { set, ..Requests::default() };
        let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests);
        unknowns.map_or(true, |u| engine.offers_derivatives(&u.settings(u.start())))
    }

    /// The same for given names.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn engine_of(&self, names: Names, stop: &Arc<AtomicBool>) -> Result<Engine, EngineError> {
        let (fmu, stop) = (self.fmu.clone(), Arc::clone(stop));
        Engine::new(&EngineOptions { fmu, names, workers: self.jobs, stop })
    }

    /// Tells what was read leniently in the parameter sets; those that cannot be read are for [`Self::settings`] to report.
    pub fn show_notes(&self, wiring: &Wiring) {
        let sets = self.parameters.iter().filter_map(|file| ParameterSet::read(file).ok());
        sets.flat_map(|set| set.notes(wiring)).for_each(|note| terminal::note(&note));
    }

    /// Everything that is set, parameter sets and `--mesh` included.
    ///
    /// # Errors
    /// A parameter set that cannot be used.
    pub fn settings(&self, wiring: &Wiring) -> Result<Vec<String>, ParameterSetError> {
        let mut settings = Vec::new();
        for file in &self.parameters {
            settings.extend(ParameterSet::read(file)?.settings(wiring)?);
        }
        let mesh = self.mesh.iter().map(|mesh| match mesh.as_str() {
            kind @ ("paper-3d" | "axisymmetric") => format!("mesh.kind={kind}"),
            preset => format!("mesh.preset={preset}"),
        });
        settings.extend(mesh.chain(self.set.iter().cloned()));
        Ok(settings)
    }
}

/// Where the runs of a command are kept: in the directory that was asked for, in the one that the environment names, or beside the results.
pub fn cache_directory(asked: Option<&Path>, out: &Path) -> PathBuf {
    let named = || std::env::var_os("POROPUNCH_CACHE").filter(|name| !name.is_empty()).map(PathBuf::from);
    asked.map(Path::to_owned).or_else(named).unwrap_or_else(|| out.join("cache"))
}

/// Tells the user what was read leniently in a file.
pub fn show_notes(measurement: &Measurement) {
    for note in &measurement.notes {
        terminal::note(&format!("{}: {note}", measurement.file.display()));
    }
}

/// All parameters of poropunch's FMU with unit, start value and description, from the variable table.
pub fn parameter_help() -> String {
    let mut text = "Parameters of poropunch's FMU (NAME [unit] = default: description):\n".to_owned();
    let parameters = || variables::table().iter().filter(|v| v.causality == Causality::Parameter);
    let numbers = parameters().filter(|v| v.kind != Kind::Text);
    for v in numbers.filter(|v| !v.name.starts_with("protocol.")) {
        let _ = writeln!(text, "  {}", parameter_line(v));
    }
    text.push_str(
        "\nA value with a unit needs one (2.3e-9mm^2, 0.89mPa.s, 10mm). Displacement and force are positive \
         into the sample.",
    );
    text
}

fn parameter_line(v: &Variable) -> String {
    let start = match v.kind {
        Kind::Boolean => (v.start_number() != 0.0).to_string(),
        Kind::Enumeration(e) => {
            let item = v.start_number() as usize;
            e.items.get(item.saturating_sub(1)).map_or_else(String::new, |(name, _)| (*name).to_owned())
        }
        Kind::Real { unit, .. } => {
            let shown = v.start_number() * unit.factor;
            // Avoids 9.999999e-1 after the change of unit.
            format!("{}", format!("{shown:.6e}").parse().unwrap_or(shown))
        }
        Kind::Integer { .. } | Kind::Text => v.start_number().to_string(),
    };
    let unit = v.unit().map(|u| u.display).filter(|u| *u != "1").map(|u| format!(" [{u}]"));
    format!("{}{} = {start}: {}", v.name, unit.unwrap_or_default(), v.description)
}
