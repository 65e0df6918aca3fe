//! Load-cell lag: a first-order low pass between the force and its reading, `T dy/dt = F - y`.
//!
//! The force between two steps is a polynomial (see the path in `motion`); the convolution with the
//! exponential is integrated to rounding, always from the last step's end, so that the reading does not
//! depend on when it is asked for.

/// Past beyond this many time constants is forgotten to rounding.
const MEMORY: f64 = 40.0;
/// Abscissae and weights of the 5-point Gauss rule on [-1, 1].
const RULE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// How the reading follows from that at `from` and from the force's values, which the weights `lagrange`
/// interpolate: factor of the old reading, and factors of the values. `time_constant` is positive.
pub(super) fn response(
    time_constant: f64,
    (from, to): (f64, f64),
    lagrange: impl Fn(f64) -> Vec<f64>,
) -> (f64, Vec<f64>) {
    let kernel = |weight: f64, age: f64| weight * (-age / time_constant).exp() / time_constant;
    let factors = convolve((time_constant, 1.0), (from, to), lagrange, kernel);
    ((-(to - from).max(0.0) / time_constant).exp(), factors)
}

/// Derivatives of these factors by the time constant (1/s).
pub(super) fn response_slope(
    time_constant: f64,
    (from, to): (f64, f64),
    lagrange: impl Fn(f64) -> Vec<f64>,
) -> (f64, Vec<f64>) {
    let rate = 1.0 / time_constant;
    let kernel = |weight: f64, age: f64| weight * (-age * rate).exp() * rate * rate * (age * rate - 1.0);
    // The rule needs shorter panels for a kernel that turns.
    let factors = convolve((time_constant, 2.0), (from, to), lagrange, kernel);
    let age = (to - from).max(0.0) * rate;
    ((-age).exp() * age * rate, factors)
}

/// Integrals of a kernel that decays with the time constant over the past back to `from`, times the weights `lagrange`;
/// `kernel` takes the weight of an age and the age; so many `panels` a time constant.
fn convolve(
    (time_constant, panels): (f64, f64),
    (from, to): (f64, f64),
    lagrange: impl Fn(f64) -> Vec<f64>,
    kernel: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let length = (to - from).max(0.0);
    let memory = length.min(MEMORY * time_constant);
    let panels = (panels * (memory / time_constant)).ceil().max(1.0);
    let width = memory / panels;
    let mut factors = lagrange(to);
    factors.fill(0.0);
    for panel in 0..panels as usize {
        for (x, weight) in RULE {
            let age = width * (panel as f64 + 0.5 + 0.5 * x);
            let kernel = kernel(0.5 * width * weight, age);
            for (factor, value) in factors.iter_mut().zip(lagrange(to - age)) {
                *factor += kernel * value;
            }
        }
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ramp `F = t`: `y = t - T + T exp(-t / T)`; also in two parts and for steps far beyond `T`.
    #[test]
    fn follows_a_ramp() {
        let lagrange = |t: f64| vec![1.0 - t, t];
        for (time_constant, end) in [(0.3_f64, 0.1), (0.3, 2.0), (1e-3, 5.0), (1e3, 0.5)] {
            let closed = end + time_constant * (-end / time_constant).exp_m1();
            let (_, whole) = response(time_constant, (0.0, end), lagrange);
            assert!((whole[1] - closed).abs() < 1e-12 * end, "{} {closed}", whole[1]);
            let (_, first) = response(time_constant, (0.0, 0.4 * end), lagrange);
            let (decay, second) = response(time_constant, (0.4 * end, end), lagrange);
            assert!((decay * first[1] + second[1] - closed).abs() < 1e-12 * end);
        }
    }

    /// The same ramp's `dy/dT = (1 + t / T) exp(-t / T) - 1`, also in two parts.
    #[test]
    fn changes_with_the_time_constant() {
        let lagrange = |t: f64| vec![1.0 - t, t];
        for (time_constant, end) in [(0.3_f64, 0.1), (0.3, 2.0), (1e-3, 5.0), (1e3, 0.5)] {
            let age = end / time_constant;
            let closed = (-age).exp_m1() + age * (-age).exp();
            let middle = 0.4 * end;
            let (_, reading) = response(time_constant, (0.0, middle), lagrange);
            let (_, by_constant) = response_slope(time_constant, (0.0, middle), lagrange);
            let (decay, _) = response(time_constant, (middle, end), lagrange);
            let (slope, whole) = response_slope(time_constant, (middle, end), lagrange);
            let sum = decay * by_constant[1] + slope * reading[1] + whole[1];
            // Values of the ramp over the time constant cancel.
            assert!((sum - closed).abs() < 1e-13 * (1.0 + age), "{sum} {closed}");
        }
    }
}
