//! Rough models.

use crate::inference::effect::Candidate;
use crate::inference::setup::Setup;
use crate::inference::start::{Face, Known};
use crate::inference::unknowns::Unknowns;

/// Coarsest mesh, steps and residuals as accurate as it is: the force differs by a per cent, and so do derivatives.
const ROUGH: [(&str, f64); 3] =
    [("mesh.preset", 1.0), ("solver.tolerance", 1e-2), ("solver.newton_tolerance", 1e-7)];
/// Rougher under a sphere or a cone, where the contact's nodes close one after the other, each by iterations of its own: elements
/// twice the coarsest mesh's and first step, both over the radius of the shank.
const ROUGH_TIP: [(&str, f64); 2] = [("mesh.edge_size", 1.0 / 8.0), ("solver.initial_increment", 0.05)];
const ROUGH_TIP_RESIDUAL: (&str, f64) = ("solver.newton_tolerance", 1e-6);
/// Rougher still, for the way to a minimum: elements at the edge over the radius of a flat punch, and how they grow. Its force differs by
/// less than a per cent, derivatives by a per cent, those by what the fluid does by 20; a run costs a fifth of the coarsest mesh's.
const ROUGHEST_EDGE: f64 = 0.1;
const ROUGHEST: [(&str, f64); 2] = [("mesh.divisions", 1.0), ("mesh.growth", 4.0)];

/// The rough model with what the one asked for differed by at one point.
#[derive(Debug, Clone)]
pub struct Twin {
    pub(super) unknowns: Unknowns,
    /// Force of the model asked for minus that of the rough one (mN); empty: not known.
    pub(super) offset_mn: Vec<f64>,
}

impl Twin {
    /// The rough model.
    pub(super) fn rough(setup: Setup) -> Self {
        Self { unknowns: rough_unknowns(setup), offset_mn: vec![] }
    }

    /// A rougher one, where the model is poropunch's own, nothing of what makes it rough was chosen but a preset, and none of these effects is
    /// a matter of it.
    pub fn leading(setup: Setup, active: &[&Candidate]) -> Option<Self> {
        let is_chosen = |name: &String| is_of_mesh_or_steps(name) && name != ROUGH[0].0;
        let may_lead = setup.engine.is_own()
            && !setup.unknowns.fixed().keys().any(is_chosen)
            && !active.iter().any(|candidate| is_matter_of_mesh_or_steps(candidate));
        may_lead.then(|| Self { unknowns: roughest_unknowns(setup), offset_mn: vec![] })
    }

    /// The coarsest mesh with all else as asked for, where the one asked for is finer and none of these effects is a matter of it. What is
    /// found with it is the same as if it had been asked for, a rougher one that leads there included.
    pub fn coarser(setup: Setup, candidates: &[Candidate]) -> Option<Self> {
        let may_stand = applies(setup) && !candidates.iter().any(is_matter_of_mesh_or_steps);
        let unknowns = || setup.unknowns.clone().with_fixed(&ROUGH[..1]);
        may_stand.then(|| Self { unknowns: unknowns(), offset_mn: vec![] })
    }

    /// What stands for the model asked for.
    pub fn setup<'a>(&'a self, asked: Setup<'a>) -> Setup<'a> {
        Setup { unknowns: &self.unknowns, offset_mn: &self.offset_mn, ..asked }
    }

    /// The rough model where there is one, or the one asked for.
    pub fn setup_or<'a>(twin: Option<&'a Self>, asked: Setup<'a>) -> Setup<'a> {
        twin.map_or(asked, |twin| twin.setup(asked))
    }
}

/// Whether a parameter makes the model rough or fine.
fn is_of_mesh_or_steps(name: &str) -> bool {
    name.starts_with("mesh.") || name.starts_with("solver.")
}

fn is_matter_of_mesh_or_steps(candidate: &Candidate) -> bool {
    candidate.effect.parameters.iter().any(|name| is_of_mesh_or_steps(name))
}

/// Whether the model has a rough twin: it is poropunch's own, no coarser one, and nothing else of what makes it rough was chosen.
pub fn applies(setup: Setup) -> bool {
    let [(preset, coarsest), ..] = ROUGH;
    let is_chosen = |(name, value): (&String, &f64)| match name.as_str() {
        name if name == preset => *value == coarsest,
        name => is_of_mesh_or_steps(name),
    };
    setup.engine.is_own() && !setup.unknowns.fixed().iter().any(is_chosen)
}

/// What is pressed into what; none for another FMU than poropunch's.
fn face(setup: Setup) -> Option<Face> {
    let at_start = setup.unknowns.settings(setup.unknowns.start());
    Known::of(&|name| setup.value(&at_start, name)).map(|known| known.rig.face)
}

/// The unknowns of the roughest model.
fn roughest_unknowns(setup: Setup) -> Unknowns {
    let unknowns = rough_unknowns(setup);
    match face(setup) {
        Some(Face::Flat { radius }) => {
            unknowns.with_fixed(&[("mesh.edge_size", ROUGHEST_EDGE * radius)]).with_fixed(&ROUGHEST)
        }
        _ => unknowns,
    }
}

/// The unknowns of the rough model.
fn rough_unknowns(setup: Setup) -> Unknowns {
    let unknowns = setup.unknowns.clone().with_fixed(&ROUGH);
    match face(setup) {
        Some(Face::Sphere { shank, .. } | Face::Cone { shank, .. }) => {
            let lengths = ROUGH_TIP.map(|(name, part)| (name, part * shank));
            unknowns.with_fixed(&lengths).with_fixed(&[ROUGH_TIP_RESIDUAL])
        }
        _ => unknowns,
    }
}
