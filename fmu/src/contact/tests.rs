//! What a set of nodal forces makes of the bond.

use super::adhesion::Adhesion;
use super::decision::{Past, Slack, Trial};
use super::profile::Profile;
use super::status::{Contact, Status};
use super::surface::Surface;
use crate::element::geometry::Geometry;
use crate::mesh::Mesh;
use crate::parameters::Parameters;

/// A bonded flat punch on the undeformed sample, and the number of unknowns.
fn touched() -> (Surface, Contact, usize) {
    touched_by(&Parameters::default())
}

fn touched_by(p: &Parameters) -> (Surface, Contact, usize) {
    let mesh = Mesh::new(&p.geometry, &p.mesh);
    let geometry = Geometry::new(&mesh);
    let surface = Surface::new(&mesh, &geometry, &p.boundary, Profile::Flat, Adhesion::NONE);
    let contact = surface.touched();
    (surface, contact, mesh.unknowns())
}

/// Every corner pressed with 1 N and pushed outwards by `shear` (N), but for the pull at the edge (N).
fn forces(surface: &Surface, unknowns: usize, shear: f64, pull: f64) -> Vec<f64> {
    let mut forces = vec![0.0; unknowns];
    let corners: Vec<_> = surface.nodes().iter().step_by(2).collect();
    for corner in &corners {
        (forces[corner.radial], forces[corner.axial]) = (shear, -1.0);
    }
    forces[corners[corners.len() - 1].axial] = pull;
    forces
}

fn change(
    surface: &Surface,
    contact: &mut Contact,
    past: &mut Past,
    (from, x, forces): (&[f64], &[f64], &[f64]),
) -> bool {
    let slack = Slack { force: 1e-9, length: 1e-12 };
    let trial = Trial { x, from, forces, indentation: 0.0, slack };
    let decision = surface.decide(contact, &trial, past);
    *contact = surface.follow(contact, &decision, &trial);
    decision.solve_again
}

/// A pulled edge whose patch friction can hold: the patch slides under the shear that it has, no more and no less, and
/// is held where it comes to rest.
#[test]
fn a_pulled_patch_that_friction_holds_yields_under_its_shear() {
    let (surface, mut contact, unknowns) = touched();
    let (rest, pulled) = (vec![0.0; unknowns], forces(&surface, unknowns, 0.25, 0.5));
    let mut past = surface.no_past();
    assert!(change(&surface, &mut contact, &mut past, (&rest, &rest, &pulled)));
    let yields = |status: &&Status| **status == Status::Yields;
    let patch = contact.corners().iter().filter(yields).count();
    assert!(patch > 1 && patch < contact.corners().len(), "{patch}");
    // All but the edge press with 1 N; the edge pulls with 0.5 N.
    let ratio = 0.25 * patch as f64 / (patch as f64 - 1.5);
    let edge = surface.nodes().len() - 1;
    approx::assert_relative_eq!(surface.friction(edge, &contact), ratio, max_relative = 1e-14);
    assert!(!contact.is_held(edge) && contact.is_closed(edge));

    let mut moved = rest.clone();
    let radial = surface.nodes()[edge].radial;
    moved[radial] = -1e-5;
    let pressed = forces(&surface, unknowns, 0.25, -1.0);
    let before = contact.clone();
    assert!(!change(&surface, &mut contact, &mut past, (&rest, &moved, &pressed)));
    assert!(contact.corners().iter().all(|status| *status == Status::Held));
    assert_eq!(contact.held[edge], -1e-5);
    assert!(!contact.touches_as(&before), "a place where the surface sticks anew is a kink of the force");
}

/// Where the shear exceeds the friction the patch slides against it.
#[test]
fn a_pulled_patch_that_friction_cannot_hold_slides() {
    let (surface, mut contact, unknowns) = touched();
    let (rest, pulled) = (vec![0.0; unknowns], forces(&surface, unknowns, -3.0, 0.5));
    assert!(change(&surface, &mut contact, &mut surface.no_past(), (&rest, &rest, &pulled)));
    let edge = surface.nodes().len() - 1;
    assert_eq!(contact.corners()[edge / 2], Status::PushedInwards);
    assert_eq!(surface.friction(edge, &contact), -Parameters::default().boundary.friction);
}

/// Without a pull, an open neighbour or one that slides, the bond holds any shear.
#[test]
fn a_closed_face_is_bonded() {
    let (surface, mut contact, unknowns) = touched();
    let (rest, sheared) = (vec![0.0; unknowns], forces(&surface, unknowns, 3.0, -1.0));
    assert!(!change(&surface, &mut contact, &mut surface.no_past(), (&rest, &rest, &sheared)));
    assert!(contact.corners().iter().all(|status| *status == Status::Held));
}

/// Where friction alone holds the face, a corner slides at once when its shear exceeds the friction, by itself and under pressure, and is
/// held again where its motion turned; what is pulled opens.
#[test]
fn friction_alone_holds_corner_by_corner() {
    let mut p = Parameters::default();
    (p.boundary.partial_slip, p.boundary.friction) = (true, 0.5);
    let (surface, mut contact, unknowns) = touched_by(&p);
    let edge = surface.nodes().len() - 1;
    let [slips, sticks] = [edge / 2 - 1, edge / 2 - 2];
    let (rest, mut sheared) = (vec![0.0; unknowns], forces(&surface, unknowns, 0.0, 0.5));
    sheared[surface.nodes()[2 * slips].radial] = -0.51;
    sheared[surface.nodes()[2 * sticks].radial] = -0.49;
    let mut past = surface.no_past();
    assert!(change(&surface, &mut contact, &mut past, (&rest, &rest, &sheared)));
    assert_eq!(contact.corners()[slips..], [Status::PushedInwards, Status::Open]);
    assert!(contact.corners()[..slips].iter().all(|status| *status == Status::Held));
    assert_eq!(surface.friction(2 * slips, &contact), -0.5);

    let (mut moved, radial) = (rest.clone(), surface.nodes()[2 * slips].radial);
    moved[radial] = 1e-6;
    assert!(!change(&surface, &mut contact, &mut past, (&rest, &moved, &sheared)));
    assert_eq!(contact.corners()[slips], Status::PushedInwards, "it moves against the friction");
    moved[radial] = -1e-6;
    assert!(!change(&surface, &mut contact, &mut past, (&rest, &moved, &sheared)));
    assert_eq!((contact.corners()[slips], contact.held[2 * slips]), (Status::Held, -1e-6));
}
