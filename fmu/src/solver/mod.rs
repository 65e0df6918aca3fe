//! Solution of the discrete equations.

pub mod multifrontal;
