//! Sparse linear algebra, Newton iteration, time scheme.

mod broyden;
pub mod linear;
pub mod multifrontal;
pub mod newton;
pub mod parameters;
pub mod pattern;
pub mod scheme;
