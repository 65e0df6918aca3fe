//! One specimen's force with the cycles of its own motion.

use crate::data::measurement::interpolated;
use crate::data::{Cycle, DataError, Measurement, Synchronised, cycles};
use std::ops::Range;

/// Force and displacement of one specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace<'a> {
    /// Times (s).
    pub time_s: &'a [f64],
    /// Displacement (m).
    pub displacement_m: &'a [f64],
    /// Force (N).
    pub force_n: &'a [f64],
    /// Cycles of the motion.
    pub cycles: Vec<Cycle>,
    /// Standard deviation of the noise of a displacement sample (m).
    pub displacement_noise_m: f64,
}

impl<'a> Trace<'a> {
    /// Every specimen of a test at the times that it was measured.
    ///
    /// # Errors
    /// When a displacement has no cycles.
    pub fn of_all(test: &'a Synchronised) -> Result<Vec<Self>, DataError> {
        let mut traces = Vec::new();
        // Resampling changes noise and peaks, so each file speaks for itself.
        let files: Vec<&Measurement> =
            if test.originals.is_empty() { vec![&test.measurement] } else { test.originals.iter().collect() };
        for m in files {
            let cycles = cycles(m)?;
            let noise = crate::data::motion::motion(&m.time_s, &m.displacement_m).noise_m;
            let curves = if test.originals.is_empty() { m.curves_n() } else { vec![m.force_n.as_slice()] };
            traces.extend(curves.into_iter().map(|force_n| Self {
                time_s: &m.time_s,
                displacement_m: &m.displacement_m,
                force_n,
                cycles: cycles.clone(),
                displacement_noise_m: noise,
            }));
        }
        Ok(traces)
    }

    /// Indices between two times.
    pub fn between(&self, from_s: f64, to_s: f64) -> Range<usize> {
        let first = self.time_s.partition_point(|&t| t < from_s);
        let last = self.time_s.partition_point(|&t| t <= to_s);
        first..last.max(first)
    }

    /// Largest force from the beginning of a cycle to the end of its hold (N).
    pub fn peak_n(&self, cycle: &Cycle) -> Option<f64> {
        let range = cycle.points(self.time_s, cycle.times.start_s, cycle.times.hold_end_s);
        self.force_n[range].iter().copied().max_by(f64::total_cmp)
    }

