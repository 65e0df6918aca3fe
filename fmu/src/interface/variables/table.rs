//! The entries. Starts come from `Default`, so no number of the model is written twice.

use super::enumerations::Choice;
use super::row::{
    binding, choice, count, flag, integer, of_effect, output, real, saturate, section, text, variable,
};
use super::settings::CHOICES;
use super::{Binding, Kind, ProtocolSource, Variability, Variable, sensitivities};
use crate::contact::parameters::IndenterProfile;
use crate::effect::Parameter;
use crate::interface::recording::Frames;
use crate::mesh::parameters::{MeshKind, MeshPreset};
use crate::parameters::CONE_HALF_ANGLE;
use crate::solver::parameters::{LinearSolverKind, TimeScheme};
use crate::unit::{
    CUBIC_METRE, JOULE, METRE, METRE_PER_SECOND, NEWTON, ONE, PASCAL, PASCAL_SECOND, RADIAN, SECOND,
    SQUARE_METRE, WATT,
};

const MU: (f64, f64) = (-1e9, 1e9);
const ALPHA: (f64, f64) = (-100.0, 100.0);
const ETA: (f64, f64) = (1e-9, 1e12);
const LENGTH: (f64, f64) = (1e-6, 1.0);
const DURATION: (f64, f64) = (0.0, 1e6);
const RATE: (f64, f64) = (1e-9, 1.0);

const INPUTS: &[Variable] = section! { "", ():
    /// Displacement of the punch, positive into the sample; 0 touches the undeformed surface. Within a step
    /// the punch moves linearly to displacement + rate * step
    displacement: real(&METRE, (-1.0, 1.0)).input(Variability::Continuous);
    /// Velocity of the punch during the next step, for masters that set inputs only at the start of a step;
    /// the input derivative of displacement, where set, takes its place
    displacement_rate: real(&METRE_PER_SECOND, (-1.0, 1.0)).input(Variability::Discrete);
};

const OUTPUTS: &[Variable] = section! { "", (outputs):
    /// What the load cell reads: the reaction force on the punch (work-conjugate, nodal), unless an effect
    /// of the sensor is on
    force: output(&NEWTON);
    /// Part of force_specimen carried by the solid
    force_solid: output(&NEWTON);
    /// Part of force_specimen carried by the pore pressure
    force_fluid: output(&NEWTON);
    /// Surface integral of the traction under the punch, as the paper reports it; does not converge with
    /// the mesh
    force_traction: output(&NEWTON);
    /// Reaction force of the specimen on the punch (work-conjugate, nodal)
    force_specimen: output(&NEWTON);
    /// Displacement reached, as it is measured
    punch_displacement [displacement]: output(&METRE);
    /// Depth of the punch's face below the true surface: punch_displacement, plus the contact point's
    /// offset, less what the machine yields
    indentation: output(&METRE);
    /// Viscous dissipation rate (Eq. 13)
    viscous_dissipation_rate: output(&WATT);
    /// Viscous dissipation since the start
    viscous_dissipation: output(&JOULE);
    /// Porous dissipation rate (Eq. 14)
    porous_dissipation_rate: output(&WATT);
    /// Porous dissipation since the start
    porous_dissipation: output(&JOULE);
    /// Stored energy of equilibrium, branches and volume
    stored_energy: output(&JOULE);
    /// Work of the punch since the start
    external_work: output(&JOULE);
    /// Fluid volume pressed out of the sample
    fluid_expelled: output(&CUBIC_METRE);
};

const STATISTICS: &[Variable] = section! { "statistics.", (statistics):
    /// Accepted time steps
    steps: count;
    /// Newton iterations
    iterations: count;
    /// Matrix factorisations
    factorisations: count;
    /// Steps cut after a failure or an excessive error
    cuts: count;
};

