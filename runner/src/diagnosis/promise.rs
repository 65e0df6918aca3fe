//! What an effect promises before it is refitted, and where its refit may begin.

/// A signature is not linear, but what promises less than this part of the largest gain is not the one that gains most.
pub(super) const PROMISING: f64 = 0.5;

/// What an effect would do for a fit, by its signature.
#[derive(Clone)]
pub(super) struct Promise {
    pub candidate: usize,
    pub magnitude: f64,
    /// Fall of chi^2.
    pub gain: f64,
    /// Twice the logarithm of the evidence.
    pub evidence: f64,
    /// Change of the fit's variables with the magnitude (of a switch, with it).
    pub giving_way: Vec<f64>,
}

/// What an effect promises, and the parameters around which it does.
#[derive(Clone)]
pub(super) struct Beginning<'a> {
    pub promise: Promise,
    /// Number of effects that promise more there.
    pub rank: usize,
    /// Whether that is the plain model's fit.
    pub is_at_fit: bool,
    pub x: &'a [f64],
    /// chi^2 of the plain model there.
    pub chi_square: f64,
}

/// Where an effect's refit may begin, the best place first.
pub(super) type Beginnings<'a> = Vec<Beginning<'a>>;
