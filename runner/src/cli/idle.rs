//! Options that would act on nothing are refused: whoever gives one believes in an effect that it does not have.

use super::exit::UsageError;
use crate::data::Reading;
use crate::identification::FitSettings;
use crate::inference::Unknowns;
use crate::noise::Observation;
use crate::setting::split_assignment;

/// Checks `--bounds`, `--start`, `--fix`, `--weight`, `--specimens` and `--seed` of a fit.
///
/// # Errors
/// Names the first option that does nothing, and why.
pub fn check(fit: &FitSettings, parameters: &Unknowns, fitted: &[Observation]) -> Result<(), UsageError> {
    bounds_and_starts(&fit.bounds, &fit.start, parameters)?;
    let idle = |what: String| Err(UsageError(format!("{what}; leave it out")));
    for text in &fit.weight {
        let name = text.split('=').next().unwrap_or(text).trim();
        let named = crate::data::Phase::named(name).unwrap_or_default();
        if !named.is_empty() && !fitted.iter().any(|d| d.phases.iter().any(|p| named.contains(p))) {
            return idle(format!("--weight {text}: no fitted measurement has a point in the phase {name}"));
        }
    }
    if fit.seed != FitSettings::SEED && fit.starts == 1 && !fit.posterior {
        return idle(format!("--seed {}: of one start and no posterior nothing is drawn", fit.seed));
    }
    if let Some(n) = fit.specimens
        && fitted.iter().all(|d| !d.measurement.specimens_n.is_empty() || d.measurement.spread_n.is_none())
    {
        return idle(format!(
            "--specimens {n}: no fitted file has a spread without its specimens, so the number acts on nothing"
        ));
    }
    Ok(())
}

/// `--zero fit` and `--tare fit` of a command that does not fit them.
///
/// # Errors
/// Names the option, and what to give instead.
pub fn nothing_fitted(reading: &Reading, command: &str) -> Result<(), UsageError> {
    let Some(option) = reading.fitted() else { return Ok(()) };
    let instead = if option.starts_with("--zero") { "--zero contact" } else { "--tare off-contact" };
    Err(UsageError(format!(
        "{option}: `{command}` fits no zeros, `identify` does; give {instead} or a value"
    )))
}

/// `--bounds` and `--start` of parameters that are not fitted.
///
/// # Errors
/// Names the first.
pub fn bounds_and_starts(
    bounds: &[String],
    starts: &[String],
    parameters: &Unknowns,
) -> Result<(), UsageError> {
    for (option, texts) in [("--bounds", bounds), ("--start", starts)] {
        for text in texts {
            let name = split_assignment(text).map_or(text.as_str(), |(name, _)| name);
            if parameters.free().iter().any(|p| p.name == name) {
                continue;
            }
            let why = if parameters.ties().iter().any(|t| t.name == name) { "tied" } else { "not fitted" };
            return Err(UsageError(format!(
                "{option} {text}: {name} is {why}, so this acts on nothing; leave it out, or fit it (--free)"
            )));
        }
    }
    Ok(())
}
