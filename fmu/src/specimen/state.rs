//! The specimen at one time.

use super::derivatives::Sensitivity;
use super::extrapolation::Extrapolation;
use crate::contact::status::Contact;
use crate::contact::surface::Touch;
use crate::element::History;
use crate::outputs::Outputs;
use serde::{Deserialize, Serialize};

/// The specimen at one time, of either dimension.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time (s).
    pub time: f64,
    /// Unknowns: displacements (m) and pressures (Pa).
    pub x: Vec<f64>,
    /// Their motion over the last stages.
    pub trend: Extrapolation,
    /// History at the integration points.
    pub history: History,
    /// Which nodes are in contact with the punch from this time on.
    pub contact: Contact,
    /// Where the surface lies.
    pub touch: Touch,
    /// Results.
    pub outputs: Outputs,
    /// Changes with the material's parameters, where they are asked for.
    pub sensitivity: Option<Sensitivity>,
}

/// Numbers of entries of a state: those of one discretisation and set of parameters are the same.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Lengths {
    unknowns: [usize; 3],
    history: [usize; 3],
    contact: [usize; 4],
    sensitivity: Option<[usize; 6]>,
}

impl State {
    /// Its numbers of entries.
    pub fn lengths(&self) -> Lengths {
        let [rates, accelerations] = self.trend.lengths();
        Lengths {
            unknowns: [self.x.len(), rates, accelerations],
            history: self.history.lengths(),
            contact: self.contact.lengths(),
            sensitivity: self.sensitivity.as_ref().map(Sensitivity::lengths),
        }
    }

    /// Whether the same nodes are in contact, held where they were, or sliding; the force then has no kink.
    pub fn touches_as(&self, other: &Self) -> bool {
        self.contact.touches_as(&other.contact)
    }
}
