//! Inference: from measurements to what they say about the unknowns.

pub mod start;
