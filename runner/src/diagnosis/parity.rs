//! Relations that need no fit, from the inspection of the measurements.

use super::result::{Deviation, Parity};
use crate::inspection::{Inspection, TestInspection};

fn relation(relation: &str, of: &str, deviation: Deviation, shows: &str) -> Parity {
    Parity { relation: relation.to_owned(), of: of.to_owned(), deviation, shows: shows.to_owned() }
}

fn deviation(value: f64, sigma: Option<f64>, expected: Option<f64>, unit: &str) -> Deviation {
    Deviation { value, sigma, expected, unit: unit.to_owned() }
}

/// All relations that the tests offer.
pub fn parity(inspection: &Inspection) -> Vec<Parity> {
    let mut all = Vec::new();
    for r in &inspection.ratios {
        let of = format!("{} / {}, cycle {}", r.test, r.reference, r.cycle);
        let mut add = |what: &str, value: crate::inspection::RatioValue, expected, shows: &str| {
            all.push(relation(what, &of, deviation(value.value, value.sigma, expected, ""), shows));
        };
        add(
            "ratio of forces at the end of the hold",
            r.hold_end,
            Some(1.0),
            "amplitude between the specimens",
        );
        add("ratio of peaks", r.peak, None, "amplitude and rate together");
        add("ratio of peaks over that of hold ends", r.rate_effect, None, "the effect of the rate alone");
    }
    inspection.tests.iter().for_each(|test| all.extend(of_test(test)));
    all
}

fn of_test(test: &TestInspection) -> Vec<Parity> {
    let mut all = Vec::new();
    for c in &test.cycles {
        let of = format!("{}, cycle {}", test.name, c.times.number);
        let mut add = |what: &str, found: Deviation, shows: &str| all.push(relation(what, &of, found, shows));
        if let Some(before) = c.off_contact.off_contact_before_mn {
            let found = deviation(before.value, Some(before.sigma), Some(0.0), "mN");
            add("force off contact before", found, "load-cell offset");
        }
        if let Some(drift) = c.off_contact.drift_mn {
            let found = deviation(drift.value, Some(drift.sigma), Some(0.0), "mN");
            add("change of the force off contact", found, "load-cell drift");
        }
        let onset = c.contact.as_ref().and_then(|c| Some((c.onset_mm?.median, c.onset_sigma_mm)));
        if let Some((onset, sigma)) = onset {
            // The onset of a median over the specimens; uncertainty of one of them, so on the careful side.
            let found = deviation(onset, sigma, Some(0.0), "mm");
            add("onset of force", found, "contact-point offset, lag, compliance");
        }
        if c.times.number > 1 {
            let found = deviation(c.peak_over_first.median, None, None, "");
            add("peak over the first cycle's", found, "softening, drying, recovery");
        }
        let slope = late_slope(test, c.times.ramp_end_s, c.times.hold_end_s);
        if let Some((slope, sigma)) = slope {
            let found = deviation(slope, Some(sigma), Some(0.0), "%/decade");
            let shows = "slow relaxation, drift, drying: the hold is too short to tell";
            add("slope at the end of the hold, relative", found, shows);
        }
        if let Some(r) = &c.retraction {
            let found = deviation(r.minimum_mn.median, None, Some(r.noise_alone_mn), "mN");
            add("retraction minimum", found, "adhesion");
        }
    }
    if let Some((lag, sigma)) = kink_lag(test) {
        let (of, found) = (format!("{}, cycle 1", test.name), deviation(lag, Some(sigma), Some(0.0), "s"));
        all.push(relation("peak of the force after the end of the ramp", &of, found, "load-cell lag"));
    }
    all
}

/// Change of the force per decade of time over the last third of a decade of the hold, in % of it, by least squares.
fn late_slope(test: &TestInspection, ramp_end_s: f64, hold_end_s: f64) -> Option<(f64, f64)> {
    let hold = hold_end_s - ramp_end_s;
    let curve = &test.curve;
    let late = (0..curve.time_s.len()).filter(|&i| {
        let since = curve.time_s[i] - ramp_end_s;
        since > hold / 2.0 && since <= hold
    });
    let points: Vec<(f64, f64)> =
        late.map(|i| ((curve.time_s[i] - ramp_end_s).log10(), curve.force_mn[i])).collect();
    let n = points.len() as f64;
    if n < 4.0 {
        return None;
    }
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let xx: f64 = points.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / xx;
    let rest: f64 = points.iter().map(|p| (p.1 - my - slope * (p.0 - mx)).powi(2)).sum();
    let sigma = (rest / (n - 2.0) / xx).sqrt();
    (my.abs() > 0.0).then(|| (100.0 * slope / my, 100.0 * sigma / my.abs()))
}

/// Time from the end of the ramp to the largest force, and the distance of the samples there (s).
fn kink_lag(test: &TestInspection) -> Option<(f64, f64)> {
    let c = test.cycles.first()?;
    let curve = &test.curve;
    let cycle = (0..curve.time_s.len()).filter(|&i| curve.time_s[i] <= c.times.hold_end_s);
    let peak = cycle.max_by(|a, b| curve.force_mn[*a].total_cmp(&curve.force_mn[*b]))?;
    let step = curve.time_s.get(peak + 1)? - curve.time_s[peak];
    Some((curve.time_s[peak] - c.times.ramp_end_s, step))
}
