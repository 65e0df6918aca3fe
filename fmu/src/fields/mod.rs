//! Fields of the sample at one time, for ParaView.
//!
//! Points are (r, 0, z) in metres: r from the axis, z upwards from the sample's bottom. So z is the axis of
//! the cylinder, ParaView opens the half plane facing the viewer, and its Rotational Extrusion, which turns about z,
//! makes the whole sample of it.

mod error;
mod extract;
mod quantity;
mod smooth;
mod specimen;
#[cfg(test)]
mod tests;

pub use error::FieldsError;
pub use extract::{FieldSource, extract};
pub use quantity::{QUANTITIES, Quantity, Support, markdown};

use crate::mesh::NODES;

/// All quantities of [`QUANTITIES`] at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Fields {
    /// The mesh's nodes in the undeformed sample, (r, 0, z) (m).
    pub points: Vec<[f64; 3]>,
    /// Biquadratic quadrilaterals in VTK's order: corners, mid-side nodes, centre. At the punch's edge three points
    /// of a cell are one.
    pub cells: Vec<[u32; NODES]>,
    /// Values at the points.
    pub point_data: Vec<Field>,
    /// Means over the cells' undeformed volumes.
    pub cell_data: Vec<Field>,
}

/// Values of one quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// What it is.
    pub quantity: &'static Quantity,
    /// Point by point or cell by cell, all components of each.
    pub values: Vec<f64>,
}

impl Fields {
    /// Values at the points of the quantity called `name`.
    pub fn at_points(&self, name: &str) -> Option<&Field> {
        self.point_data.iter().find(|field| field.quantity.name == name)
    }

    /// Means over the cells of the quantity called `name`.
    pub fn in_cells(&self, name: &str) -> Option<&Field> {
        self.cell_data.iter().find(|field| field.quantity.name == name)
    }
}

impl Field {
    /// The values of one point or cell.
    pub fn row(&self, index: usize) -> &[f64] {
        let components = self.quantity.components.len();
        &self.values[index * components..(index + 1) * components]
    }
}
