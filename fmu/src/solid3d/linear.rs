//! Linear systems by GMRES on the exact tangent, preconditioned by single-precision factors of an earlier one.
//!
//! A factorisation costs about as much as fifty iterations. It is kept until the iterations beyond those
//! of fresh factors have cost as much as a new one.

use super::assembly::AssemblyMap;
use super::krylov::{DIMENSIONS, Krylov, norm};
use super::mesh::Mesh;
use crate::outputs::Statistics;
use crate::solver::linear::Singular;
use crate::solver::multifrontal::{self, Numeric, StructureError, Symbolic};
use crate::solver::pattern::CscPattern;
use std::sync::Arc;

/// Cost of a factorisation in iterations.
const FACTORISATION: usize = 40;
/// Iterations that fresh factors may need.
const FRESH: usize = 8;

/// The mesh as the ordering sees it.
///
/// # Errors
/// When the mesh has too many unknowns.
pub fn analyse(mesh: &Mesh, map: &AssemblyMap) -> Result<Arc<Symbolic>, StructureError> {
    let elements: Vec<Vec<u32>> = (0..map.cells()).map(|cell| map.unknowns(cell).to_vec()).collect();
    let centroids = (0..map.cells()).map(|cell| mesh.polar_centre(cell)).collect();
    let rank = mesh.pressure_mask().into_iter().map(u8::from).collect();
    let structure = multifrontal::Connectivity { unknowns: mesh.unknowns(), elements, centroids, rank };
    Ok(Arc::new(Symbolic::analyse(&structure, map.pattern.view())?))
}

/// Factors that serve several matrices; memory is kept.
pub struct FrozenSolver {
    numeric: Numeric<f32>,
    /// Iterations beyond [`FRESH`] since the last factorisation; `None` without factors.
    excess: Option<usize>,
    krylov: Krylov,
    residual: Vec<f64>,
    iterations: u64,
}

impl FrozenSolver {
    /// A solver for matrices of one structure.
    pub fn new(symbolic: Arc<Symbolic>) -> Self {
        let residual = vec![0.0; symbolic.unknowns()];
        let numeric = Numeric::new(symbolic);
        Self { numeric, excess: None, krylov: Krylov::default(), residual, iterations: 0 }
    }

    /// GMRES iterations since the start.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Solves in place to `reduction` of the residual that is left when the rows of `fixed` unknowns, which
    /// are those of the identity, are satisfied.
    ///
    /// # Errors
    /// When the matrix is singular, not finite or too ill-conditioned for single-precision factors.
    pub fn solve(
        &mut self,
        pattern: &CscPattern,
        values: &[f64],
        fixed: &[bool],
        rhs: &mut [f64],
        reduction: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Singular> {
        let mut x: Vec<f64> = rhs.iter().zip(fixed).map(|(&r, &f)| if f { r } else { 0.0 }).collect();
        product(pattern, values, &x, &mut self.residual);
        self.residual.iter_mut().zip(rhs.iter()).for_each(|(r, b)| *r = b - *r);
        let target = reduction * norm(&self.residual);
        let mut fresh = false;
        if self.excess.is_none_or(|e| e > FACTORISATION) {
            self.factorise(values, statistics)?;
            fresh = true;
        }
        loop {
            let left = norm(&self.residual);
            if left <= target {
                rhs.copy_from_slice(&x);
                return Ok(());
            }
            let numeric = &mut self.numeric;
            let outcome = self.krylov.solve(
                &mut x,
                &self.residual,
                target / left,
                |v, y| product(pattern, values, v, y),
                |z| numeric.solve_in_place(z, 1),
            );
            self.iterations += outcome.iterations as u64;
            self.excess = self.excess.map(|e| e + outcome.iterations.saturating_sub(FRESH));
            if outcome.reduction * left <= target * (1.0 + 1e-6) {
                rhs.copy_from_slice(&x);
                return Ok(());
            }
            if fresh || outcome.iterations == 0 {
                return Err(Singular);
            }
            // What DIMENSIONS iterations achieved is kept; new factors do the rest.
            debug_assert!(outcome.iterations <= DIMENSIONS);
            if !x.iter().all(|x| x.is_finite()) {
                return Err(Singular);
            }
            product(pattern, values, &x, &mut self.residual);
            self.residual.iter_mut().zip(rhs.iter()).for_each(|(r, b)| *r = b - *r);
            self.factorise(values, statistics)?;
            fresh = true;
        }
    }

    fn factorise(&mut self, values: &[f64], statistics: &mut Statistics) -> Result<(), Singular> {
        self.excess = None;
        statistics.factorisations += 1;
        self.numeric.factorise(values).map_err(|_| Singular)?;
        self.excess = Some(0);
        Ok(())
    }
}

/// `y = A x`.
fn product(pattern: &CscPattern, values: &[f64], x: &[f64], y: &mut [f64]) {
    y.fill(0.0);
    for (column, &x_c) in x.iter().enumerate().filter(|(_, x)| **x != 0.0) {
        let (first, rows) = pattern.column(column);
        for (value, &row) in values[first..first + rows.len()].iter().zip(rows) {
            y[row as usize] += value * x_c;
        }
    }
}
