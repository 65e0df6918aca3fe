//! The entries. Starts come from `Default`, so no number of the model is written twice.

use super::settings::CHOICES;
use super::{
    Binding, Causality, Enumeration, Identification, Kind, ProtocolSource, Readings, Variability, Variable,
    sensitivities,
};
use crate::contact::parameters::IndenterProfile;
use crate::effect::{Access, Parameter};
use crate::interface::recording::Frames;
use crate::mesh::parameters::{MeshKind, MeshPreset};
use crate::parameters::CONE_HALF_ANGLE;
use crate::solver::parameters::{LinearSolverKind, TimeScheme};
use crate::unit::{
    CUBIC_METRE, JOULE, METRE, METRE_PER_SECOND, NEWTON, ONE, PASCAL, PASCAL_SECOND, RADIAN, SECOND,
    SQUARE_METRE, Unit, WATT,
};

const MESH_PRESET: Enumeration = Enumeration {
    name: "MeshPreset",
    items: &[
        ("coarse", "For trying things out"),
        ("standard", "Within 0.5 % of the zero-mesh-size limit"),
        ("fine", "Within 0.2 % of the zero-mesh-size limit"),
    ],
};
const MESH_KIND: Enumeration = Enumeration {
    name: "MeshKind",
    items: &[
        ("axisymmetric", "Axisymmetric elements: exact for this test, and hundreds of times cheaper"),
        ("paper-3d", "Quarter of the cylinder in 3184 hexahedra with hanging nodes, of the paper's size"),
    ],
};
const PROFILE: Enumeration = Enumeration {
    name: "IndenterProfile",
    items: &[
        ("flat", "A flat punch; at least as wide as the sample it is a platen"),
        ("sphere", "A sphere of indenter.sphere_radius"),
        ("cone", "A cone of indenter.cone_half_angle"),
    ],
};
const TIME_SCHEME: Enumeration = Enumeration {
    name: "TimeScheme",
    items: &[
        ("sdirk2", "Two-stage, stiffly accurate, L-stable SDIRK: second order"),
        ("backward_euler", "Backward Euler, the paper's: first order"),
    ],
};
const LINEAR_SOLVER: Enumeration = Enumeration {
    name: "LinearSolver",
    items: &[
        ("multifrontal", "Multifrontal LU along the mesh's nested dissection"),
        ("faer", "faer's sparse LU with partial pivoting: slower, for comparison"),
    ],
};
const PROTOCOL_SOURCE: Enumeration = Enumeration {
    name: "ProtocolSource",
    items: &[
        ("inputs", "The punch follows the inputs displacement and displacement_rate"),
        ("trapezoid", "The punch follows the built-in protocol; setting the inputs is an error"),
    ],
};

const FIELD_FRAMES: Enumeration = Enumeration {
    name: "FieldFrames",
    items: &[
        (
            "adaptive",
            "When the punch has moved by a twentieth of its radius, turns or stops, and ever wider apart while it \
             rests: some thirty frames of a load and hold",
        ),
        ("every_step", "At every communication point"),
    ],
};

/// Reader and writer of a field of `Settings`.
macro_rules! field {
    ($kind:ident, $($path:ident).+) => {
        $crate::interface::variables::Binding::$kind(|s| s.$($path).+, |s, v| s.$($path).+ = v)
    };
}

/// Reader and writer of an enumeration, its items in the order of the variants.
macro_rules! choice {
    ($first:path, [$($variant:path),+], $($path:ident).+) => {
        Binding::Integer(
            |s| s.$($path).+ as i32 + 1,
            |s, v| s.$($path).+ = [$($variant),+].into_iter().find(|x| *x as i32 + 1 == v).unwrap_or($first),
        )
    };
}

pub(super) const fn variable(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    binding: Binding,
) -> Variable {
    let (causality, variability) = match binding {
        Binding::RealOutput(_) | Binding::Sensitivity(..) => (Causality::Output, Variability::Continuous),
        Binding::IntegerOutput(_) => (Causality::Output, Variability::Discrete),
        _ => (Causality::Parameter, Variability::Fixed),
    };
    Variable { name, description, causality, variability, kind, identification: None, binding }
}

