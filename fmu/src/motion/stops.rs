//! Where an advance may end before its time.

/// What ends an advance early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stops {
    /// Corners of the built-in motion, and contact that is made or lost.
    pub events: bool,
    /// The ends of the integrator's own steps.
    pub steps: bool,
}

/// Why an advance ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// Its own end.
    End,
    /// A corner of the built-in motion.
    Corner,
    /// Contact was made or lost.
    Contact,
    /// The end of one of the integrator's steps.
    Step,
}

impl Reached {
    /// Whether something happened there that a master may want to see.
    pub fn is_event(self) -> bool {
        matches!(self, Self::Corner | Self::Contact)
    }
}
