//! Contact conditions, node by node.
//!
//! Goal: after every stage each node of the face, mid-side nodes included, has a gap or a pressure, never both and none of them
//! negative: what touches lies on the face and is not pulled, what is open lies below it and carries nothing. With partial slip every
//! corner in contact off the axis obeys Coulomb's law: it sticks within the friction, or slides under all of it and against it. Mesh: `coarse`.
//! Boundary conditions: Table 1's sample under a flat, a bonded flat, a slipping flat and a spherical punch. Parameters: P2's ramp, ten seconds of
//! hold and the retraction, backward Euler steps of at most 10 um, 2.5 um on the way back (one stage each, so its nodal forces can
//! be assembled anew from the states before and after it). Reference: the conditions themselves. Tolerance: gap 1e-6 of the
//! punch's radius, force 1e-4 mN; the consistent force of a mid-side node between closed corners may have any sign, so its pressure
//! is judged with its corners' by the bilinear functions.

use poropunch::Statistics;
use poropunch::contact::status::Status;
use poropunch::element::Stage;
use poropunch::law::PointMaterial;
use poropunch::parameters::{IndenterProfile, TimeScheme};
use poropunch::specimen::{Discretisation, Motion, Patience, Sample, Stepper};
use tests::{DEPTH, coarse};

const SPHERE: f64 = 8e-3;
const SLACK_M: f64 = 2e-9;
const SLACK_N: f64 = 1e-7;
const FRICTION: f64 = 0.3;

/// What holds the face.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hold {
    Nothing,
    Bond,
    Friction,
}

