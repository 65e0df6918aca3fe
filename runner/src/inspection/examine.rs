//! From synchronised tests to the inspection.

use super::contact::{Contact, find_contact};
use super::cycle_readings::{Readings, cycle};
use super::off_contact;
use super::ratios::ratios;
use super::result::*;
use super::trace::Trace;
use super::water::WaterContent;
use crate::data::phase::phases;
use crate::data::plausibility::outliers;
use crate::data::{DataError, Estimate, Measurement, Synchronised};
use crate::noise::common_factor::common_factor;
use crate::noise::correlated::{NoiseParts, Record, autocorrelation, noise_parts};
use crate::noise::odd_specimen::{Odd, odd_in_height, odd_in_shape};

/// What is not in the files.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Force that means contact (N).
    pub contact_threshold_n: f64,
    /// Water content, if it was asked for.
    pub water: Option<WaterContent>,
    /// The command that was given.
    pub command: String,
}

/// Bins of the autocorrelation.
const BINS: usize = 30;

/// Reads everything that the tests say without a model.
///
/// # Errors
/// When a displacement jumps or has no ramp.
pub fn examine(tests: &[Synchronised], options: &Options) -> Result<Inspection, DataError> {
    let examined = tests.iter().map(|t| test(t, options)).collect::<Result<Vec<_>, _>>()?;
    let ratios = ratios(&examined);
    Ok(Inspection {
        schema: SCHEMA.to_owned(),
        command: options.command.clone(),
        contact_threshold_mn: options.contact_threshold_n * 1e3,
        water: options.water,
        tests: examined.into_iter().map(|e| e.0).collect(),
        ratios,
    })
}

fn test(test: &Synchronised, options: &Options) -> Result<(TestInspection, Vec<Readings>), DataError> {
    let m = &test.measurement;
    let traces = Trace::of_all(test)?;
    let records: Vec<Record> = traces.iter().flat_map(off_contact::records).collect();
    let parts = noise_parts(&records);
    let of_holds = off_contact::white_of_holds(&traces).filter(|_| parts.is_none());
    let noise_n = parts.map(total).or(of_holds.map(|h| h.0.value)).unwrap_or(0.0);
    let mut notes: Vec<String> = m.warnings.iter().chain(&m.notes).cloned().collect();
    if parts.is_none() {
        notes.push(
            "too few samples off contact to tell correlated noise: measure some seconds above the surface"
                .into(),
        );
    }
    let count = traces.iter().map(|t| t.cycles.len()).min().unwrap_or(0);
    if traces.iter().any(|t| t.cycles.len() != count) {
        notes.push(format!("the specimens have different numbers of cycles: the first {count} are shown"));
    }
    let contacts =
        |index: usize| -> Vec<Contact> { touches(&traces, index, options.contact_threshold_n, noise_n) };
    let (cycles, readings): (Vec<_>, Vec<_>) =
        (0..count).map(|index| cycle(&traces, index, noise_n, &contacts(index))).unzip();
    let threshold_mn = options.contact_threshold_n * 1e3;
    if cycles.iter().all(|c| c.contact.is_none()) {
        notes.push(format!(
            "the force never passes {threshold_mn} mN on the way in: no contact point (--contact-threshold-mn)"
        ));
    } else if options.contact_threshold_n < 4.0 * noise_n {
        notes.push(format!(
            "the contact threshold of {threshold_mn} mN is less than four times the noise of {:.3} mN: contact \
             points are unsure (--contact-threshold-mn)",
            noise_n * 1e3
        ));
    }
    let inspection = TestInspection {
        name: m.name.clone(),
        source: Source {
            file: m.file.display().to_string(),
            comments: m.comments.clone(),
            synthetic: m.is_synthetic(),
            notes,
        },
        specimens: m.specimen_names.clone(),
        odd_specimens: odd_specimens(m),
        points: m.len(),
        displacement_noise_mm: traces.iter().map(|t| t.displacement_noise_m).fold(0.0, f64::max) * 1e3,
        shifts_s: test.shifts_s.clone(),
        cycles,
        noise: noise(m, parts, of_holds, &records),
        curve: curve(m)?,
    };
    Ok((inspection, readings))
}

