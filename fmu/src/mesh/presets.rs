//! The mesh presets, chosen by the convergence study in the documentation.

use crate::mesh::parameters::{MeshParameters, MeshPreset};

/// How fine the mesh is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Size of the innermost ring (m).
    pub edge_size: f64,
    /// Ratio of neighbouring rings.
    pub growth: f64,
    /// Elements of a ring along its inner side; twice as many along its bottom.
    pub divisions: usize,
    /// Ratio of neighbouring elements away from the rings.
    pub outer_growth: f64,
}

/// How fine a grid without rings is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone {
    /// Size of the elements where the edge of a growing contact may run, or at the side under a platen (m).
    pub size: f64,
    /// Ratio of neighbouring elements away from there.
    pub growth: f64,
}

/// Zone of a contact that grows up to `radius` within `width`: the preset's unless overridden.
pub fn growing_contact(mesh: &MeshParameters, radius: f64, width: f64) -> Zone {
    let zone = zone(mesh, radius, [(1.0 / 16.0, 2.5), (1.0 / 24.0, 2.0), (1.0 / 64.0, 1.5)]);
    // A narrow zone, of a rounded edge, has a few elements too.
    let most = if mesh.edge_size > 0.0 { f64::INFINITY } else { 0.25 * width };
    Zone { size: zone.size.min(most), ..zone }
}

/// Zone at the side of a sample of this radius under a platen: the preset's unless overridden.
pub fn platen(mesh: &MeshParameters, radius: f64) -> Zone {
    zone(mesh, radius, [(0.04, 2.0), (0.015, 1.7), (0.005, 1.5)])
}

fn zone(mesh: &MeshParameters, radius: f64, presets: [(f64, f64); 3]) -> Zone {
    let (size, growth) = presets[match mesh.preset {
        MeshPreset::Coarse => 0,
        MeshPreset::Standard => 1,
        MeshPreset::Fine => 2,
    }];
    Zone {
        size: if mesh.edge_size > 0.0 { mesh.edge_size } else { size * radius },
        growth: if mesh.growth > 0.0 { mesh.growth } else { growth },
    }
}

/// Resolution of the parameters: the preset's unless overridden.
pub fn resolve(mesh: &MeshParameters, punch_radius: f64) -> Resolution {
    // Edge size in units of the punch radius.
    let (edge, growth, divisions, outer_growth) = match mesh.preset {
        MeshPreset::Coarse => (0.03, 2.5, 2, 2.0),
        MeshPreset::Standard => (0.01, 2.0, 2, 1.7),
        MeshPreset::Fine => (0.003, 2.0, 3, 1.5),
    };
    Resolution {
        edge_size: if mesh.edge_size > 0.0 { mesh.edge_size } else { edge * punch_radius },
        growth: if mesh.growth > 0.0 { mesh.growth } else { growth },
        divisions: if mesh.divisions > 0 { mesh.divisions as usize } else { divisions },
        outer_growth,
    }
}