const MATERIAL: &[Variable] = section! { "material.", (padded.material):
    /// Initial solid volume fraction n0S
    n0s: real(&ONE, (1e-6, 0.999));
    /// Volumetric stiffness lambda* (Eq. 10)
    lambda_star: real(&PASCAL, (1e-3, 1e12));
    /// Dynamic viscosity mu_FR of the pore fluid
    fluid_viscosity: real(&PASCAL_SECOND, (1e-9, 1e6));
    /// Initial intrinsic permeability K0 (Eq. 11)
    permeability: real(&SQUARE_METRE, (1e-30, 1e-3)).fitted(1e-20, 1e-8);
};

const EQUILIBRIUM: &[Variable] = section! { "material.equilibrium.", (padded.material.equilibrium):
    /// Ogden coefficient mu of the equilibrium response (Eq. 8); has the sign of alpha
    mu: real(&PASCAL, MU).fitted(-1000.0, -1.0);
    /// Ogden exponent alpha of the equilibrium response (Eq. 8)
    alpha: real(&ONE, ALPHA).fitted(-30.0, -1.0);
};

/// Variables of one branch; the paper identifies two of them (bounds of Table 1).
macro_rules! branch {
    ($index:literal, $number:literal $(, $fitted:ident)?) => {
        &[
            real(
                concat!("material.branch[", $number, "].mu"),
                concat!("Ogden coefficient mu of viscous branch ", $number, " (Eq. 9); 0 switches the branch off"),
                Binding::Real(|s| s.branch::<$index>().ogden.mu, |s, v| s.branch_mut::<$index>().ogden.mu = v),
                &PASCAL,
                MU,
            )
            $(.$fitted(-1000.0, -1.0))?,
            real(
                concat!("material.branch[", $number, "].alpha"),
                concat!("Ogden exponent alpha of viscous branch ", $number, " (Eq. 9)"),
                Binding::Real(
                    |s| s.branch::<$index>().ogden.alpha,
                    |s, v| s.branch_mut::<$index>().ogden.alpha = v,
                ),
                &ONE,
                ALPHA,
            )
            $(.$fitted(-30.0, -1.0))?,
            real(
                concat!("material.branch[", $number, "].eta"),
                concat!("Viscosity eta of viscous branch ", $number, " (Eq. 12)"),
                Binding::Real(|s| s.branch::<$index>().eta, |s, v| s.branch_mut::<$index>().eta = v),
                &PASCAL_SECOND,
                ETA,
            )
            $(.$fitted(1.0, 1e5))?,
        ]
    };
}

const GEOMETRY: &[Variable] = section! { "geometry.", (padded.geometry):
    /// Radius of the flat punch, or of the shank of a sphere or cone: the largest contact radius, up to
    /// which the mesh is fine. A flat punch at least as wide as the sample is a platen
    punch_radius: real(&METRE, LENGTH);
    /// Radius of the sample
    sample_radius: real(&METRE, LENGTH);
    /// Height of the sample
    sample_height: real(&METRE, LENGTH);
};

const INDENTER: &[Variable] = section! { "indenter.", (padded.indenter):
    /// Shape of the punch's face
    profile: choice(&IndenterProfile::NAMES);
    /// Radius of a flat punch's edge, from 1e-5 of geometry.punch_radius to all of it; 0: sharp; acts only
    /// with indenter.profile = flat
    edge_radius: real(&METRE, (0.0, 1e3));
    /// Radius of a sphere, at least geometry.punch_radius, the shank's: equal, it is a hemisphere; acts
    /// only with indenter.profile = sphere
    sphere_radius: real(&METRE, (1e-6, 1e3));
    /// Angle between the axis and the flank of a cone; acts only with indenter.profile = cone
    cone_half_angle: real(&RADIAN, CONE_HALF_ANGLE);
};