/// What the conditions are violated by at most: a closed node's distance from the face, an open one's reach into it (m), a pull on a closed corner and
/// any force on an open node (N), a shear that friction does not bear (N) and a slip along the friction (m); and the numbers of states in which the
/// face was partly open, and in which it partly slid under pressure.
fn violations(profile: IndenterProfile, hold: Hold) -> ([f64; 6], [usize; 2]) {
    let mut parameters = coarse();
    parameters.solver.time_scheme = TimeScheme::BackwardEuler;
    parameters.boundary.bonded_punch = hold != Hold::Nothing;
    if hold == Hold::Friction {
        (parameters.boundary.partial_slip, parameters.boundary.friction) = (true, FRICTION);
    }
    parameters.indenter.profile = profile;
    if profile == IndenterProfile::Sphere {
        parameters.indenter.sphere_radius = SPHERE;
    }
    let sample =
        Sample::shared_under(&parameters.indenter, &parameters.geometry, &parameters.mesh).expect("a mesh");
    let material = PointMaterial::new(&parameters.material);
    let mut nodes: Vec<(f64, usize)> = sample
        .mesh
        .punch()
        .map(|n| (sample.mesh.nodes[n as usize][0], sample.mesh.displacement(n)))
        .collect();
    nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let height = |radius: f64| match profile {
        IndenterProfile::Sphere => SPHERE - (SPHERE * SPHERE - radius * radius).sqrt(),
        _ => 0.0,
    };
    let mut stepper = Stepper::new(&parameters.setup(), sample.clone());
    let mut state = stepper.undeformed(0.0);
    let (mut worst, mut partly, mut at) = ([0.0_f64; 6], [0; 2], 0.0);
    let mut residual = vec![0.0; sample.mesh.unknowns()];
    let mut values = vec![0.0; sample.map.pattern.rows.len()];
    for (to, velocity, longest) in [(DEPTH, 1.6e-3, 1e-5 / 1.6e-3), (DEPTH, 0.0, 2.0), (0.0, -1e-3, 2.5e-3)] {
        let mut left: f64 = if velocity == 0.0 { 10.0 } else { (to - at) / velocity };
        while left > 1e-9 {
            let mut dt = left.min(longest);
            let next = loop {
                let motion = Motion { start: at, velocity };
                match stepper.step(&state, motion, dt, Patience::Little, &mut Statistics::default()) {
                    Ok(next) => break next.state,
                    Err(reason) => assert!(dt > 1e-7, "{at} m: {reason}"),
                }
                dt *= 0.5;
            };
            at += velocity * dt;
            left -= dt;
            // A stage ends with the set of nodes for the next one: only where that is the same is it the one it was solved with.
            let settled = (0..nodes.len()).all(|k| next.contact.is_closed(k) == state.contact.is_closed(k));
            let slides_on = next.contact.corners() == state.contact.corners();
            let before = state.x.clone();
            let stage = Stage { x: &next.x, old: &state.history, dt };
            sample.body(&material).assemble(&stage, &mut residual, Some(&mut values)).expect("a state");
            state = next;
            if !settled {
                continue;
            }
            let corners = state.contact.corners();
            let closed = |k: usize| corners[k] != Status::Open;
            let all_closed = (0..corners.len()).all(closed);
            partly[0] += usize::from((0..corners.len()).any(closed) && !all_closed);
            partly[1] += usize::from(all_closed && corners.contains(&Status::PushedOutwards));
            for (k, &(radius, first)) in nodes.iter().enumerate() {
                let gap = -at + height(radius + state.x[first]) - state.x[first + 1];
                if state.contact.is_closed(k) {
                    worst[0] = worst[0].max(gap.abs());
                } else {
                    worst[1] = worst[1].max(-gap);
                    worst[3] = worst[3].max(residual[first + 1].abs());
                }
            }
            for k in (0..corners.len()).filter(|&k| closed(k)) {
                let own = residual[nodes[2 * k].1 + 1];
                let beside = [(2 * k).checked_sub(1), Some(2 * k + 1)];
                let shares =
                    beside.into_iter().flatten().filter(|&m| m < nodes.len() && state.contact.is_closed(m));
                let pull = own + shares.clone().map(|m| 0.5 * residual[nodes[m].1 + 1]).sum::<f64>();
                worst[2] = worst[2].max(pull);
                if hold == Hold::Friction && slides_on && k > 0 {
                    let radial = nodes[2 * k].1;
                    let shear = residual[radial] + shares.map(|m| 0.5 * residual[nodes[m].1]).sum::<f64>();
                    let limit = -FRICTION * pull;
                    let (violation, direction) = match corners[k] {
                        Status::PushedOutwards => ((shear - limit).abs(), 1.0),
                        Status::PushedInwards => ((shear + limit).abs(), -1.0),
                        _ => (shear.abs() - limit, 0.0),
                    };
                    worst[4] = worst[4].max(violation);
                    worst[5] = worst[5].max(direction * (state.x[radial] - before[radial]));
                }
            }
        }
    }
    (worst, partly)
}

#[test]
fn a_node_has_a_gap_or_a_pressure() {
    for (profile, hold) in [
        (IndenterProfile::Flat, Hold::Nothing),
        (IndenterProfile::Flat, Hold::Bond),
        (IndenterProfile::Flat, Hold::Friction),
        (IndenterProfile::Sphere, Hold::Nothing),
    ] {
        let (worst, partly) = violations(profile, hold);
        println!("{profile:?}, {hold:?}: {worst:?}, {partly:?} states partly open, slipping");
        assert!(partly[0] > 0, "{profile:?}, {hold:?}: the face was never partly open");
        assert_eq!(partly[1] > 0, hold == Hold::Friction, "{profile:?}, {hold:?}: {partly:?}");
        assert!(worst[0] < SLACK_M && worst[1] < SLACK_M, "{profile:?}, {hold:?}: {worst:?} m");
        assert!(worst[2] < SLACK_N && worst[3] < SLACK_N, "{profile:?}, {hold:?}: {worst:?} N");
        assert!(worst[4] < SLACK_N && worst[5] < SLACK_M, "{profile:?}, {hold:?}: {worst:?} N, m");
    }
}
