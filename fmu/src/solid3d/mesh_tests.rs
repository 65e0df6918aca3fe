//! Counts, balance and constraints of the mesh.

use super::super::forest::{COARSE, PAPER};
use super::*;

fn mesh(refinement: Refinement<'_>) -> Mesh {
    Mesh::new(&GeometryParameters::default(), refinement)
}

/// The paper's mesh has 3184 cells and 93,808 unknowns; deal.II counts those of hanging nodes, too.
#[test]
fn the_paper_mesh_has_the_papers_size() {
    let mesh = mesh(PAPER);
    assert_eq!((mesh.cells.len(), mesh.unknowns_with_hanging(), mesh.unknowns()), (3184, 91_485, 82_413));
    approx::assert_relative_eq!(mesh.edge_size(), 0.125e-3, max_relative = 1e-9);
}

/// Goal: constraints interpolate. Set-up: s, t, Z are reference coordinates of all sectors; a full
/// triquadratic of them for the displacement, a trilinear one for the pressure. Reference: its values at the
/// hanging nodes. Tolerance: 1e-12.
#[test]
fn hanging_nodes_reproduce_quadratic_and_linear_fields() {
    for (refinement, least) in [(COARSE, 200), (PAPER, 2000)] {
        let mesh = mesh(refinement);
        let reference = |node: u32| {
            let x = mesh.logical[node as usize];
            let s = ring_coordinate(x);
            [s, x[0].min(x[1]) / s, x[2]]
        };
        let quadratic =
            |[s, t, z]: [f64; 3]| (1.0 + s - 0.3 * s * s) * (2.0 + t * t) * (z * z - 3.0 * z + 0.5);
        let linear = |[s, t, z]: [f64; 3]| (1.0 + s) * (2.0 - t) * (0.5 + z);
        let mut hanging = [0, 0];
        for node in (0..mesh.nodes.len() as u32).filter(|&n| mesh.ring(n) >= 1.0) {
            let here = reference(node);
            let interpolated = |terms: &Terms, field: &dyn Fn([f64; 3]) -> f64| -> f64 {
                terms.iter().map(|&(n, w)| w * field(reference(n))).sum()
            };
            let terms = &mesh.displacement_terms[node as usize];
            if terms.len() > 1 {
                hanging[0] += 1;
                let value = interpolated(terms, &quadratic);
                approx::assert_relative_eq!(value, quadratic(here), max_relative = 1e-12, epsilon = 1e-12);
            }
            let terms = &mesh.pressure_terms[node as usize];
            if terms.len() > 1 {
                hanging[1] += 1;
                let value = interpolated(terms, &linear);
                approx::assert_relative_eq!(value, linear(here), max_relative = 1e-12, epsilon = 1e-12);
            }
        }
        assert!(hanging[0] > least && hanging[1] > least / 8, "{hanging:?}");
    }
}

/// Goal: physical linear fields are continuous. Set-up: positions of all nodes. Reference: positions
/// interpolated by the constraints; masters are free. Tolerance: 1e-15 m.
#[test]
fn hanging_nodes_lie_on_their_neighbours_faces() {
    let mesh = mesh(PAPER);
    for (node, terms) in mesh.displacement_terms.iter().enumerate() {
        assert!(terms.iter().all(|&(n, _)| mesh.displacement(n).is_some()));
        for d in 0..3 {
            let x: f64 = terms.iter().map(|&(n, w)| w * mesh.nodes[n as usize][d]).sum();
            assert!((x - mesh.nodes[node][d]).abs() < 1e-15);
        }
    }
}

/// Goal: neighbours differ by one level at most. Set-up: the interior of every face's eighths.
/// Reference: no node lies there.
#[test]
fn cells_are_balanced() {
    for refinement in [COARSE, PAPER, Refinement { reach: &[0.9, 0.9, 0.9] }] {
        let cells = forest::cells(refinement);
        let half = |k: usize| [k % 3, k / 3 % 3, k / 9].map(|i| 0.5 * i as f64);
        let known: std::collections::HashSet<Key> =
            cells.iter().flat_map(|c| (0..NODES).map(|k| key(c.logical(half(k))))).collect();
        for cell in &cells {
            for p in surface(8).filter(|p| p.iter().any(|i| i % 2 == 1)) {
                assert!(!known.contains(&key(cell.logical(p.map(|i| 0.125 * i as f64)))));
            }
        }
    }
}

/// Boundary nodes lie where they should, hanging ones included.
#[test]
fn boundaries_are_where_they_should_be() {
    let g = GeometryParameters::default();
    let mesh = mesh(PAPER);
    for node in 0..mesh.nodes.len() as u32 {
        let [x, y, z] = mesh.nodes[node as usize];
        let r = x.hypot(y);
        assert!(!mesh.on_plane(node, 0) || x == 0.0);
        assert!(!mesh.on_plane(node, 1) || y == 0.0);
        assert!(!mesh.is_bottom(node) || z == 0.0);
        assert!(!mesh.is_side(node) || (r / g.sample_radius - 1.0).abs() < 1e-3);
        assert!(!mesh.is_top(node) || (z / g.sample_height - 1.0).abs() < 1e-12);
        if mesh.is_punch(node) && mesh.is_free_top(node) {
            assert!((r / g.punch_radius - 1.0).abs() < 1e-9, "the edge's nodes are on the circle: {r}");
        }
    }
}