const MESH: &[Variable] = section! { "mesh.", (padded.mesh):
    /// Discretisation; the other mesh parameters are those of the axisymmetric one
    kind: choice(&MeshKind::NAMES);
    /// Mesh, from quick to accurate
    preset: choice(&MeshPreset::NAMES);
    /// Size of the innermost ring of elements at the punch's edge, of the elements under a sphere or cone,
    /// or at the side under a platen; 0 takes the preset's
    edge_size: real(&METRE, (0.0, 1.0));
    /// Ratio of neighbouring rings of elements, or of elements away from the contact; 0 takes the preset's
    growth: real(&ONE, (0.0, 10.0));
    /// Elements along the inner side of every ring around a flat punch's edge; 0 takes the preset's
    divisions: integer(0, 64);
};

const BOUNDARY: &[Variable] = section! { "boundary.", (padded.boundary):
    /// Pore pressure 0 on the bottom; otherwise no flux
    drained_bottom: flag;
    /// Pore pressure 0 on the lateral surface; otherwise no flux
    drained_side: flag;
    /// Pore pressure 0 on the free part of the top; otherwise no flux
    drained_top: flag;
    /// Pore pressure 0 under the punch (porous punch); otherwise no flux
    drained_punch: flag;
    /// The sample sticks to the punch until the punch pulls at it; otherwise it slides without friction
    bonded_punch: flag;
    /// Friction coefficient of a bonded punch: where the face begins to open - with boundary.partial_slip
    /// everywhere - the bond fails and the sample slides once its shear exceeds this times the pressure
    friction: real(&ONE, (0.0, 1000.0));
    /// A bonded punch holds the sample by boundary.friction alone: Coulomb's law everywhere on the face,
    /// under pressure, too; otherwise a face that is pressed down everywhere sticks, whatever its shear
    partial_slip: flag;
    /// The sample is glued to its support; otherwise it slides without friction
    bonded_bottom: flag;
    /// No radial displacement of the lateral surface (a smooth rigid ring); otherwise it is free
    confined_side: flag;
};

const SOLVER: &[Variable] = section! { "solver.", (padded.solver):
    /// Integration scheme in time
    time_scheme: choice(&TimeScheme::NAMES);
    /// Direct solver of the linear systems
    linear_solver: choice(&LinearSolverKind::NAMES);
    /// Relative error allowed per step in the force
    tolerance: real(&ONE, (1e-9, 1.0));
    /// Travel of the punch within the first step after a change of its velocity
    initial_increment: real(&METRE, (1e-12, 1.0));
    /// Largest step
    max_step: real(&SECOND, (1e-9, 1e6));
    /// Newton iteration ends when the scaled residual is below this
    newton_tolerance: real(&ONE, (1e-14, 1e-2));
    /// Compute the outputs sensitivity.*.material.*: exact derivatives of the force by the material's parameters
    sensitivities: flag;
    /// Compute the outputs sensitivity.*.effect.*, too: exact derivatives by the magnitudes of effects, also
    /// where these are null; acts only with solver.sensitivities. Switches, sizes of the specimen, mesh,
    /// tolerances, the opening at which adhesion breaks and the delay of softening have none
    effect_sensitivities: flag;
};

const SOURCE: &[Variable] = section! { "protocol.", ():
    /// Where the displacement comes from; masters that give the inputs set 1 (inputs)
    source: choice(&ProtocolSource::NAMES);
};

const PROTOCOL: &[Variable] = section! { "protocol.", (trapezoid):
    /// Height of the punch above the surface at the start
    start_gap: real(&METRE, (0.0, 1.0));
    /// Velocity of loading
    loading_rate: real(&METRE_PER_SECOND, RATE);
    /// Largest indentation
    depth: real(&METRE, (0.0, 1.0));
    /// Hold at the largest indentation
    hold: real(&SECOND, DURATION);
    /// Velocity of unloading and of the return
    unloading_rate: real(&METRE_PER_SECOND, RATE);
    /// Height above the surface after unloading
    retraction: real(&METRE, (0.0, 1.0));
    /// Rest at the retracted height
    rest_after_retraction: real(&SECOND, DURATION);
    /// Height above the surface after the return
    return_height: real(&METRE, (0.0, 1.0));
    /// Rest at the return height
    rest_after_return: real(&SECOND, DURATION);
    /// Number of cycles; afterwards the punch rests
    cycles: integer(1, 1000);
};