/// Specimens of another shape, which are left out of fits, and those of another height.
fn odd_specimens(m: &Measurement) -> Vec<OddSpecimen> {
    let told = |left_out: bool| {
        move |odd: Odd| {
            let name = m.specimen_names.get(odd.index).cloned();
            OddSpecimen { name: name.unwrap_or_else(|| format!("{}", odd.index + 1)), why: odd.why, left_out }
        }
    };
    let shapes = odd_in_shape(m).into_iter().map(told(true));
    let mut all: Vec<OddSpecimen> = shapes.collect();
    let heights = odd_in_height(m).into_iter().map(told(false));
    let new: Vec<OddSpecimen> = heights.filter(|h| all.iter().all(|s| s.name != h.name)).collect();
    all.extend(new);
    all
}

/// Where nothing was measured in the air, the load cell is believed.
const NO_BASE: Estimate = Estimate { value: 0.0, sigma: 0.0 };

/// Contacts of all specimens in a cycle.
fn touches(traces: &[Trace], index: usize, threshold_n: f64, noise_n: f64) -> Vec<Contact> {
    let touch = |trace: &Trace| {
        let base = off_contact::before_n(trace, index).or_else(|| off_contact::after_n(trace, index));
        find_contact(trace, &trace.cycles[index], threshold_n, noise_n.max(1e-9), base.unwrap_or(NO_BASE))
    };
    traces.iter().filter_map(touch).collect()
}

fn total(parts: NoiseParts) -> f64 {
    parts.white.value.hypot(parts.correlated.map_or(0.0, |c| c.amplitude.value))
}

fn noise(
    m: &Measurement,
    parts: Option<NoiseParts>,
    of_holds: Option<(Estimate, usize)>,
    records: &[Record],
) -> NoiseInspection {
    let common = common_factor(m);
    let correlated = parts.and_then(|p| p.correlated);
    NoiseInspection {
        white_mn: parts.map(|p| p.white).or(of_holds.map(|h| h.0)).map(|w| w.scaled(1e3)),
        white_from: if parts.is_some() { NoiseSource::OffContact } else { NoiseSource::Holds },
        correlated: CorrelatedNoise {
            correlated_mn: correlated.map(|c| c.amplitude.scaled(1e3)),
            correlation_time_s: correlated.map(|c| c.time_s),
            correlated_below_mn: parts.map(|p| p.correlated_below * 1e3),
        },
        samples: parts.map(|p| p.samples).or(of_holds.map(|h| h.1)).unwrap_or(0),
        outliers: parts.map_or(0, |p| p.outliers),
        specimen_log_deviation: common.as_ref().map(|c| c.log_deviation),
        height_of_median: common.as_ref().map(|c| c.of_median),
        specimen_factors: common.map_or_else(Vec::new, |c| c.amplitudes),
        autocorrelation: autocorrelation(records, BINS),
    }
}

fn curve(m: &Measurement) -> Result<PhaseCurve, DataError> {
    let cycles = crate::data::cycles(m)?;
    let milli = |values: &[f64]| values.iter().map(|v| v * 1e3).collect::<Vec<f64>>();
    let quartiles = m.quartiles_n.as_ref().map(|q| q.iter().map(|(a, b)| (a * 1e3, b * 1e3)).collect());
    let of_curve = |force_n: &[f64]| -> Vec<(f64, f64)> {
        let found = outliers(&m.time_s, force_n);
        found.into_iter().map(|i| (m.time_s[i], force_n[i] * 1e3)).collect()
    };
    let outliers = m.curves_n().into_iter().flat_map(of_curve).collect();
    let number = |&t: &f64| cycles.iter().filter(|c| t > c.times.start_s).count().max(1);
    Ok(PhaseCurve {
        time_s: m.time_s.clone(),
        displacement_mm: milli(&m.displacement_m),
        force_mn: milli(&m.force_n),
        quartiles_mn: quartiles,
        specimens_mn: m.specimens_n.iter().map(|s| milli(s)).collect(),
        outliers,
        cycle: m.time_s.iter().map(number).collect(),
        phase: phases(m),
    })
}