const fn real(
    name: &'static str,
    description: &'static str,
    unit: &'static Unit,
    (min, max): (f64, f64),
    binding: Binding,
) -> Variable {
    variable(name, description, Kind::Real { unit, range: Some((min, max)) }, binding)
}

const fn flag(name: &'static str, description: &'static str, binding: Binding) -> Variable {
    variable(name, description, Kind::Boolean, binding)
}

const fn output(
    name: &'static str,
    description: &'static str,
    unit: &'static Unit,
    get: fn(&Readings) -> f64,
) -> Variable {
    variable(name, description, Kind::Real { unit, range: None }, Binding::RealOutput(get))
}

const fn count(name: &'static str, description: &'static str, get: fn(&Readings) -> i32) -> Variable {
    variable(name, description, Kind::Integer { range: None }, Binding::IntegerOutput(get))
}

/// FMI integers have 32 bits.
fn saturate(count: u64) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}

impl Variable {
    /// Bounds of Table 1 (SI).
    const fn fitted(mut self, lower: f64, upper: f64) -> Self {
        self.identification = Some(Identification { lower, upper, free: true });
        self
    }

    const fn input(mut self, variability: Variability) -> Self {
        self.causality = Causality::Input;
        self.variability = variability;
        self
    }
}

const MU: (f64, f64) = (-1e9, 1e9);
const ALPHA: (f64, f64) = (-100.0, 100.0);
const ETA: (f64, f64) = (1e-9, 1e12);
const LENGTH: (f64, f64) = (1e-6, 1.0);
const DURATION: (f64, f64) = (0.0, 1e6);
const RATE: (f64, f64) = (1e-9, 1.0);

const INPUTS: &[Variable] = &[
    real(
        "displacement",
        "Displacement of the punch, positive into the sample; 0 touches the undeformed surface. \
             Within a step the punch moves linearly to displacement + rate * step",
        &METRE,
        (-1.0, 1.0),
        field!(Real, displacement),
    )
    .input(Variability::Continuous),
    real(
        "displacement_rate",
        "Velocity of the punch during the next step, for masters that set inputs only at the start of \
             a step; the input derivative of displacement, where set, takes its place",
        &METRE_PER_SECOND,
        (-1.0, 1.0),
        field!(Real, displacement_rate),
    )
    .input(Variability::Discrete),
];

const OUTPUTS: &[Variable] = &[
    output(
        "force",
        "What the load cell reads: the reaction force on the punch (work-conjugate, nodal), unless an effect \
             of the sensor is on",
        &NEWTON,
        |r| r.outputs.force,
    ),
    output("force_solid", "Part of force_specimen carried by the solid", &NEWTON, |r| r.outputs.force_solid),
    output("force_fluid", "Part of force_specimen carried by the pore pressure", &NEWTON, |r| {
        r.outputs.force_fluid
    }),
    output(
        "force_traction",
        "Surface integral of the traction under the punch, as the paper reports it; does not converge \
             with the mesh",
        &NEWTON,
        |r| r.outputs.force_traction,
    ),
    output(
        "force_specimen",
        "Reaction force of the specimen on the punch (work-conjugate, nodal)",
        &NEWTON,
        |r| r.outputs.force_specimen,
    ),
    output("punch_displacement", "Displacement reached, as it is measured", &METRE, |r| {
        r.outputs.displacement
    }),
    output(
        "indentation",
        "Depth of the punch's face below the true surface: punch_displacement, plus the contact point's \
             offset, less what the machine yields",
        &METRE,
        |r| r.outputs.indentation,
    ),
    output("viscous_dissipation_rate", "Viscous dissipation rate (Eq. 13)", &WATT, |r| {
        r.outputs.viscous_dissipation_rate
    }),
    output("viscous_dissipation", "Viscous dissipation since the start", &JOULE, |r| {
        r.outputs.viscous_dissipation
    }),
    output("porous_dissipation_rate", "Porous dissipation rate (Eq. 14)", &WATT, |r| {
        r.outputs.porous_dissipation_rate
    }),
    output("porous_dissipation", "Porous dissipation since the start", &JOULE, |r| {
        r.outputs.porous_dissipation
    }),
    output("stored_energy", "Stored energy of equilibrium, branches and volume", &JOULE, |r| {
        r.outputs.stored_energy
    }),
    output("external_work", "Work of the punch since the start", &JOULE, |r| r.outputs.external_work),
    output("fluid_expelled", "Fluid volume pressed out of the sample", &CUBIC_METRE, |r| {
        r.outputs.fluid_expelled
    }),
];