const FIELDS: &[Variable] = section! { "fields.", (fields):
    /// Path of a .pvd file that the fields of the sample are written to while the FMU runs, for ParaView;
    /// its frames (.vtu) go to the folder of the same name beside it. Empty: nothing is written. One path
    /// for each instance
    path: text;
    /// Which communication points become frames; the first and the last (at fmi2Terminate) always do
    frames: choice(&Frames::NAMES);
    /// Least simulated time between two frames
    interval: real(&SECOND, DURATION);
};

/// The integer twin of an enumeration.
macro_rules! number {
    ($choice:literal, $name:literal, $enumeration:ty) => {
        variable(
            concat!($name, "_number"),
            concat!(
                "Number of the item of ",
                $name,
                ", for masters that cannot set enumerations; 0: as set there"
            ),
            Kind::Integer { range: Some((0, <$enumeration>::NAMES.items.len() as i32)) },
            Binding::Number($choice),
        )
    };
}

/// In the order of the enumerations in the table.
const NUMBERS: [Variable; CHOICES] = [
    number!(0, "indenter.profile", IndenterProfile),
    number!(1, "mesh.kind", MeshKind),
    number!(2, "mesh.preset", MeshPreset),
    number!(3, "solver.time_scheme", TimeScheme),
    number!(4, "solver.linear_solver", LinearSolverKind),
    number!(5, "protocol.source", ProtocolSource),
    number!(6, "fields.frames", Frames),
];

/// The sections in the order of the value references; those of the effects follow.
const SECTIONS: [&[Variable]; 24] = [
    INPUTS,
    OUTPUTS,
    STATISTICS,
    MATERIAL,
    EQUILIBRIUM,
    branch!(0, "1", fitted),
    branch!(1, "2", fitted),
    branch!(2, "3"),
    branch!(3, "4"),
    GEOMETRY,
    INDENTER,
    MESH,
    BOUNDARY,
    SOLVER,
    SOURCE,
    PROTOCOL,
    &sensitivities::FORCE,
    &sensitivities::FORCE_SOLID,
    &sensitivities::FORCE_FLUID,
    &sensitivities::FORCE_BY_EFFECT,
    &sensitivities::FORCE_SOLID_BY_EFFECT,
    &sensitivities::FORCE_FLUID_BY_EFFECT,
    FIELDS,
    &NUMBERS,
];

/// Parameters of all effects.
const EFFECTS: &[&[Parameter]] = crate::effect::PARAMETERS;

const LENGTH_OF_TABLE: usize = {
    let (mut number, mut length) = (0, 0);
    while number < SECTIONS.len() {
        length += SECTIONS[number].len();
        number += 1;
    }
    number = 0;
    while number < EFFECTS.len() {
        length += EFFECTS[number].len();
        number += 1;
    }
    length
};

/// Without any memory of its own: hosts load and free the library thousands of times.
pub(super) static TABLE: [Variable; LENGTH_OF_TABLE] = {
    let mut table = [SECTIONS[0][0]; LENGTH_OF_TABLE];
    let (mut number, mut at) = (0, 0);
    while number < SECTIONS.len() {
        let mut row = 0;
        while row < SECTIONS[number].len() {
            table[at] = SECTIONS[number][row];
            at += 1;
            row += 1;
        }
        number += 1;
    }
    number = 0;
    while number < EFFECTS.len() {
        let mut row = 0;
        while row < EFFECTS[number].len() {
            table[at] = of_effect(&EFFECTS[number][row]);
            at += 1;
            row += 1;
        }
        number += 1;
    }
    table
};
