//! Size of punch and sample, and how the sample is discretised.

use serde::{Deserialize, Serialize};

/// Punch and sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GeometryParameters {
    /// Radius of the flat punch, or of the shank of a sphere or cone: the largest contact radius, up to which the
    /// mesh is fine (m). A flat punch at least as wide as the sample is a platen.
    pub punch_radius: f64,
    /// Radius of the sample (m).
    pub sample_radius: f64,
    /// Height of the sample (m).
    pub sample_height: f64,
}

impl Default for GeometryParameters {
    fn default() -> Self {
        Self { punch_radius: 2e-3, sample_radius: 10e-3, sample_height: 10e-3 }
    }
}

impl GeometryParameters {
    /// Whether the punch covers the whole sample.
    pub fn is_platen(&self) -> bool {
        self.punch_radius >= self.sample_radius
    }

    /// Radius of the part of the surface that the punch can touch in the undeformed sample (m).
    pub fn reach(&self) -> f64 {
        self.punch_radius.min(self.sample_radius)
    }
}

/// Named meshes, from quick to accurate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum MeshPreset {
    /// Quick.
    Coarse,
    /// The default; accurate to the force of real measurements.
    #[default]
    Standard,
    /// Accurate.
    Fine,
}

/// How the sample is discretised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum MeshKind {
    /// Axisymmetric elements, chosen by the other mesh parameters.
    #[default]
    Axisymmetric,
    /// A quarter of the cylinder in 3184 hexahedra with hanging nodes, of the paper's size.
    Paper3d,
}

/// Spatial discretisation: a preset, with overrides.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MeshParameters {
    /// Axisymmetric or three-dimensional; the parameters below are those of the axisymmetric mesh.
    pub kind: MeshKind,
    /// The preset.
    pub preset: MeshPreset,
    /// Size of the innermost ring of elements at the punch's edge (m); 0 takes the preset's.
    pub edge_size: f64,
    /// Ratio of neighbouring rings [-]; 0 takes the preset's.
    pub growth: f64,
    /// Elements along the inner side of every ring; 0 takes the preset's.
    pub divisions: u32,
}
