//! Sparse linear algebra, Newton iteration, time scheme.

pub mod linear;
pub mod newton;
pub mod scheme;
