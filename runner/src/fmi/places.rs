//! Where the scalars of an FMI 3.0 description are: variables of their own, or elements of arrays.

use std::collections::BTreeMap;

/// Type of an FMI 3.0 variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Base {
    Float64,
    Float32,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    /// Int64, and every enumeration.
    Int64,
    UInt64,
    Boolean,
    String,
}

/// One scalar: the element `index` of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Value reference of the variable.
    pub reference: u32,
    /// Element, from 0.
    pub index: usize,
    /// Type.
    pub base: Base,
}

/// Start values of a variable's elements.
#[derive(Debug, Clone, PartialEq)]
pub struct Elements {
    /// As numbers (Booleans: 0 or 1); texts have none.
    pub numbers: Vec<f64>,
    /// As texts.
    pub texts: Vec<String>,
}

/// All scalars of an FMI 3.0 description by the references that this program gives them; empty for FMI 2.0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Places {
    /// Scalars.
    pub scalars: BTreeMap<u32, Place>,
    /// Start values of the variables by their own references.
    pub starts: BTreeMap<u32, Elements>,
}
