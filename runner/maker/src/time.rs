//! The formula in time: BDF2 with variable steps, started by backward Euler.

/// `y = start(y_last, y_before) + gamma dy/dt`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Formula {
    last: f64,
    before: f64,
    /// gamma (s).
    pub gamma: f64,
    /// The step (s).
    pub step: f64,
}

impl Formula {
    /// Backward Euler.
    pub fn first_order(step: f64) -> Self {
        Self { last: 1.0, before: 0.0, gamma: step, step }
    }

    /// BDF2 after a step of `previous` (s).
    pub fn second_order(step: f64, previous: f64) -> Self {
        let ratio = step / previous;
        let below = 1.0 / (1.0 + 2.0 * ratio);
        Self {
            last: (1.0 + ratio) * (1.0 + ratio) * below,
            before: -ratio * ratio * below,
            gamma: step * (1.0 + ratio) * below,
            step,
        }
    }

    /// This formula with a share of backward Euler's over the same step.
    #[must_use]
    pub fn with_first_order(self, share: f64) -> Self {
        let (first, own) = (Self::first_order(self.step), 1.0 - share);
        Self {
            last: share * first.last + own * self.last,
            before: own * self.before,
            gamma: share * first.gamma + own * self.gamma,
            step: self.step,
        }
    }

    /// Combination of the two last values.
    pub fn start<const N: usize>(&self, last: &[f64; N], before: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| self.last * last[i] + self.before * before[i])
    }
}