const STATISTICS: &[Variable] = &[
    count("statistics.steps", "Accepted time steps", |r| saturate(r.statistics.steps)),
    count("statistics.iterations", "Newton iterations", |r| saturate(r.statistics.iterations)),
    count("statistics.factorisations", "Matrix factorisations", |r| saturate(r.statistics.factorisations)),
    count("statistics.cuts", "Steps cut after a failure or an excessive error", |r| {
        saturate(r.statistics.cuts)
    }),
];

const MATERIAL: &[Variable] = &[
    real(
        "material.n0s",
        "Initial solid volume fraction n0S",
        &ONE,
        (1e-6, 0.999),
        field!(Real, padded.material.n0s),
    ),
    real(
        "material.lambda_star",
        "Volumetric stiffness lambda* (Eq. 10)",
        &PASCAL,
        (1e-3, 1e12),
        field!(Real, padded.material.lambda_star),
    ),
    real(
        "material.fluid_viscosity",
        "Dynamic viscosity mu_FR of the pore fluid",
        &PASCAL_SECOND,
        (1e-9, 1e6),
        field!(Real, padded.material.fluid_viscosity),
    ),
    real(
        "material.permeability",
        "Initial intrinsic permeability K0 (Eq. 11)",
        &SQUARE_METRE,
        (1e-30, 1e-3),
        field!(Real, padded.material.permeability),
    )
    .fitted(1e-20, 1e-8),
    real(
        "material.equilibrium.mu",
        "Ogden coefficient mu of the equilibrium response (Eq. 8); has the sign of alpha",
        &PASCAL,
        MU,
        field!(Real, padded.material.equilibrium.mu),
    )
    .fitted(-1000.0, -1.0),
    real(
        "material.equilibrium.alpha",
        "Ogden exponent alpha of the equilibrium response (Eq. 8)",
        &ONE,
        ALPHA,
        field!(Real, padded.material.equilibrium.alpha),
    )
    .fitted(-30.0, -1.0),
];

/// Variables of one branch; the paper identifies two of them (bounds of Table 1).
macro_rules! branch {
    ($index:literal, $number:literal $(, $fitted:ident)?) => {
        &[
            real(
                concat!("material.branch[", $number, "].mu"),
                concat!("Ogden coefficient mu of viscous branch ", $number, " (Eq. 9); 0 switches the branch off"),
                &PASCAL,
                MU,
                Binding::Real(|s| s.branch::<$index>().ogden.mu, |s, v| s.branch_mut::<$index>().ogden.mu = v),
            )
            $(.$fitted(-1000.0, -1.0))?,
            real(
                concat!("material.branch[", $number, "].alpha"),
                concat!("Ogden exponent alpha of viscous branch ", $number, " (Eq. 9)"),
                &ONE,
                ALPHA,
                Binding::Real(
                    |s| s.branch::<$index>().ogden.alpha,
                    |s, v| s.branch_mut::<$index>().ogden.alpha = v,
                ),
            )
            $(.$fitted(-30.0, -1.0))?,
            real(
                concat!("material.branch[", $number, "].eta"),
                concat!("Viscosity eta of viscous branch ", $number, " (Eq. 12)"),
                &PASCAL_SECOND,
                ETA,
                Binding::Real(|s| s.branch::<$index>().eta, |s, v| s.branch_mut::<$index>().eta = v),
            )
            $(.$fitted(1.0, 1e5))?,
        ]
    };
}

