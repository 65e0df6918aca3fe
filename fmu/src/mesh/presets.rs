//! The mesh presets, chosen by the convergence study in the documentation.

use super::grading::Grading;
use crate::parameters::{MeshParameters, MeshPreset};

/// Grading of the parameters: the preset's unless overridden.
pub fn resolve(mesh: &MeshParameters, punch_radius: f64) -> Grading {
    // In units of the punch radius.
    let (first, growth, largest) = match mesh.preset {
        MeshPreset::Coarse => (0.02, 2.5, 1.5),
        MeshPreset::Standard => (0.002, 2.5, 1.25),
        MeshPreset::Fine => (0.0005, 2.0, 1.0),
    };
    Grading {
        first: if mesh.edge_size > 0.0 { mesh.edge_size } else { first * punch_radius },
        growth: if mesh.growth > 0.0 { mesh.growth } else { growth },
        largest: largest * punch_radius,
    }
}
