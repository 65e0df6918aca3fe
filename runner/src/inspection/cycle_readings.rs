//! The numbers of one cycle, over the specimens.

use super::contact::Contact;
use super::off_contact::{after_n, before_n, over_specimens};
use super::result::*;
use super::trace::{Pull, Trace};
use crate::data::{Cycle, Estimate, Quartiles};
use statrs::distribution::{ContinuousCDF, Normal};

/// Times after the end of the ramp at which the force is read (s).
const AFTER_S: [f64; 4] = [1.0, 10.0, 30.0, 90.0];

/// Peak and force at the end of the hold of each specimen (N), for ratios between tests.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Readings {
    /// Peaks (N).
    pub peak_n: Vec<f64>,
    /// Forces at the end of the hold (N).
    pub hold_end_n: Vec<f64>,
}

const NOTHING: Quartiles = Quartiles { median: 0.0, q25: 0.0, q75: 0.0, count: 0 };

/// Cycle `index` of all specimens.
pub(super) fn cycle(
    traces: &[Trace],
    index: usize,
    noise_n: f64,
    contacts: &[Contact],
) -> (CycleInspection, Readings) {
    let each = |read: &dyn Fn(&Trace, &Cycle) -> Option<f64>| -> Vec<f64> {
        traces.iter().filter_map(|t| read(t, &t.cycles[index])).collect()
    };
    let quartiles = |values: &[f64]| Quartiles::of(values).unwrap_or(NOTHING);
    let hold_end = |t: &Trace, c: &Cycle| t.force_after_n(c, c.hold_s());
    let force_after = |after_s: f64| {
        let force_mn = Quartiles::of(&each(&|t, c| t.force_after_n(c, after_s)))?.scaled(1e3);
        Some(ForceAfter { after_s, force_mn })
    };
    let relaxation = each(&|t, c| {
        let peak = t.peak_n(c)?;
        Some((peak - hold_end(t, c)?) / peak)
    });
    let over_first = each(&|t, c| Some(t.peak_n(c)? / t.peak_n(&t.cycles[0])?));
    let readings = Readings { peak_n: each(&|t, c| t.peak_n(c)), hold_end_n: each(&hold_end) };
    let before: Vec<Estimate> = traces.iter().filter_map(|t| before_n(t, index)).collect();
    let after: Vec<Estimate> = traces.iter().filter_map(|t| after_n(t, index)).collect();
    let drift = |t: &Trace| {
        let (b, a) = (before_n(t, index)?, after_n(t, index)?);
        Some(Estimate { value: a.value - b.value, sigma: a.sigma.hypot(b.sigma) })
    };
    let drifts: Vec<Estimate> = traces.iter().filter_map(drift).collect();
    let c = traces[0].cycles[index];
    let inspection = CycleInspection {
        number: c.number,
        start_s: c.start_s,
        ramp_start_s: c.ramp_start_s,
        ramp_end_s: c.ramp_end_s,
        hold_end_s: c.hold_end_s,
        surface_s: c.surface_s,
        withdrawn_s: c.withdrawn_s,
        end_s: c.end_s,
        hold_s: c.hold_s(),
        depth_mm: c.depth_m * 1e3,
        rate_mm_per_s: Estimate { value: c.ramp.rate_m_per_s, sigma: c.ramp.rate_sigma_m_per_s }.scaled(1e3),
        unload_rate_mm_per_s: c.unload.map(|l| l.rate_m_per_s.abs() * 1e3),
        peak_mn: quartiles(&readings.peak_n).scaled(1e3),
        force_after: AFTER_S.iter().filter_map(|&s| force_after(s)).collect(),
        hold_end_mn: quartiles(&readings.hold_end_n).scaled(1e3),
        relaxation_percent: quartiles(&relaxation).scaled(100.0),
        peak_over_first: quartiles(&over_first),
        retraction: retraction(traces, index, noise_n),
        off_contact_before_mn: over_specimens(&before).map(|e| e.scaled(1e3)),
        off_contact_after_mn: over_specimens(&after).map(|e| e.scaled(1e3)),
        drift_mn: over_specimens(&drifts).map(|e| e.scaled(1e3)),
        contact: contact(contacts),
    };
    (inspection, readings)
}

fn retraction(traces: &[Trace], index: usize, noise_n: f64) -> Option<Retraction> {
    let found: Vec<Pull> = traces.iter().filter_map(|t| t.pull(&t.cycles[index])).collect();
    let read = |f: fn(&Pull) -> f64| Quartiles::of(&found.iter().map(f).collect::<Vec<f64>>());
    let samples = found.iter().map(|f| f.samples).max()?;
    // The smallest of n normal values lies below this in one of a hundred cases.
    let quantile = Normal::standard().inverse_cdf(0.01 / samples.max(1) as f64);
    let noise_alone_n = read(|f| f.base_n)?.median + noise_n * quantile;
    let minimum = read(|f| f.minimum_n)?;
    let adhesion = noise_n > 0.0 && minimum.median < noise_alone_n;
    Some(Retraction { minimum_mn: minimum.scaled(1e3), noise_alone_mn: noise_alone_n * 1e3, adhesion })
}

fn contact(contacts: &[Contact]) -> Option<ContactInspection> {
    let values = |read: &dyn Fn(&Contact) -> Option<f64>| -> Option<Quartiles> {
        Quartiles::of(&contacts.iter().filter_map(read).collect::<Vec<_>>()).map(|q| q.scaled(1e3))
    };
    Some(ContactInspection {
        threshold_mm: values(&|c| Some(c.threshold_m.value))?,
        threshold_sigma_mm: values(&|c| Some(c.threshold_m.sigma))?.median,
        onset_mm: values(&|c| c.onset_m.map(|e| e.value)),
        onset_sigma_mm: values(&|c| c.onset_m.map(|e| e.sigma)).map(|q| q.median),
    })
}