    /// Force some time after the end of the ramp (N), smoothed: the line in logarithmic time through the
    /// samples within 15 %. None beyond the hold.
    pub fn force_after_n(&self, cycle: &Cycle, after_s: f64) -> Option<f64> {
        const WITHIN: f64 = 1.15;
        const BEYOND: f64 = 1.005;
        if after_s > BEYOND * cycle.hold_s() || after_s <= 0.0 {
            return None;
        }
        let at = |s: f64| cycle.times.ramp_end_s + s;
        let near = self.between(at(after_s / WITHIN), at(after_s * WITHIN).min(cycle.times.hold_end_s));
        let points: Vec<(f64, f64)> =
            near.map(|i| ((self.time_s[i] - cycle.times.ramp_end_s).ln(), self.force_n[i])).collect();
        if points.len() < 3 {
            let until_end_s = at(after_s).min(cycle.times.hold_end_s);
            return interpolated(self.time_s, self.force_n, until_end_s);
        }
        let n = points.len() as f64;
        let (x0, y0) =
            (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let square: f64 = points.iter().map(|p| (p.0 - x0).powi(2)).sum();
        let slope = points.iter().map(|p| (p.0 - x0) * (p.1 - y0)).sum::<f64>() / square;
        Some(y0 + slope * (after_s.ln() - x0))
    }

    /// Smallest force while the punch is pulled off; none without an unloading.
    pub fn pull(&self, cycle: &Cycle) -> Option<Pull> {
        cycle.unload?;
        let withdrawn = cycle.times.withdrawn_s.unwrap_or(cycle.times.end_s);
        let stroke = self.between(cycle.times.hold_end_s, withdrawn);
        // A film may tear when the stroke has ended: as long again, but no drift of minutes.
        let rest = self.between(withdrawn, (2.0 * withdrawn - cycle.times.hold_end_s).min(cycle.times.end_s));
        let last = self.between(cycle.times.start_s, cycle.times.end_s).end;
        let rest = stroke.end..rest.end.max(stroke.end + REST_SAMPLES).min(last).max(stroke.end);
        let base_n = self.force_n[rest.clone()].iter().sum::<f64>() / rest.len().max(1) as f64;
        let forces = &self.force_n[stroke.start..rest.end];
        let minimum_n = forces.iter().copied().min_by(f64::total_cmp)?;
        Some(Pull { minimum_n, samples: forces.len(), base_n })
    }
}

/// At least so many samples after a withdrawal tell the force off contact there.
const REST_SAMPLES: usize = 4;

/// Force while the punch is pulled off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pull {
    /// Smallest force (N).
    pub minimum_n: f64,
    /// Of so many samples.
    pub samples: usize,
    /// Mean force just after the withdrawal (N); 0 where nothing was measured there.
    pub base_n: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    fn test(noise_n: f64, seed: u64) -> Synchronised {
        let mut random = Random::new(seed);
        let time_s: Vec<f64> = (0..1200).map(|i| 0.02 * f64::from(i)).collect();
        let d = |t: f64| if t < 12.0 { (1e-3 * (t - 0.1)).min(1e-3) } else { 1e-3 * (13.0 - t).max(-1.0) };
        let f = |t: f64| {
            let since = t - 1.1;
            let held =
                if since < 0.0 { 8e-3 * (t - 0.1).max(0.0) } else { 5e-3 + 3e-3 * (-since / 3.0).exp() };
            let adhesion = if (13.0..13.1).contains(&t) { -1e-3 } else { 0.0 };
            if t < 12.0 { held } else { (held * (13.0 - t)).max(0.0) + adhesion }
        };
        let measurement = Measurement {
            displacement_m: time_s.iter().map(|&t| d(t)).collect(),
            force_n: time_s.iter().map(|&t| f(t) + noise_n * random.normal()).collect(),
            time_s,
            ..Measurement::default()
        };
        Synchronised { measurement, originals: vec![], shifts_s: vec![] }
    }

    #[test]
    fn readings_are_those_of_the_curve() {
        let test = test(0.0, 0);
        let trace = &Trace::of_all(&test).unwrap()[0];
        let cycle = &trace.cycles[0];
        assert!((trace.peak_n(cycle).unwrap() - 8e-3).abs() < 1e-9);
        for after in [1.0_f64, 3.0, 10.0, cycle.hold_s()] {
            let expected = 5e-3 + 3e-3 * (-after / 3.0).exp();
            let got = trace.force_after_n(cycle, after).unwrap();
            assert!((got / expected - 1.0).abs() < 5e-3, "{after}: {got} {expected}");
        }
        assert_eq!(trace.force_after_n(cycle, 20.0), None);
        assert_eq!(trace.pull(cycle).unwrap().minimum_n, -1e-3);
    }

    #[test]
    fn drift_over_the_rest_is_not_taken_for_a_pull() {
        let mut test = test(0.0, 0);
        let m = &mut test.measurement;
        for i in 0..m.len() {
            m.force_n[i] -= 0.05e-3 * m.time_s[i];
        }
        let trace = &Trace::of_all(&test).unwrap()[0];
        let pull = trace.pull(&trace.cycles[0]).unwrap();
        // 13.1 s: the end of the adhesion; 14 to 16 s: the rest that is looked at.
        assert!((pull.minimum_n + 1e-3 + 0.05e-3 * 13.08).abs() < 0.01e-3, "{pull:?}");
        assert!((pull.base_n + 0.05e-3 * 15.0).abs() < 0.01e-3, "{pull:?}");
    }

    #[test]
    fn smoothing_takes_noise_away() {
        let errors: Vec<f64> = (0..40)
            .map(|seed| {
                let test = test(0.1e-3, seed);
                let trace = &Trace::of_all(&test).unwrap()[0];
                trace.force_after_n(&trace.cycles[0], 5.0).unwrap() - (5e-3 + 3e-3 * (-5.0_f64 / 3.0).exp())
            })
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 40.0).sqrt();
        assert!(rms < 0.03e-3, "{rms}");
    }
}
