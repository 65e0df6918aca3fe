//! Newton's method for one step, with the machine's compliance where there is one.

use crate::error::Failure;
use crate::linear::Factors;
use crate::system::{Equations, Memory, Step, System, Unknowns};

/// The machine as a spring that stiffens: shortening `C F0 asinh(F/F0)` under a force F.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Initial compliance C (m/N).
    pub per_newton: f64,
    /// F0 (N).
    pub stiffening_force: f64,
}

impl Frame {
    fn shortening(&self, force: f64) -> (f64, f64) {
        let x = force / self.stiffening_force;
        (self.per_newton * self.stiffening_force * x.asinh(), self.per_newton / x.hypot(1.0))
    }
}

/// Corrections below this part of the punch's radius end the iteration, which then converges quadratically.
const SMALL: f64 = 1e-6;
/// Most corrections.
const MOST: usize = 25;
/// A correction by new factors below this part of the radius: they are good enough for the next one.
const NEAR: f64 = 1e-3;
/// Contraction of the corrections with old factors below which these are kept.
const CONTRACTION: f64 = 0.1;

/// Solver of steps, with its working memory.
#[derive(Default)]
pub struct Newton {
    equations: Equations,
    right: Vec<f64>,
    column: Vec<f64>,
}

/// End of a step.
#[derive(Debug, Clone, Copy)]
pub struct Solved {
    /// Force on the specimen (N).
    pub force: f64,
    /// The punch's depth (m); the motion's less the machine's shortening.
    pub depth: f64,
}

impl Newton {
    /// Solves a step towards `target` (m) of the motion from the guesses `x` and `depth`.
    ///
    /// # Errors
    /// Why it failed; `x` is then of no use.
    #[expect(clippy::too_many_arguments)]
    pub fn solve(
        &mut self,
        system: &System,
        frame: Option<&Frame>,
        target: f64,
        guess: f64,
        x: &mut Unknowns,
        step: &Step<'_>,
        now: &mut Memory,
    ) -> Result<Solved, Failure> {
        let displacements = 2 * system.mesh.nodes.len();
        let radius = system.punch_radius;
        let mut depth = if frame.is_some() { guess } else { target };
        let mut factored = Vec::new();
        let mut factors: Option<Factors<'_>> = None;
        let (mut size, mut done, mut circling) = (f64::INFINITY, false, 0);
        for _ in 0..MOST {
            let branches = system.branches(x, depth, step);
            done &= branches == factored;
            if branches != factored {
                factors = None;
            }
            let fresh = !done && factors.is_none();
            system.assemble(x, depth, step, fresh, now, &mut self.equations)?;
            if done {
                return Ok(Solved { force: self.equations.force, depth });
            }
            if fresh {
                factors = Some(system.pattern.factorise(&self.equations.tangent)?);
                factored = branches;
            }
            let Some(lu) = &factors else { return Err(Failure::Singular) };
            self.right.clone_from(&self.equations.residual);
            lu.solve(&mut self.right)?;
            let mut moved = 0.0;
            if let Some(frame) = frame {
                self.column.clone_from(&self.equations.by_depth);
                lu.solve(&mut self.column)?;
                let (shortening, slope) = frame.shortening(self.equations.force);
                let by = |v: &[f64]| self.equations.by_depth.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
                let miss = depth + shortening - target - slope * by(&self.right);
                moved = -miss / (1.0 + slope * (self.equations.force_by_depth - by(&self.column)));
                for (r, c) in self.right.iter_mut().zip(&self.column) {
                    *r += moved * c;
                }
            }
            // Points that change between stick and slip, or open and closed, in turn: half the way settles them.
            let part = if circling > 1 { 0.5 } else { 1.0 };
            depth += part * moved;
            let mut next = moved.abs() / radius;
            for (i, equation) in system.equation.iter().enumerate() {
                if let Some(e) = equation {
                    x[i] -= part * self.right[*e];
                    if i < displacements {
                        next = next.max(self.right[*e].abs() / radius);
                    }
                }
            }
            if !next.is_finite() || next > 1.0 {
                return Err(Failure::Newton);
            }
            circling = if next > 0.5 * size { circling + 1 } else { 0 };
            done = next < SMALL && part == 1.0;
            // Old factors serve the small corrections, as long as these shrink fast.
            if circling > 0 || next > if fresh { NEAR } else { CONTRACTION * size } {
                factors = None;
            }
            size = next;
        }
        Err(Failure::Newton)
    }
}
