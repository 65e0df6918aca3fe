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

/// The enumerations: type, FMI's name, and each item's value, name and meaning.
macro_rules! choices {
    ($($choice:ident $type_name:literal { $($item:ident: $name:literal, $meaning:literal;)+ })+) => {
        $(impl Choice for $choice {
            const ITEMS: &'static [Self] = &[$(Self::$item),+];
            const NAMES: Enumeration = Enumeration { name: $type_name, items: &[$(($name, $meaning)),+] };
        })+
    };
}

choices! {
    IndenterProfile "IndenterProfile" {
        Flat: "flat", "A flat punch; at least as wide as the sample it is a platen";
        Sphere: "sphere", "A sphere of indenter.sphere_radius";
        Cone: "cone", "A cone of indenter.cone_half_angle";
    }
    MeshKind "MeshKind" {
        Axisymmetric: "axisymmetric",
            "Axisymmetric elements: exact for this test, and hundreds of times cheaper";
        Paper3d: "paper-3d",
            "Quarter of the cylinder in 3184 hexahedra with hanging nodes, of the paper's size";
    }
    MeshPreset "MeshPreset" {
        Coarse: "coarse", "For trying things out";
        Standard: "standard", "Within 0.5 % of the zero-mesh-size limit";
        Fine: "fine", "Within 0.2 % of the zero-mesh-size limit";
    }
    TimeScheme "TimeScheme" {
        Sdirk2: "sdirk2", "Two-stage, stiffly accurate, L-stable SDIRK: second order";
        BackwardEuler: "backward_euler", "Backward Euler, the paper's: first order";
    }
    LinearSolverKind "LinearSolver" {
        Multifrontal: "multifrontal", "Multifrontal LU along the mesh's nested dissection";
        Faer: "faer", "faer's sparse LU with partial pivoting: slower, for comparison";
    }
    ProtocolSource "ProtocolSource" {
        Inputs: "inputs", "The punch follows the inputs displacement and displacement_rate";
        Trapezoid: "trapezoid", "The punch follows the built-in protocol; setting the inputs is an error";
    }
    Frames "FieldFrames" {
        Adaptive: "adaptive",
            "When the punch has moved by a twentieth of its radius, turns or stops, and ever wider apart \
             while it rests: some thirty frames of a load and hold";
        EveryStep: "every_step", "At every communication point";
    }
}
