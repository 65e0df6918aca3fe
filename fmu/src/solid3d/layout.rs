//! Coarse blocks of the quarter cylinder, in logical coordinates, and the chart that places them.
//!
//! Seen from above, a core square near the axis is surrounded by rings, each of two sectors:
//!
//! ```text
//! Y |  sector 1   / diagonal      logical: max(X, Y) = s counts the rings, min/s = t the angle
//!   |----+      /                 s <= 1       core square
//!   |core|    /  sector 0         1 <= s <= 2  from the core's sides to a circle
//!   +----+------------------ X    s > 2        polar rings; the punch's edge is the circle s = 3
//! ```
//!
//! Logical coordinates are dyadic fractions, so equal positions are equal numbers.

use crate::mesh::parameters::GeometryParameters;

/// Rings around the core.
pub const RINGS: usize = 5;
/// Layers from the bottom to the top.
pub const LAYERS: usize = 5;
/// Logical radius of the punch's edge.
pub const EDGE: f64 = 3.0;
/// Half the side of the core square over the radius of the first circle.
const CORE: f64 = 0.55;

/// One coarse block: in the plane the core or a sector of a ring, and a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// `None` is the core; otherwise the ring from 1 and the sector 0 or 1.
    pub sector: Option<(u8, u8)>,
    /// Layer, counted from the bottom.
    pub layer: u8,
}

impl Block {
    /// Logical coordinates of the place `xi` in [0, 1]^3 of the block.
    pub fn logical(&self, xi: [f64; 3]) -> [f64; 3] {
        let z = f64::from(self.layer) + xi[2];
        match self.sector {
            None => [xi[0], xi[1], z],
            Some((ring, sector)) => {
                let s = f64::from(ring) + xi[0];
                if sector == 0 { [s, xi[1] * s, z] } else { [(1.0 - xi[1]) * s, s, z] }
            }
        }
    }
}

/// Every block of the quarter cylinder.
pub fn blocks() -> Vec<Block> {
    let mut blocks = Vec::new();
    for layer in 0..LAYERS as u8 {
        blocks.push(Block { sector: None, layer });
        for ring in 1..=RINGS as u8 {
            blocks.extend([0, 1].map(|sector| Block { sector: Some((ring, sector)), layer }));
        }
    }
    blocks
}

/// Logical radius `max(X, Y)`.
pub fn ring_coordinate(x: [f64; 3]) -> f64 {
    x[0].max(x[1])
}

/// From logical to physical coordinates (m); z points up, the bottom is z = 0.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Radii of the circles s = 2, 3, ... (m).
    radii: [f64; RINGS],
    /// Heights of the layers' boundaries (m).
    heights: [f64; LAYERS + 1],
}

impl Chart {
    /// The chart of a geometry: the punch's edge lies between rings and below layers of equal width.
    pub fn new(g: &GeometryParameters) -> Self {
        let (a, b, h) = (g.punch_radius, g.sample_radius, g.sample_height);
        let outer = (0.5 * a).min((b - a) / 3.0);
        let third = a + outer;
        let top = (0.5 * a).min(h / 5.0);
        let below = h - 2.0 * top;
        Self {
            radii: [0.5 * a, a, third, third + 2.0 / 7.0 * (b - third), b],
            heights: [0.0, 0.375 * below, 0.75 * below, below, below + top, h],
        }
    }

    /// Position (m).
    pub fn place(&self, x: [f64; 3]) -> [f64; 3] {
        let s = ring_coordinate(x);
        let z = between(&self.heights, x[2]);
        let core = CORE * self.radii[0];
        if s <= 1.0 {
            return [core * x[0], core * x[1], z];
        }
        let (cos, sin) = direction(x);
        if s >= 2.0 {
            let r = between(&self.radii, s - 2.0);
            return [r * cos, r * sin, z];
        }
        let (w, r) = (s - 1.0, self.radii[0]);
        [(1.0 - w) * core * x[0] / s + w * r * cos, (1.0 - w) * core * x[1] / s + w * r * sin, z]
    }
}

/// Cosine and sine of the polar angle of a logical position outside the core.
pub fn direction(x: [f64; 3]) -> (f64, f64) {
    let eighth = std::f64::consts::FRAC_PI_4;
    if x[1] <= x[0] {
        let (sin, cos) = (eighth * x[1] / x[0]).sin_cos();
        (cos, sin)
    } else {
        // Mirrored at the diagonal, so that the symmetry planes are met exactly.
        let (sin, cos) = (eighth * x[0] / x[1]).sin_cos();
        (sin, cos)
    }
}

/// Linear interpolation between `values` at 0, 1, 2, ...
fn between(values: &[f64], at: f64) -> f64 {
    let k = (at.floor() as usize).min(values.len() - 2);
    let w = at - k as f64;
    values[k] + w * (values[k + 1] - values[k])
}
