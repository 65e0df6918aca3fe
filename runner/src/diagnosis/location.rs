//! Where the fit misses: level and tilt of the residual in each phase of each cycle, and exponentials of the
//! relaxation times, each a signature of its own, so that each score is standard normal under noise after a refit.

use crate::data::Phase;
use crate::fit::Whitening;
use crate::inference::{Linearised, Signature};
use crate::noise::Observation;
use nalgebra::DVector;

/// What a pattern of the residual is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pattern {
    /// The phase is too high or too low.
    Level,
    /// The phase begins too high and ends too low, or the other way round.
    Tilt,
    /// The holds relax by too much or too little at this time scale (s).
    Relaxation(f64),
}

/// A place where the residual is looked at.
#[derive(Debug, Clone)]
pub struct Spot {
    /// Index of the test.
    pub test: usize,
    /// Cycle, counted from 0; all of them for a relaxation time.
    pub cycle: Option<usize>,
    /// Phase; the whole hold for a relaxation time.
    pub phase: Option<Phase>,
    /// What is looked for.
    pub pattern: Pattern,
    /// Its shape, 1 mN large, after refit.
    pub signature: Signature,
    /// Points in it.
    pub points: Vec<usize>,
}

/// Relaxation times that are looked for (s).
const TIMES_S: [f64; 8] = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
/// Fewest points of a phase that have a tilt.
const FEWEST_FOR_TILT: usize = 4;
/// A pattern of which a refit leaves less than this cannot be seen at all.
const LEFT: f64 = 1e-6;

/// All spots of some tests, whose points follow one another.
pub fn spots<W: Whitening>(observations: &[Observation], fit: &Linearised, whitening: &W) -> Vec<Spot> {
    let total: usize = observations.iter().map(Observation::len).sum();
    let mut spots = Vec::new();
    let mut before = 0;
    for (test, o) in observations.iter().enumerate() {
        let mut add = |cycle, phase, pattern, points: Vec<usize>, shape: &dyn Fn(usize) -> f64| {
            let mut d = DVector::zeros(total);
            points.iter().for_each(|&i| d[before + i] = shape(i));
            let signature = fit.signature(whitening, &d);
            if signature.norm > 0.0 && signature.strength() > LEFT * signature.norm {
                let points = points.iter().map(|i| before + i).collect();
                spots.push(Spot { test, cycle, phase, pattern, signature, points });
            }
        };
        for cycle in 0..o.cycles.len() {
            for phase in Phase::ALL {
                let inside = |i: &usize| o.cycle[*i] == cycle && o.phases[*i] == phase;
                let points: Vec<usize> = (0..o.len()).filter(inside).collect();
                let (Some(&first), Some(&last)) = (points.first(), points.last()) else { continue };
                add(Some(cycle), Some(phase), Pattern::Level, points.clone(), &|_| 1.0);
                if points.len() >= FEWEST_FOR_TILT {
                    let middle = 0.5 * (first + last) as f64;
                    let half = 0.5 * (last - first) as f64;
                    let tilt = |i: usize| (i as f64 - middle) / half;
                    add(Some(cycle), Some(phase), Pattern::Tilt, points, &tilt);
                }
            }
        }
        let hold = |phase| matches!(phase, Phase::HoldEarly | Phase::HoldMiddle | Phase::HoldLate);
        let points: Vec<usize> = (0..o.len()).filter(|&i| hold(o.phases[i])).collect();
        let since = |i: usize| o.measurement.time_s[i] - o.cycles[o.cycle[i]].times.ramp_end_s;
        for time_s in TIMES_S {
            let decay = |i: usize| (-since(i).max(0.0) / time_s).exp();
            add(None, None, Pattern::Relaxation(time_s), points.clone(), &decay);
        }
        before += o.len();
    }
    spots
}
