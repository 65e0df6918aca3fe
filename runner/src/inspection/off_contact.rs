//! What the load cell shows while the punch touches nothing: noise and drift.

use super::trace::Trace;
use crate::data::motion::sample_noise;
use crate::data::{Cycle, Estimate};
use crate::noise::correlated::{FEWEST_IN_RECORD, Record};

/// Stretches in which the punch does not touch, for the noise: from the end of each withdrawal (films that
/// follow the punch have torn by then) to the next loading.
pub(super) fn records(trace: &Trace) -> Vec<Record> {
    let record = |range: std::ops::Range<usize>| Record {
        time_s: trace.time_s[range.clone()].to_vec(),
        values: trace.force_n[range].to_vec(),
    };
    let recoveries: Vec<Record> = trace
        .cycles
        .iter()
        .filter_map(|c| Some(record(trace.between(c.times.withdrawn_s?, c.times.end_s))))
        .collect();
    if recoveries.iter().any(|r| r.values.len() >= FEWEST_IN_RECORD) {
        return recoveries;
    }
    // A test that ends in the hold has only its approach, of which the first half is surely in the air.
    trace.cycles.first().map(|c| record(first_half_of_approach(trace, c))).into_iter().collect()
}

/// White noise from the last decade of the holds (N): how far samples are from the line between their
/// neighbours. For tests that have next to nothing off contact; it sees no correlated noise.
pub(super) fn white_of_holds(traces: &[Trace]) -> Option<(Estimate, usize)> {
    let (mut square, mut samples) = (0.0, 0);
    for trace in traces {
        for c in &trace.cycles {
            let late = trace.between(c.times.ramp_end_s + 0.1 * c.hold_s(), c.times.hold_end_s);
            let points: Vec<(f64, f64)> = late.map(|i| (trace.time_s[i], trace.force_n[i])).collect();
            let n = points.len();
            square += sample_noise(&points).powi(2) * n as f64;
            samples += if n >= 22 { n } else { 0 };
        }
    }
    // A median of absolute values knows a deviation 1.65 times less well than the root of the mean square.
    let value = (square / samples as f64).sqrt();
    let sigma = 1.65 * value / (2.0 * samples as f64).sqrt();
    (samples > 0 && value > 0.0).then_some((Estimate { value, sigma }, samples))
}

/// Approach, as far as the punch is further from the surface than half of its start.
fn first_half_of_approach(trace: &Trace, cycle: &Cycle) -> std::ops::Range<usize> {
    let approach = trace.between(cycle.times.start_s, cycle.times.ramp_start_s);
    let start = trace.displacement_m.get(approach.start).copied().unwrap_or(0.0);
    let near = approach.clone().find(|&i| trace.displacement_m[i] > 0.5 * start);
    approach.start..near.unwrap_or(approach.end)
}

/// Mean force before a cycle: in the second half of the rest before it, or on approach (N).
pub(super) fn before_n(trace: &Trace, index: usize) -> Option<Estimate> {
    let cycle = trace.cycles.get(index)?;
    let previous = index.checked_sub(1).and_then(|i| trace.cycles.get(i));
    match previous.and_then(|p| p.times.withdrawn_s) {
        Some(withdrawn) => {
            mean(trace, trace.between(0.5 * (withdrawn + cycle.times.start_s), cycle.times.start_s))
        }
        None => mean(trace, first_half_of_approach(trace, cycle)),
    }
}

/// Mean force after a cycle, from the end of the withdrawal on (N).
pub(super) fn after_n(trace: &Trace, index: usize) -> Option<Estimate> {
    let cycle = trace.cycles.get(index)?;
    mean(trace, trace.between(cycle.times.withdrawn_s?, cycle.times.end_s))
}

/// Mean with its standard error, as of independent samples.
fn mean(trace: &Trace, range: std::ops::Range<usize>) -> Option<Estimate> {
    let forces = &trace.force_n[range];
    let n = forces.len() as f64;
    if forces.len() < 2 {
        return None;
    }
    let value = forces.iter().sum::<f64>() / n;
    Some(Estimate { value, sigma: crate::data::measurement::standard_deviation(forces) / n.sqrt() })
}

/// Mean over specimens: their scatter tells the error where there are three or more.
pub(super) fn over_specimens(values: &[Estimate]) -> Option<Estimate> {
    let n = values.len() as f64;
    if values.is_empty() {
        return None;
    }
    let means: Vec<f64> = values.iter().map(|e| e.value).collect();
    let value = means.iter().sum::<f64>() / n;
    let own = values.iter().map(|e| e.sigma.powi(2)).sum::<f64>().sqrt() / n;
    let scatter = crate::data::measurement::standard_deviation(&means) / n.sqrt();
    Some(Estimate { value, sigma: if values.len() >= 3 { scatter.max(own) } else { own } })
}
