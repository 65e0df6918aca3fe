//! What the integration points remember from one stage to the next.

use serde::{Deserialize, Serialize};

/// History of all integration points at one time, of either dimension.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct History {
    /// J, element by element and point by point.
    pub jacobian: Vec<f64>,
    /// Components of `Cv^-1`, branch by branch at every point.
    pub cv_inverse: Vec<f64>,
    /// Largest equivalent strain so far at every point; empty unless the material softens with it.
    pub past_strain: Vec<f64>,
}

impl History {
    /// The undeformed state of so many points and branches; `identity` has the components of one tensor.
    pub fn undeformed(points: usize, branches: usize, identity: &[f64]) -> Self {
        Self {
            jacobian: vec![1.0; points],
            cv_inverse: identity.repeat(points * branches),
            past_strain: Vec::new(),
        }
    }

    /// The same of a material that softens with past strain, where `softens` says so.
    pub fn remembering(mut self, softens: bool) -> Self {
        self.past_strain = vec![0.0; if softens { self.jacobian.len() } else { 0 }];
        self
    }

    /// `Cv^-1` in tensors of `N` components.
    #[inline(always)]
    pub fn tensors<const N: usize>(&self) -> &[[f64; N]] {
        self.cv_inverse.as_chunks().0
    }

    /// The same to be written.
    #[inline(always)]
    pub fn tensors_mut<const N: usize>(&mut self) -> &mut [[f64; N]] {
        self.cv_inverse.as_chunks_mut().0
    }

    /// Numbers of its entries.
    pub fn lengths(&self) -> [usize; 3] {
        [self.jacobian.len(), self.cv_inverse.len(), self.past_strain.len()]
    }
}
