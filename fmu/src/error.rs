//! What can go wrong, with the reason.

use thiserror::Error;

/// A parameter set that the model cannot be built from.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ParameterError {
    /// A value outside its admissible range (NaN included).
    #[error("{name} = {value} is outside [{min}, {max}]")]
    OutOfRange {
        /// Name of the parameter.
        name: String,
        /// Offending value.
        value: f64,
        /// Smallest admissible value.
        min: f64,
        /// Largest admissible value.
        max: f64,
    },
    /// The mesh does not fit into memory.
    #[error("the mesh is too large for this machine's memory: enlarge mesh.edge_size or mesh.growth")]
    TooLarge,
    /// A setting that the three-dimensional model does not know.
    #[error("{0} is not available with mesh.kind = paper-3d: leave it at its default")]
    NotIn3d(&'static str),
    /// Sensitivities with an effect whose derivative is not computed.
    #[error("with {0} the model computes no sensitivities: switch solver.sensitivities off")]
    NoSensitivities(&'static str),
    /// A parameter that acts only where another has a certain value.
    #[error("{0} acts only with {1}")]
    Contradiction(&'static str, &'static str),
    /// A snapshot of another model.
    #[error("the saved state belongs to another mesh or another number of viscous branches")]
    ForeignSnapshot,
    /// An Ogden pair without a positive shear modulus.
    #[error(
        "{name}: mu = {mu} Pa and alpha = {alpha} must have the same sign (shear modulus mu alpha / 2 > 0)"
    )]
    NotElliptic {
        /// Name of the Ogden pair.
        name: String,
        /// mu (Pa).
        mu: f64,
        /// alpha [-].
        alpha: f64,
    },
}

/// A step that could not be made. The instance stays at its last good state.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StepError {
    /// The duration is zero, negative or not a number.
    #[error("step size {0} s is not a positive number")]
    BadDuration(f64),
    /// The displacement is not a number.
    #[error("displacement {0} m is not a finite number")]
    BadDisplacement(f64),
    /// The punch starts inside the sample.
    #[error("the punch starts {0} m inside the sample: start at or above the surface (displacement <= 0)")]
    StartsInside(f64),
    /// The punch would reach or pierce the bottom of the sample.
    #[error(
        "displacement: indentation {displacement} m reaches the sample's height {sample_height} m; press less deep, \
         or set geometry.sample_height to the sample's"
    )]
    TooDeep {
        /// Requested displacement (m).
        displacement: f64,
        /// Height of the sample (m).
        sample_height: f64,
    },
    /// The punch of the three-dimensional model would pull at the sample.
    #[error(
        "at {time} s the retracting punch (displacement {displacement} m) would pull at the sample; \
         lift-off after contact is not part of the three-dimensional model"
    )]
    Retraction {
        /// Model time (s).
        time: f64,
        /// Displacement (m).
        displacement: f64,
    },
    /// The step size fell below its minimum without convergence.
    #[error(
        "no convergence at {time} s down to a step of {step_size} s: {reason}; a coarser mesh.preset or a smaller \
         displacement may help"
    )]
    NoConvergence {
        /// Time at the start of the failed step (s).
        time: f64,
        /// Smallest step tried (s).
        step_size: f64,
        /// Why the last attempt failed.
        reason: String,
    },
}
