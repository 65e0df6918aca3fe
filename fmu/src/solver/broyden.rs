//! Corrections with old factors, improved by what the ones before them have shown of the tangent (Broyden's method; Kelley,
//! Solving Nonlinear Equations with Newton's Method, 2003, chapter 4).

/// More steps than these are not worth their cost: new factors are better.
const MOST: usize = 8;
/// A step that is prolonged more than this many times tells more of noise than of the tangent.
const LONGEST: f64 = 10.0;

/// Dimensionless corrections since the last factorisation, first to last.
#[derive(Debug, Clone, Default)]
pub(super) struct Secants {
    /// With their squared norms; only the first `count` mean something.
    steps: Vec<(Vec<f64>, f64)>,
    count: usize,
}

impl Secants {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes note of a correction, which is made as it is.
    pub fn note(&mut self, correction: &[f64]) {
        if self.count == self.steps.len() {
            self.steps.push((correction.to_vec(), 0.0));
        }
        let (step, square) = &mut self.steps[self.count];
        step.copy_from_slice(correction);
        *square = dot(correction, correction);
        self.count += 1;
    }

    /// Improves a correction by the old factors; `false` where new ones are needed.
    pub fn improve(&self, correction: &mut [f64]) -> bool {
        let steps = &self.steps[..self.count];
        let Some((last, square)) = steps.last() else { return true };
        for pair in steps.windows(2) {
            let [(step, square), (next, _)] = pair else { continue };
            let share = dot(step, correction) / square;
            correction.iter_mut().zip(next).for_each(|(c, next)| *c += share * next);
        }
        let rest = 1.0 - dot(last, correction) / square;
        correction.iter_mut().for_each(|c| *c /= rest);
        self.count < MOST && rest * LONGEST > 1.0
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `A x = b` of two unknowns with the identity in the place of A: Broyden's method ends after four steps at most
    /// (Gay 1979), the simplified iteration with a contraction of 0.5 not in thirty.
    #[test]
    fn linear_equations_are_solved_in_twice_as_many_steps_as_unknowns() {
        let (a, b) = ([[1.5, 0.2], [-0.1, 0.6]], [1.0, -2.0]);
        let (mut x, mut secants) = ([0.0, 0.0], Secants::default());
        for _ in 0..4 {
            let mut correction: Vec<f64> = (0..2).map(|i| a[i][0] * x[0] + a[i][1] * x[1] - b[i]).collect();
            assert!(secants.improve(&mut correction));
            secants.note(&correction);
            x.iter_mut().zip(&correction).for_each(|(x, c)| *x -= c);
        }
        for i in 0..2 {
            let residual = a[i][0] * x[0] + a[i][1] * x[1] - b[i];
            assert!(residual.abs() < 1e-12, "{residual:e}");
        }
    }
}
