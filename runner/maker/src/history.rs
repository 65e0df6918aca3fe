//! The force as a smooth function of time.

/// Forces (N) at the end of steps, in pieces between which the force may have a kink.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    times: Vec<f64>,
    forces: Vec<f64>,
    /// First index of every piece but the first; a kink belongs to both of its pieces.
    kinks: Vec<usize>,
}

impl History {
    /// One more step.
    pub fn push(&mut self, time: f64, force: f64) {
        self.times.push(time);
        self.forces.push(force);
    }

    /// The last point is a kink.
    pub fn kink(&mut self) {
        if self.times.len() > 1 {
            self.kinks.push(self.times.len() - 1);
        }
    }

    /// Times (s).
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Forces (N) at these times.
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// Another force (N) at the same times, from time (s) and force (N).
    #[must_use]
    pub fn map(&self, change: impl Fn(f64, f64) -> f64) -> Self {
        let forces = self.times.iter().zip(&self.forces).map(|(&t, &f)| change(t, f)).collect();
        Self { forces, ..self.clone() }
    }

    /// Slope at a point by the parabola through it and its neighbours of the piece.
    fn slope(&self, i: usize, first: usize, last: usize) -> f64 {
        let secant = |i: usize| (self.forces[i + 1] - self.forces[i]) / (self.times[i + 1] - self.times[i]);
        if last - first < 2 {
            return secant(first);
        }
        let j = i.clamp(first + 1, last - 1);
        let (a, b) = (secant(j - 1), secant(j));
        let bend = (b - a) / (self.times[j + 1] - self.times[j - 1]);
        let slope = a + bend * (2.0 * self.times[i] - self.times[j - 1] - self.times[j]);
        // No overshoot where contact begins or ends (Fritsch and Carlson): steep only with both neighbours.
        let limit = |slope: f64, secant: f64| match slope * secant > 0.0 {
            true => slope.signum() * slope.abs().min(3.0 * secant.abs()),
            false => 0.0,
        };
        let left = if i > first { limit(slope, secant(i - 1)) } else { slope };
        if i < last { limit(left, secant(i)) } else { left }
    }

    /// Force (N) at a time (s), by cubic interpolation within the piece; constant before and after.
    pub fn at(&self, time: f64) -> f64 {
        let n = self.times.len();
        let i = self.times.partition_point(|&t| t <= time);
        if i == 0 || i == n {
            return self.forces.get(i.min(n.saturating_sub(1))).copied().unwrap_or(0.0);
        }
        let piece = self.kinks.partition_point(|&k| k < i);
        let first = if piece == 0 { 0 } else { self.kinks[piece - 1] };
        let last = self.kinks.get(piece).copied().unwrap_or(n - 1);
        let step = self.times[i] - self.times[i - 1];
        let s = (time - self.times[i - 1]) / step;
        let (a, b) = (self.slope(i - 1, first, last) * step, self.slope(i, first, last) * step);
        let rise = self.forces[i] - self.forces[i - 1];
        self.forces[i - 1] + s * (rise + (1.0 - s) * ((a - rise) * (1.0 - s) + (rise - b) * s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_exact_up_to_the_kink() {
        let mut history = History::default();
        for t in [0.0f64, 0.1, 0.3, 0.6, 1.0] {
            history.push(t, t * t);
        }
        history.kink();
        for t in [1.1, 1.5, 2.0] {
            history.push(t, 1.0);
        }
        for t in [0.05f64, 0.2, 0.7, 0.99] {
            assert!((history.at(t) - t * t).abs() < 1e-12, "{t}");
        }
        assert!((history.at(1.3) - 1.0).abs() < 1e-12 && history.at(5.0) == 1.0 && history.at(-1.0) == 0.0);
    }
}
