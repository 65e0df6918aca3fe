//! How the fluid leaves the specimen.

/// How a surface lets the fluid out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drainage {
    /// Pore pressure zero.
    Free,
    /// Flux = permeance (m/(Pa s)) times pore pressure; zero is impermeable.
    Permeance(f64),
}

/// Drainage of the surfaces; the free top is always drained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boundary {
    /// The bottom.
    pub bottom: Drainage,
    /// The lateral surface.
    pub side: Drainage,
    /// Permeance of the punch's face (m/(Pa s)).
    pub face: f64,
}