const GEOMETRY: &[Variable] = &[
    real(
        "geometry.punch_radius",
        "Radius of the flat punch, or of the shank of a sphere or cone: the largest contact radius, up to which \
             the mesh is fine. A flat punch at least as wide as the sample is a platen",
        &METRE,
        LENGTH,
        field!(Real, padded.geometry.punch_radius),
    ),
    real(
        "geometry.sample_radius",
        "Radius of the sample",
        &METRE,
        LENGTH,
        field!(Real, padded.geometry.sample_radius),
    ),
    real(
        "geometry.sample_height",
        "Height of the sample",
        &METRE,
        LENGTH,
        field!(Real, padded.geometry.sample_height),
    ),
];

const INDENTER: &[Variable] = &[
    variable(
        "indenter.profile",
        "Shape of the punch's face",
        Kind::Enumeration(&PROFILE),
        choice!(
            IndenterProfile::Flat,
            [IndenterProfile::Flat, IndenterProfile::Sphere, IndenterProfile::Cone],
            padded.indenter.profile
        ),
    ),
    real(
        "indenter.edge_radius",
        "Radius of a flat punch's edge, from 1e-5 of geometry.punch_radius to all of it; 0: sharp; acts only with indenter.profile = flat",
        &METRE,
        (0.0, 1e3),
        field!(Real, padded.indenter.edge_radius),
    ),
    real(
        "indenter.sphere_radius",
        "Radius of a sphere, at least geometry.punch_radius, the shank's: equal, it is a hemisphere; acts only with indenter.profile = sphere",
        &METRE,
        (1e-6, 1e3),
        field!(Real, padded.indenter.sphere_radius),
    ),
    real(
        "indenter.cone_half_angle",
        "Angle between the axis and the flank of a cone; acts only with indenter.profile = cone",
        &RADIAN,
        CONE_HALF_ANGLE,
        field!(Real, padded.indenter.cone_half_angle),
    ),
];

const MESH: &[Variable] = &[
    variable(
        "mesh.kind",
        "Discretisation; the other mesh parameters are those of the axisymmetric one",
        Kind::Enumeration(&MESH_KIND),
        choice!(MeshKind::Axisymmetric, [MeshKind::Axisymmetric, MeshKind::Paper3d], padded.mesh.kind),
    ),
    variable(
        "mesh.preset",
        "Mesh, from quick to accurate",
        Kind::Enumeration(&MESH_PRESET),
        choice!(
            MeshPreset::Standard,
            [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine],
            padded.mesh.preset
        ),
    ),
    real(
        "mesh.edge_size",
        "Size of the innermost ring of elements at the punch's edge, of the elements under a sphere or cone, or \
             at the side under a platen; 0 takes the preset's",
        &METRE,
        (0.0, 1.0),
        field!(Real, padded.mesh.edge_size),
    ),
    real(
        "mesh.growth",
        "Ratio of neighbouring rings of elements, or of elements away from the contact; 0 takes the preset's",
        &ONE,
        (0.0, 10.0),
        field!(Real, padded.mesh.growth),
    ),
    variable(
        "mesh.divisions",
        "Elements along the inner side of every ring around a flat punch's edge; 0 takes the preset's",
        Kind::Integer { range: Some((0, 64)) },
        // The range lets no negative number through.
        Binding::Integer(
            |s| s.padded.mesh.divisions.cast_signed(),
            |s, v| s.padded.mesh.divisions = v.unsigned_abs(),
        ),
    ),
];

