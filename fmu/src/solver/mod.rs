//! Sparse linear algebra, Newton iteration, time scheme.

pub mod linear;
pub mod multifrontal;
pub mod newton;
pub mod parameters;
pub mod pattern;
pub mod scheme;
