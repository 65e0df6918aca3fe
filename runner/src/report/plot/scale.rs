//! From data to paper: linear and logarithmic axes with round ticks.

use super::symbols::exponent;

/// Kind of axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ScaleKind {
    /// Equal distances for equal differences.
    #[default]
    Linear,
    /// Equal distances for equal ratios; values that are not positive are not drawn.
    Log,
}

/// A logarithmic axis over a smaller ratio has the ticks of a linear one.
const NARROW: f64 = 5.0;

/// A range of data on a stretch of paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    kind: ScaleKind,
    data: (f64, f64),
    paper: (f64, f64),
}

impl Scale {
    /// A range that cannot be drawn (empty, without end, not positive on a logarithmic axis) gives an axis of its own.
    pub(super) fn new(kind: ScaleKind, data: (f64, f64), paper: (f64, f64)) -> Self {
        let is_finite = data.0.is_finite() && data.1.is_finite();
        let is_drawable = is_finite && data.0 < data.1 && (kind == ScaleKind::Linear || data.0 > 0.0);
        Self { kind, data: if is_drawable { data } else { (0.1, 1.0) }, paper }
    }

    /// The axis for the page's script: kind, range, place on paper.
    pub(super) fn told(&self) -> String {
        let kind = if self.kind == ScaleKind::Log { "log" } else { "linear" };
        format!("{kind} {} {} {:.1} {:.1}", self.data.0, self.data.1, self.paper.0, self.paper.1)
    }

    fn transform(&self, value: f64) -> f64 {
        match self.kind {
            ScaleKind::Linear => value,
            ScaleKind::Log => value.ln(),
        }
    }

    /// Position on paper, if the value can be drawn within the range.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let inside = value >= self.data.0 && value <= self.data.1;
        inside.then(|| self.place_clamped(value))
    }

    /// Position on paper, values outside the range at its ends.
    pub(super) fn place_clamped(&self, value: f64) -> f64 {
        let (a, b) = (self.transform(self.data.0), self.transform(self.data.1));
        let t = (self.transform(value.clamp(self.data.0, self.data.1)) - a) / (b - a);
        self.paper.0 + t * (self.paper.1 - self.paper.0)
    }

    /// Ticks with their labels; minor ones have none.
    pub(super) fn ticks(&self) -> Vec<(f64, Option<String>)> {
        match self.kind {
            ScaleKind::Linear => self.linear_ticks(),
            // Between two powers there may be no label at all.
            ScaleKind::Log if self.data.1 < NARROW * self.data.0 => self.linear_ticks(),
            ScaleKind::Log => self.log_ticks(),
        }
    }

    fn linear_ticks(&self) -> Vec<(f64, Option<String>)> {
        let (low, high) = self.data;
        let length = (self.paper.1 - self.paper.0).abs();
        let step = round_step((high - low) / (length / 50.0).clamp(5.0, 12.0));
        let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        let label = |k: i64| {
            let value = k as f64 * step;
            (value, Some(format!("{value:.decimals$}").replace('-', "−")))
        };
        (first..=last).map(label).collect()
    }

    fn log_ticks(&self) -> Vec<(f64, Option<String>)> {
        let (low, high) = self.data;
        let decades = (low.log10().floor() as i32)..=(high.log10().ceil() as i32);
        let many = decades.clone().count() > 9;
        let few = (high / low).log10() < 1.5;
        let mut ticks = vec![];
        for d in decades {
            for m in 1..10 {
                let value = m as f64 * 10f64.powi(d);
                if value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9) || (many && m > 1) {
                    continue;
                }
                let labelled = (m == 1 && (!many || d % 3 == 0)) || (few && matches!(m, 2 | 5));
                ticks.push((value, labelled.then(|| power_label(value, d))));
            }
        }
        ticks
    }
}

fn power_label(value: f64, decade: i32) -> String {
    if (-3..=3).contains(&decade) {
        return format!("{value:.*}", (-decade).max(0) as usize);
    }
    let mantissa = (value / 10f64.powi(decade)).round();
    let power = exponent(&decade.to_string());
    if mantissa == 1.0 { format!("10{power}") } else { format!("{mantissa}·10{power}") }
}

/// The round number (1, 2 or 5 times a power of ten) at or above `step`.
fn round_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    let mantissa = [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= step * 0.999).unwrap_or(10.0);
    mantissa * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale) -> Vec<String> {
        scale.ticks().into_iter().filter_map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let scale = Scale::new(ScaleKind::Linear, (-0.3, 12.7), (400.0, 0.0));
        assert_eq!(labels(&scale), ["0", "2", "4", "6", "8", "10", "12"]);
        let scale = Scale::new(ScaleKind::Log, (0.01, 95.0), (0.0, 500.0));
        assert_eq!(labels(&scale), ["0.01", "0.1", "1", "10"]);
        let scale = Scale::new(ScaleKind::Log, (1e-6, 2e-5), (0.0, 300.0));
        assert_eq!(labels(&scale), ["10⁻⁶", "2·10⁻⁶", "5·10⁻⁶", "10⁻⁵", "2·10⁻⁵"]);
        let scale = Scale::new(ScaleKind::Log, (2.3, 4.6), (0.0, 250.0));
        assert_eq!(labels(&scale), ["2.5", "3.0", "3.5", "4.0", "4.5"]);
    }

    #[test]
    fn a_range_without_end_has_few_ticks() {
        for data in [(f64::INFINITY, 90.0), (0.0, 1.0), (1.0, f64::NAN), (2.0, 2.0)] {
            let scale = Scale::new(ScaleKind::Log, data, (0.0, 500.0));
            assert!(scale.ticks().len() < 20 && scale.place_clamped(0.5).is_finite(), "{data:?}");
        }
    }

    #[test]
    fn places_ends_and_middle() {
        let scale = Scale::new(ScaleKind::Log, (1.0, 100.0), (10.0, 30.0));
        assert!((scale.place(10.0).unwrap() - 20.0).abs() < 1e-12);
        assert_eq!(scale.place(0.0), None);
        assert_eq!(scale.place_clamped(1e9), 30.0);
    }
}