const BOUNDARY: &[Variable] = &[
    flag(
        "boundary.drained_bottom",
        "Pore pressure 0 on the bottom; otherwise no flux",
        field!(Boolean, padded.boundary.drained_bottom),
    ),
    flag(
        "boundary.drained_side",
        "Pore pressure 0 on the lateral surface; otherwise no flux",
        field!(Boolean, padded.boundary.drained_side),
    ),
    flag(
        "boundary.drained_top",
        "Pore pressure 0 on the free part of the top; otherwise no flux",
        field!(Boolean, padded.boundary.drained_top),
    ),
    flag(
        "boundary.drained_punch",
        "Pore pressure 0 under the punch (porous punch); otherwise no flux",
        field!(Boolean, padded.boundary.drained_punch),
    ),
    flag(
        "boundary.bonded_punch",
        "The sample sticks to the punch until the punch pulls at it; otherwise it slides without friction",
        field!(Boolean, padded.boundary.bonded_punch),
    ),
    real(
        "boundary.friction",
        "Friction coefficient of a bonded punch: where the face begins to open - with boundary.partial_slip \
             everywhere - the bond fails and the sample slides once its shear exceeds this times the pressure",
        &ONE,
        (0.0, 1000.0),
        field!(Real, padded.boundary.friction),
    ),
    flag(
        "boundary.partial_slip",
        "A bonded punch holds the sample by boundary.friction alone: Coulomb's law everywhere on the face, under \
             pressure, too; otherwise a face that is pressed down everywhere sticks, whatever its shear",
        field!(Boolean, padded.boundary.partial_slip),
    ),
    flag(
        "boundary.bonded_bottom",
        "The sample is glued to its support; otherwise it slides without friction",
        field!(Boolean, padded.boundary.bonded_bottom),
    ),
    flag(
        "boundary.confined_side",
        "No radial displacement of the lateral surface (a smooth rigid ring); otherwise it is free",
        field!(Boolean, padded.boundary.confined_side),
    ),
];

const SOLVER: &[Variable] = &[
    variable(
        "solver.time_scheme",
        "Integration scheme in time",
        Kind::Enumeration(&TIME_SCHEME),
        choice!(
            TimeScheme::Sdirk2,
            [TimeScheme::Sdirk2, TimeScheme::BackwardEuler],
            padded.solver.time_scheme
        ),
    ),
    variable(
        "solver.linear_solver",
        "Direct solver of the linear systems",
        Kind::Enumeration(&LINEAR_SOLVER),
        choice!(
            LinearSolverKind::Multifrontal,
            [LinearSolverKind::Multifrontal, LinearSolverKind::Faer],
            padded.solver.linear_solver
        ),
    ),
    real(
        "solver.tolerance",
        "Relative error allowed per step in the force",
        &ONE,
        (1e-9, 1.0),
        field!(Real, padded.solver.tolerance),
    ),
    real(
        "solver.initial_increment",
        "Travel of the punch within the first step after a change of its velocity",
        &METRE,
        (1e-12, 1.0),
        field!(Real, padded.solver.initial_increment),
    ),
    real("solver.max_step", "Largest step", &SECOND, (1e-9, 1e6), field!(Real, padded.solver.max_step)),
    real(
        "solver.newton_tolerance",
        "Newton iteration ends when the scaled residual is below this",
        &ONE,
        (1e-14, 1e-2),
        field!(Real, padded.solver.newton_tolerance),
    ),
    flag(
        "solver.sensitivities",
        "Compute the outputs sensitivity.*: exact derivatives of the force by the material's parameters",
        field!(Boolean, padded.solver.sensitivities),
    ),
];

const PROTOCOL: &[Variable] = &[
    variable(
        "protocol.source",
        "Where the displacement comes from; masters that give the inputs set 1 (inputs)",
        Kind::Enumeration(&PROTOCOL_SOURCE),
        choice!(ProtocolSource::Inputs, [ProtocolSource::Inputs, ProtocolSource::Trapezoid], source),
    ),
    real(
        "protocol.start_gap",
        "Height of the punch above the surface at the start",
        &METRE,
        (0.0, 1.0),
        field!(Real, trapezoid.start_gap),
    ),
    real(
        "protocol.loading_rate",
        "Velocity of loading",
        &METRE_PER_SECOND,
        RATE,
        field!(Real, trapezoid.loading_rate),
    ),
    real("protocol.depth", "Largest indentation", &METRE, (0.0, 1.0), field!(Real, trapezoid.depth)),
    real("protocol.hold", "Hold at the largest indentation", &SECOND, DURATION, field!(Real, trapezoid.hold)),
    real(
        "protocol.unloading_rate",
        "Velocity of unloading and of the return",
        &METRE_PER_SECOND,
        RATE,
        field!(Real, trapezoid.unloading_rate),
    ),
    real(
        "protocol.retraction",
        "Height above the surface after unloading",
        &METRE,
        (0.0, 1.0),
        field!(Real, trapezoid.retraction),
    ),
    real(
        "protocol.rest_after_retraction",
        "Rest at the retracted height",
        &SECOND,
        DURATION,
        field!(Real, trapezoid.rest_after_retraction),
    ),
    real(
        "protocol.return_height",
        "Height above the surface after the return",
        &METRE,
        (0.0, 1.0),
        field!(Real, trapezoid.return_height),
    ),
    real(
        "protocol.rest_after_return",
        "Rest at the return height",
        &SECOND,
        DURATION,
        field!(Real, trapezoid.rest_after_return),
    ),
    variable(
        "protocol.cycles",
        "Number of cycles; afterwards the punch rests",
        Kind::Integer { range: Some((1, 1000)) },
        field!(Integer, trapezoid.cycles),
    ),
];

