//! Tolerances and limits of a fit.

/// How the variables are scaled, apart from the bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scaling {
    /// As they are: right for log parameters, where a unit step is a factor e.
    #[default]
    Unit,
    /// By the largest norm of each Jacobian column so far (Moré): for variables of mixed units.
    Jacobian,
}

/// Tolerances and limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Stop when the bound-scaled gradient falls below this times half the initial chi^2.
    pub gradient_tolerance: f64,
    /// Stop when an iteration lowers chi^2 by less than this fraction.
    pub chi_square_tolerance: f64,
    /// Stop, without an evaluation, when the next full step is expected to lower chi^2 by less than this fraction; 0 always tries it.
    pub foreseen_tolerance: f64,
    /// Once a longer step was rejected, stop where a shorter one promises, or has made, a smaller change of chi^2 than this fraction: noise of
    /// the residuals, such as steps of an adaptive solver that come and go, would have the region shrink until it vanishes.
    pub noise_tolerance: f64,
    /// Stop when a step is shorter than this fraction of |x|.
    pub step_tolerance: f64,
    /// Largest number of residual evaluations (those inside a Jacobian are not counted).
    pub max_evaluations: usize,
    /// Largest number of failed evaluations in a row.
    pub max_consecutive_failures: usize,
    /// Directions with a relative singular value below this are not stepped along. Set it to the relative
    /// accuracy of the Jacobian, so that noise in it does not drive parameters that the data do not feel.
    pub rank_tolerance: f64,
    /// Scaling of the variables.
    pub scaling: Scaling,
    /// First trust radius in scaled variables; `None` takes the norm of the scaled start.
    pub initial_radius: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            gradient_tolerance: 1e-10,
            chi_square_tolerance: 1e-8,
            foreseen_tolerance: 0.0,
            noise_tolerance: 1e-8,
            step_tolerance: 1e-8,
            max_evaluations: 200,
            max_consecutive_failures: 8,
            rank_tolerance: 0.0,
            scaling: Scaling::Unit,
            initial_radius: None,
        }
    }
}

impl Options {
    /// For log parameters and a Jacobian by finite differences of a simulation whose relative accuracy is
    /// `jacobian_accuracy`: first step at most a factor e or so, tolerances above the simulation's noise.
    pub fn for_log_parameters(jacobian_accuracy: f64) -> Self {
        Self {
            gradient_tolerance: 1e-8,
            chi_square_tolerance: 1e-4,
            noise_tolerance: 1e-4,
            step_tolerance: 1e-6,
            rank_tolerance: jacobian_accuracy,
            initial_radius: Some(1.0),
            ..Self::default()
        }
    }
}
