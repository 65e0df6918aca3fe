//! What is fitted, from where, and how.

use crate::data::Phase;
use crate::inference::{Requests, SearchPlan};
use crate::noise::{Uncertainty, Weights};
use clap::{Args, ValueEnum};
use std::collections::BTreeMap;
use thiserror::Error;

/// What is fitted, from where, and how.
#[derive(Debug, Clone, PartialEq, Args)]
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
    /// Bounds of a fitted parameter [default: where the data can show it]; it is
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
    #[arg(long, value_name = "SEED", default_value_t = Self::SEED)]
    pub seed: u64,
    /// Take the interval of this value from the profile of the likelihood: a parameter by its name, or a symbol such as G_1, tau_2,
    /// alpha_1, K0 (repeatable). Without being asked this is done where a linearised interval is open or curved; `none` leaves that out
    #[arg(long, value_name = "NAME")]
    pub profile: Vec<String>,
    /// Points that lie far from the rest count less (Huber's loss)
    #[arg(long)]
    pub robust: bool,
    /// Sample the posterior: posterior.csv and a corner plot (a thousand runs and more)
    #[arg(long)]
    pub posterior: bool,
    /// Where derivatives come from
    #[arg(long, value_enum, default_value_t)]
    pub jacobian: JacobianSource,
    /// Finite-difference step, relative to the parameter
    #[arg(long, value_name = "STEP", default_value_t = Self::STEP)]
    pub fd_step: f64,
    /// Largest number of evaluations per start (those inside a Jacobian are not counted)
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = crate::cli::count::evaluations)]
    pub max_evaluations: usize,
}

/// Where the derivatives of the force by the parameters come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum JacobianSource {
    /// The FMU's own where it has them, finite differences for the other parameters
    #[default]
    Auto,
    /// The FMU's own for all parameters, or an error
    Sensitivity,
    /// Finite differences for all parameters
    Fd,
}

/// Smaller weights leave a phase out, larger ones everything else: beyond, chi^2 loses its digits.
const LEAST_WEIGHT: f64 = 1e-6;
const MOST_WEIGHT: f64 = 1e6;

/// Settings that cannot be used.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// A phase weight that cannot be read.
    #[error(
        "--weight {0}: write PHASE=WEIGHT with PHASE one of approach, ramp, hold (or hold-early, hold-middle, hold-late), unload, recovery and WEIGHT 0 or from {LEAST_WEIGHT} to {MOST_WEIGHT}"
    )]
    BadWeight(String),
    /// A step that is not small and positive.
    #[error("--fd-step {0}: must be between 1e-6 and 0.2")]
    BadStep(f64),
}

impl FitSettings {
    /// Seed unless another one is asked for.
    pub const SEED: u64 = 1;
    /// Finite-difference step unless another one is asked for.
    pub const STEP: f64 = 0.01;

    /// What is fitted, fixed and tied, beside what is `set`.
    pub fn requests(&self, set: Vec<String>) -> Requests {
        let f = self.clone();
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

    /// How points are weighed.
    ///
    /// # Errors
    /// When a weight cannot be read.
    pub fn weights(&self) -> Result<Weights, SettingsError> {
        let one = |text: &String| {
            let bad = || SettingsError::BadWeight(text.clone());
            let (phase, weight) = text.split_once('=').ok_or_else(bad)?;
            let named = Phase::named(phase.trim()).ok_or_else(bad)?;
            let is_usable = |w: &f64| *w == 0.0 || (LEAST_WEIGHT..=MOST_WEIGHT).contains(w);
            let weight = weight.trim().parse::<f64>().ok().filter(is_usable);
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
        Ok(SearchPlan {
            starts: self.starts,
            seed: self.seed,
            others: vec![],
            evaluations: self.max_evaluations,
        })
    }
}
