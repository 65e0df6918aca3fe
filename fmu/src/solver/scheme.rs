//! Time schemes as sequences of implicit Euler stages.
//!
//! A stage is a backward Euler step of `fraction * dt` from a starting history. The two-stage SDIRK
//! method (gamma = 1 - 1/sqrt 2: L-stable, stiffly accurate, order 2) is two such stages; the second
//! starts from the history continued through the first, `q_n + (1 - gamma)/gamma (q_1 - q_n)`.
//! The continuation is linear in J and in the logarithmic strains of the first stage's frame, which
//! keeps the viscous flow volume-preserving and the order two at finite strain.

use crate::solver::parameters::TimeScheme;

/// One implicit stage of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SchemeStage {
    /// Its length as a fraction of the step: the diagonal coefficient.
    pub fraction: f64,
    /// Time of the stage within the step, as a fraction.
    pub time: f64,
    /// Quadrature weight of the stage.
    pub weight: f64,
    /// How far the history is continued for the next stage (1: the stage's own end).
    pub reach: f64,
}

const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

const BACKWARD_EULER: [SchemeStage; 1] = [SchemeStage { fraction: 1.0, time: 1.0, weight: 1.0, reach: 1.0 }];
const SDIRK2: [SchemeStage; 2] = [
    SchemeStage { fraction: GAMMA, time: GAMMA, weight: 1.0 - GAMMA, reach: (1.0 - GAMMA) / GAMMA },
    SchemeStage { fraction: GAMMA, time: 1.0, weight: GAMMA, reach: 1.0 },
];

/// The stages of a scheme.
pub fn stages(scheme: TimeScheme) -> &'static [SchemeStage] {
    match scheme {
        TimeScheme::BackwardEuler => &BACKWARD_EULER,
        TimeScheme::Sdirk2 => &SDIRK2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stages reproduce the scheme's stability function on `y' = -y` with the right order.
    #[test]
    fn order_of_convergence() {
        for (scheme, order) in [(TimeScheme::BackwardEuler, 1), (TimeScheme::Sdirk2, 2)] {
            let error = |n: usize| {
                let dt = 1.0 / n as f64;
                let mut y = 1.0;
                for _ in 0..n {
                    let mut start = y;
                    for stage in stages(scheme) {
                        y = start / (1.0 + stage.fraction * dt);
                        start += stage.reach * (y - start);
                    }
                }
                (y - (-1.0_f64).exp()).abs()
            };
            let observed = (error(50) / error(100)).log2();
            assert!((observed - f64::from(order)).abs() < 0.1, "{scheme:?}: {observed}");
        }
    }
}
