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
    let milli = |of: &[Estimate]| over_specimens(of).map(|e| e.scaled(1e3));
    let c = traces[0].cycles[index];
    let inspection = CycleInspection {
        times: c.times,
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
        off_contact: OffContact {
            off_contact_before_mn: milli(&before),
            off_contact_after_mn: milli(&after),
            drift_mn: milli(&drifts),
        },
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;
    use crate::data::{Measurement, Synchronised};

    /// Two cycles with 0.07 mN of noise; the sample holds the punch with `pull_n` for a tenth of a second.
    fn test(pull_n: f64, seed: u64) -> Synchronised {
        let mut random = Random::new(seed);
        let time_s: Vec<f64> = (0..2000).map(|i| 0.02 * f64::from(i)).collect();
        let d = |t: f64| match t % 20.0 {
            t if t < 8.0 => (1e-3 * (t - 0.1)).min(1e-3),
            t if t < 18.9 => (1e-3 * (9.0 - t)).max(-1e-3),
            t => 1e-3 * (t - 19.9) - 0.1e-3,
        };
        let f = |t: f64| {
            let pull = if (9.0..9.1).contains(&(t % 20.0)) { -pull_n } else { 0.0 };
            10.0 * d(t).max(0.0) + pull
        };
        let measurement = Measurement {
            displacement_m: time_s.iter().map(|&t| d(t)).collect(),
            force_n: time_s.iter().map(|&t| f(t) + 0.07e-3 * random.normal()).collect(),
            time_s,
            ..Measurement::default()
        };
        Synchronised { measurement, originals: vec![], shifts_s: vec![] }
    }

    fn adhesions(pull_n: f64) -> usize {
        let one = |seed| {
            let test = test(pull_n, seed);
            let traces = Trace::of_all(&test).unwrap();
            assert_eq!(traces[0].cycles.len(), 2);
            (0..2).filter(|&k| cycle(&traces, k, 0.07e-3, &[]).0.retraction.unwrap().adhesion).count()
        };
        (0..50).map(one).sum()
    }

    #[test]
    fn adhesion_is_told_from_noise() {
        assert_eq!(adhesions(0.6e-3), 100);
        // One in a hundred by the threshold, a few more from the unsure baseline.
        assert!(adhesions(0.0) <= 5, "{}", adhesions(0.0));
    }

    #[test]
    fn readings_are_over_the_first_peak() {
        let test = test(0.0, 1);
        let traces = Trace::of_all(&test).unwrap();
        let (second, readings) = cycle(&traces, 1, 0.07e-3, &[]);
        assert!((second.peak_over_first.median - 1.0).abs() < 0.04, "{second:?}");
        assert!((readings.hold_end_n[0] - 10e-3).abs() < 0.05e-3, "{readings:?}");
        assert!((second.hold_s - 6.9).abs() < 0.02 && second.force_after.len() == 1, "{second:?}");
    }
}