const FIELDS: &[Variable] = &[
    variable(
        "fields.path",
        "Path of a .pvd file that the fields of the sample are written to while the FMU runs, for ParaView; its \
             frames (.vtu) go to the folder of the same name beside it. Empty: nothing is written. One path for each \
             instance",
        Kind::Text,
        Binding::Text(|s| &s.fields.path, |s, v| s.fields.path = v),
    ),
    variable(
        "fields.frames",
        "Which communication points become frames; the first and the last (at fmi2Terminate) always do",
        Kind::Enumeration(&FIELD_FRAMES),
        choice!(Frames::Adaptive, [Frames::Adaptive, Frames::EveryStep], fields.frames),
    ),
    real(
        "fields.interval",
        "Least simulated time between two frames",
        &SECOND,
        DURATION,
        field!(Real, fields.interval),
    ),
];

/// The integer twin of an enumeration.
macro_rules! number {
    ($choice:literal, $name:literal, $enumeration:ident) => {
        variable(
            concat!($name, "_number"),
            concat!(
                "Number of the item of ",
                $name,
                ", for masters that cannot set enumerations; 0: as set there"
            ),
            Kind::Integer { range: Some((0, $enumeration.items.len() as i32)) },
            Binding::Number($choice),
        )
    };
}

/// In the order of the enumerations in the table.
const NUMBERS: [Variable; CHOICES] = [
    number!(0, "indenter.profile", PROFILE),
    number!(1, "mesh.kind", MESH_KIND),
    number!(2, "mesh.preset", MESH_PRESET),
    number!(3, "solver.time_scheme", TIME_SCHEME),
    number!(4, "solver.linear_solver", LINEAR_SOLVER),
    number!(5, "protocol.source", PROTOCOL_SOURCE),
    number!(6, "fields.frames", FIELD_FRAMES),
];

/// The sections in the order of the value references; those of the effects follow.
const SECTIONS: [&[Variable]; 19] = [
    INPUTS,
    OUTPUTS,
    STATISTICS,
    MATERIAL,
    branch!(0, "1", fitted),
    branch!(1, "2", fitted),
    branch!(2, "3"),
    branch!(3, "4"),
    GEOMETRY,
    INDENTER,
    MESH,
    BOUNDARY,
    SOLVER,
    PROTOCOL,
    &sensitivities::FORCE,
    &sensitivities::FORCE_SOLID,
    &sensitivities::FORCE_FLUID,
    FIELDS,
    &NUMBERS,
];

/// Parameters of all effects.
const EFFECTS: &[&[Parameter]] = crate::effect::PARAMETERS;

/// The row of an effect's parameter.
const fn of_effect(parameter: &Parameter) -> Variable {
    let (kind, binding) = match parameter.access {
        Access::Real { unit, range, get, set } => {
            (Kind::Real { unit, range: Some(range) }, Binding::EffectReal(get, set))
        }
        Access::Flag { get, set } => (Kind::Boolean, Binding::EffectFlag(get, set)),
    };
    variable(parameter.name, parameter.description, kind, binding)
}

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
