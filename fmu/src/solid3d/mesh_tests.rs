//! Counts, balance and constraints of the mesh.

use super::super::forest::{COARSE, PAPER};
use super::*;

#[test]
fn counts() {
    for reach in [
        &[9.0, 1.5, 0.6][..], &[9.0, 1.8, 0.8], &[3.0, 1.8, 0.9], &[3.0, 1.5, 0.8, 0.3], &[2.5, 1.5, 0.7, 0.3],
        &[2.2, 1.2, 0.6, 0.3], &[2.2, 1.2, 0.6, 0.2], &[1.5, 1.0, 0.5, 0.2], &[1.2, 0.6],
    ] {
        let mesh = Mesh::new(&GeometryParameters::default(), Refinement { reach });
        println!(
            "{reach:?}: {} cells, {} unknowns, {} with hanging, edge {} mm",
            mesh.cells.len(), mesh.unknowns(), mesh.unknowns_with_hanging(), mesh.edge_size() * 1e3
        );
    }
    let _ = (COARSE, PAPER);
}
