//! Multifrontal LU for finite-element tangents: symmetric pattern, unsymmetric values.
//!
//! ```text
//! Connectivity (elements)  --ordering-->  dissection tree  --symbolic-->  fronts, maps, workspace sizes
//! CSC values            --numeric--->  factors of each front           --solve--->  unknowns
//! ```
//!
//! A front is the dense matrix of the unknowns that one separator of the mesh eliminates (its *own*
//! unknowns) and of those they still couple to (its *border*):
//!
//! ```text
//! [ F11 F12 ]   own      F11 = P^T L U, pivots chosen inside F11
//! [ F21 F22 ]   border   L21 = F21 U^-1, U12 = L^-1 P F12, contribution to the parent: F22 - L21 U12
//! ```
//!
//! After Duff and Reid, *The multifrontal solution of unsymmetric sets of linear equations*, SIAM J. Sci.
//! Stat. Comput. 5 (1984). The ordering is George's nested dissection, taken over the elements.

mod assembly;
mod dense;
mod lu;
mod numeric;
mod ordering;
mod solve;
mod symbolic;

#[cfg(test)]
mod test_matrices;
#[cfg(test)]
mod tests;

pub use dense::Scalar;
pub use numeric::Numeric;
pub use ordering::Connectivity;
pub use symbolic::{FactorSizes, Symbolic};

use thiserror::Error;

/// Why a matrix structure cannot be analysed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum StructureError {
    /// Lists that belong together have different lengths, or an index is out of range.
    #[error("inconsistent structure: {0}")]
    Inconsistent(&'static str),
    /// More elements than are reasonable.
    #[error("too many elements")]
    TooLarge,
    /// A matrix entry couples two unknowns that share no element.
    #[error("entry ({row}, {column}) couples unknowns that share no element")]
    EntryOutsideElements {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
}

/// A front without an acceptable pivot: the matrix is singular or holds numbers that are not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("singular matrix: no pivot for unknown {unknown}")]
pub struct SingularMatrix {
    /// Unknown (column of the matrix) that has no pivot.
    pub unknown: usize,
}
