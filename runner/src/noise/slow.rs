//! Noise that a load cell remembers for a while: its zero wanders.

use super::Common;
use super::correlated::{FEWEST_IN_RECORD, NoiseParts, Record, noise_parts};
use super::numerical::hat_at;
use super::observation::Observation;
use nalgebra::DVector;

/// Most knots over a test: that many common errors cost no more than a model's run.
const MOST_KNOTS: f64 = 60.0;

/// Noise while the punch is in the air after a withdrawal, of every specimen.
pub fn off_contact(observation: &Observation) -> Option<NoiseParts> {
    let m = &observation.measurement;
    let stretch = |cycle: &crate::data::Cycle| {
        cycle.times.withdrawn_s.map(|from| cycle.points(&m.time_s, from, cycle.times.end_s))
    };
    let stretches: Vec<_> = observation.cycles.iter().filter_map(stretch).collect();
    let records: Vec<Record> = m
        .curves_n()
        .into_iter()
        .flat_map(|curve| {
            stretches.iter().map(|range| Record {
                time_s: m.time_s[range.clone()].to_vec(),
                values: curve[range.clone()].to_vec(),
            })
        })
        .filter(|r| r.values.len() >= FEWEST_IN_RECORD)
        .collect();
    (!records.is_empty()).then(|| noise_parts(&records)).flatten()
}

/// A noise of this deviation (mN) that is remembered for a time (s), with correlation `exp(-lag / time)`: an autoregressive value at
/// each knot, straight between two. Knots are a memory apart, or farther: then the values at them are smaller, so that long means are as
/// uncertain. Where no memory is known, it is the knots' distance.
pub fn slow_noise(
    observation: &Observation,
    what: &str,
    sigma_mn: f64,
    memory_s: Option<f64>,
) -> Vec<Common> {
    let t = &observation.time_s;
    let (first, last) = (t[0], t[t.len() - 1]);
    let shortest_s = (last - first) / MOST_KNOTS;
    let memory_s = memory_s.unwrap_or(shortest_s);
    let width_s = memory_s.max(shortest_s);
    let ratio = width_s / memory_s;
    let kept = (-ratio).exp();
    // The power at low frequencies, 2 sigma^2 memory, is that of the values: variance width (1 + kept) / (1 - kept).
    let at_knot_mn = sigma_mn * (2.0 / ratio * (0.5 * ratio).tanh()).sqrt();
    let knots = ((last - first) / width_s).ceil() as i32;
    // What is new at a knot fades over the later ones.
    let mut fading = DVector::zeros(t.len());
    let mut common = Vec::new();
    for k in (0..=knots).rev() {
        let hat = |t: &f64| hat_at((t - first) / width_s, k);
        fading = fading * kept + DVector::from_iterator(t.len(), t.iter().map(hat));
        let new = if k == 0 { 1.0 } else { (1.0 - kept * kept).sqrt() };
        let name = format!("{what} of {}, part {k}", observation.name());
        common.push(Common::additive(name, &fading * (at_knot_mn * new)));
    }
    common.retain(|c| c.shape_mn.amax() > 0.0);
    common
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Measurement;

    /// A ramp of 1 s and a hold, 1001 samples, 0.1 s apart.
    fn observation() -> Observation {
        let time_s: Vec<f64> = (0..1001).map(|i| 0.1 * f64::from(i)).collect();
        let displacement_m: Vec<f64> = time_s.iter().map(|t| 1e-3 * t.min(1.0)).collect();
        let force_n = displacement_m.iter().map(|d| 10.0 * d).collect();
        let m = Measurement { name: "P".into(), time_s, displacement_m, force_n, ..Measurement::default() };
        Observation::new(&m, None).unwrap()
    }

    /// Of an Ornstein-Uhlenbeck process the mean over a time T has the variance
    /// `2 sigma^2 (tau / T) (1 - (tau / T) (1 - exp(-T / tau)))`.
    #[test]
    fn means_are_as_uncertain_as_those_of_a_wandering_zero() {
        let observation = observation();
        for memory_s in [0.3, 2.0, 10.0, 40.0, 300.0] {
            let noise = slow_noise(&observation, "slow noise", 3.0, Some(memory_s));
            for samples in [50, 150, 400, 800] {
                let mean = |c: &Common| c.shape_mn.rows(100, samples).mean();
                let variance: f64 = noise.iter().map(|c| mean(c).powi(2)).sum();
                let part = memory_s / (0.1 * samples as f64);
                let expected = 18.0 * part * (1.0 - part * (1.0 - (-1.0 / part).exp()));
                let ratio = variance / expected;
                assert!((0.7..1.2).contains(&ratio), "{memory_s} s, {samples} samples: {ratio}");
            }
        }
    }
}
