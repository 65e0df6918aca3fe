//! What a cause does to the motion, of which the record knows nothing.

use super::form::Form;

impl Form {
    /// The true motion, of points (s, m), of which the record knows nothing.
    pub fn moved(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        match *self {
            Self::ShiftedSurface { height } => points.iter().map(|&(t, d)| (t, d + height)).collect(),
            Self::Overshoot { length, frequency, decay_s } => {
                const PER_PERIOD: f64 = 12.0;
                let swing =
                    |s: f64| length * (-s / decay_s).exp() * (std::f64::consts::TAU * frequency * s).sin();
                let step = 1.0 / (PER_PERIOD * frequency);
                let times = (1..).map(|k| f64::from(k) * step).take_while(|s| *s < 6.0 * decay_s);
                in_holds(points, &times.collect::<Vec<_>>(), &swing)
            }
            Self::WarmingFrame { length, time_s } => {
                const PER_DECADE: f64 = 4.0;
                let times = (-8..8).map(|k| time_s * 10f64.powf(f64::from(k) / PER_DECADE));
                in_holds(points, &times.collect::<Vec<_>>(), &|s| length * (1.0 - (-s / time_s).exp()))
            }
            _ => points.to_vec(),
        }
    }
}

/// A motion with `more(s)` added `s` seconds into each hold at the largest depth, at `times` after its begin; it goes from the
/// last of them on.
fn in_holds(points: &[(f64, f64)], times: &[f64], more: &dyn Fn(f64) -> f64) -> Vec<(f64, f64)> {
    const END_S: f64 = 1e-3;
    let deepest = points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    let mut moved = Vec::new();
    for pair in points.windows(2) {
        moved.push(pair[0]);
        if pair[0].1 == deepest && pair[1].1 == deepest {
            let inside = times.iter().filter(|s| pair[0].0 + *s < pair[1].0 - END_S);
            moved.extend(inside.map(|&s| (pair[0].0 + s, deepest + more(s))));
        }
    }
    moved.extend(points.last().copied());
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swing_is_in_the_hold_only() {
        let points = [(0.0, -1.0), (2.0, 1.0), (92.0, 1.0)];
        let overshoot = Form::Overshoot { length: 0.1, frequency: 3.0, decay_s: 0.2 };
        let moved = overshoot.moved(&points);
        assert!(moved.windows(2).all(|w| w[1].0 > w[0].0) && moved.len() > 20);
        assert!(moved.iter().map(|p| p.1).fold(0.0, f64::max) > 1.05);
        assert_eq!((moved[0], moved[1], moved[moved.len() - 1]), (points[0], points[1], points[2]));
    }
}
