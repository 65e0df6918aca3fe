//! A fitted value with its interval.

use super::{DETERMINED_HALF_WIDTH, UNDETERMINED_HALF_WIDTH};
use crate::inference::parameter::{FitParameter, Transform};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A 95 % interval, within the parameter's bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// How well a value is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Determination {
    /// To a quarter or better.
    Determined,
    /// Between a quarter and a factor of three.
    Loose,
    /// Not even to a factor of three.
    Undetermined,
    /// Its interval holds for this division into branches only, which the data do not tell from others.
    Unresolved,
}

impl Determination {
    /// Classifies a half-width in ln(value).
    pub fn of(half_width: f64) -> Self {
        if half_width <= DETERMINED_HALF_WIDTH {
            Self::Determined
        } else if half_width <= UNDETERMINED_HALF_WIDTH {
            Self::Loose
        } else {
            Self::Undetermined
        }
    }

    /// The same of what the data do not tell from another division into branches, where that is so.
    #[must_use]
    pub fn unresolved_if(self, is_arbitrary: bool) -> Self {
        match self {
            Self::Determined | Self::Loose if is_arbitrary => Self::Unresolved,
            other => other,
        }
    }
}

/// End of the admissible range at which a value sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundSide {
    /// The lower bound of the value.
    Lower,
    /// The upper bound of the value.
    Upper,
}

impl BoundSide {
    fn other(self) -> Self {
        match self {
            Self::Lower => Self::Upper,
            Self::Upper => Self::Lower,
        }
    }
}

/// One fitted parameter, values in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterEstimate {
    /// The parameter.
    pub parameter: FitParameter,
    /// Fitted value.
    pub value: f64,
    /// 95 % interval, cut at the bounds.
    pub interval: Interval,
    /// The interval reaches the lower or upper bound: the data set no limit on that side.
    pub open: [bool; 2],
    /// Half of the uncut interval's width, relative (in ln(value) for log parameters).
    pub half_width: f64,
    /// Part of its square that comes from common errors (0 to 1).
    pub common_share: f64,
    /// How well it is known.
    pub determination: Determination,
    /// Sits at this bound.
    pub at_bound: Option<BoundSide>,
}

/// Of a variable of the optimiser whose interval reaches so far down and up.
pub(super) fn of_variable(
    p: &FitParameter,
    x: f64,
    [down, up]: [f64; 2],
    common_share: f64,
) -> ParameterEstimate {
    let (low, high) = p.internal_bounds();
    let reach = |x: f64| p.to_value(x.clamp(low, high));
    let (a, b) = (reach(x - down), reach(x + up));
    let mut open = [x - down <= low, x + up >= high];
    let near = 0.01 * (high - low).min(1.0);
    let mut at_bound = match () {
        () if x - low < near => Some(BoundSide::Lower),
        () if high - x < near => Some(BoundSide::Upper),
        () => None,
    };
    if let Transform::Logarithmic { negative: true } = p.transform {
        open.swap(0, 1);
        at_bound = at_bound.map(BoundSide::other);
    }
    let half_width = 0.5 * (down + up) * p.relative_slope(x);
    built(p, p.to_value(x), [a, b], open, half_width, common_share, at_bound)
}

/// Of a product of powers of the variables, whose logarithm's interval reaches so far down and up; `bound` is where one of the variables
/// sits, and the power.
pub(super) fn of_product(
    p: &FitParameter,
    value: f64,
    [down, up]: [f64; 2],
    common_share: f64,
    bound: Option<(BoundSide, f64)>,
) -> ParameterEstimate {
    let ends = [value * (-down).exp(), value * up.exp()];
    let (a, b) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    let open = [a <= p.lower, b >= p.upper];
    let at_bound = bound.map(|(side, power)| if power * value < 0.0 { side.other() } else { side });
    built(p, value, [a.max(p.lower), b.min(p.upper)], open, 0.5 * (down + up), common_share, at_bound)
}

fn built(
    p: &FitParameter,
    value: f64,
    ends: [f64; 2],
    open: [bool; 2],
    half_width: f64,
    common_share: f64,
    at_bound: Option<BoundSide>,
) -> ParameterEstimate {
    // A value a rounding error outside its own cut interval would look like a mistake.
    let lower = ends[0].min(ends[1]).min(value);
    let upper = ends[0].max(ends[1]).max(value);
    ParameterEstimate {
        parameter: p.clone(),
        value,
        interval: Interval { lower, upper },
        open,
        half_width,
        common_share,
        determination: Determination::of(half_width),
        at_bound,
    }
}
