//! The enumerations of the table: their items, in FMI's words and in the program's.

use super::{Enumeration, ProtocolSource};
use crate::contact::parameters::IndenterProfile;
use crate::interface::recording::Frames;
use crate::mesh::parameters::{MeshKind, MeshPreset};
use crate::solver::parameters::{LinearSolverKind, TimeScheme};

/// A type whose values are the items of an enumeration, in the order of its variants.
pub(super) trait Choice: Copy + Default + 'static {
    /// The values.
    const ITEMS: &'static [Self];
    /// Their names.
    const NAMES: Enumeration;

    /// The value with this number, counted from 1; the check of the range lets no other number through.
    fn of_number(number: i32) -> Self {
        let item = usize::try_from(number).ok().and_then(|number| Self::ITEMS.get(number.checked_sub(1)?));
        item.copied().unwrap_or_default()
    }
}

impl Choice for IndenterProfile {
    const ITEMS: &'static [Self] = &[Self::Flat, Self::Sphere, Self::Cone];
    const NAMES: Enumeration = Enumeration {
        name: "IndenterProfile",
        items: &[
            ("flat", "A flat punch; at least as wide as the sample it is a platen"),
            ("sphere", "A sphere of indenter.sphere_radius"),
            ("cone", "A cone of indenter.cone_half_angle"),
        ],
    };
}

impl Choice for MeshKind {
    const ITEMS: &'static [Self] = &[Self::Axisymmetric, Self::Paper3d];
    const NAMES: Enumeration = Enumeration {
        name: "MeshKind",
        items: &[
            ("axisymmetric", "Axisymmetric elements: exact for this test, and hundreds of times cheaper"),
            ("paper-3d", "Quarter of the cylinder in 3184 hexahedra with hanging nodes, of the paper's size"),
        ],
    };
}

impl Choice for MeshPreset {
    const ITEMS: &'static [Self] = &[Self::Coarse, Self::Standard, Self::Fine];
    const NAMES: Enumeration = Enumeration {
        name: "MeshPreset",
        items: &[
            ("coarse", "For trying things out"),
            ("standard", "Within 0.5 % of the zero-mesh-size limit"),
            ("fine", "Within 0.2 % of the zero-mesh-size limit"),
        ],
    };
}

impl Choice for TimeScheme {
    const ITEMS: &'static [Self] = &[Self::Sdirk2, Self::BackwardEuler];
    const NAMES: Enumeration = Enumeration {
        name: "TimeScheme",
        items: &[
            ("sdirk2", "Two-stage, stiffly accurate, L-stable SDIRK: second order"),
            ("backward_euler", "Backward Euler, the paper's: first order"),
        ],
    };
}

impl Choice for LinearSolverKind {
    const ITEMS: &'static [Self] = &[Self::Multifrontal, Self::Faer];
    const NAMES: Enumeration = Enumeration {
        name: "LinearSolver",
        items: &[
            ("multifrontal", "Multifrontal LU along the mesh's nested dissection"),
            ("faer", "faer's sparse LU with partial pivoting: slower, for comparison"),
        ],
    };
}

impl Choice for ProtocolSource {
    const ITEMS: &'static [Self] = &[Self::Inputs, Self::Trapezoid];
    const NAMES: Enumeration = Enumeration {
        name: "ProtocolSource",
        items: &[
            ("inputs", "The punch follows the inputs displacement and displacement_rate"),
            ("trapezoid", "The punch follows the built-in protocol; setting the inputs is an error"),
        ],
    };
}

impl Choice for Frames {
    const ITEMS: &'static [Self] = &[Self::Adaptive, Self::EveryStep];
    const NAMES: Enumeration = Enumeration {
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
}
