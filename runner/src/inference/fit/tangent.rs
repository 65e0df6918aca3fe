//! A fit, linearised at its optimum, and its evidence.

use super::{End, Fit, ForceProblem, Setup};
use crate::fit::{EvaluationFailure, Prior, Problem, Solution, Whitening};
use crate::inference::effect::{Candidate, is_continuous};
use crate::inference::linearised::Linearised;
use crate::inference::magnitude::prior_weight;
use crate::noise::{Common, Covariance};
use nalgebra::{DMatrix, DVector};

/// A model, linearised.
pub struct Tangent {
    /// Measured minus model (mN).
    gap_mn: DVector<f64>,
    /// Derivatives of the force by parameters and magnitudes (mN).
    jacobian_mn: DMatrix<f64>,
    /// Of the measured force minus this model's.
    pub covariance: Covariance,
    /// What a refit of all variables would leave.
    pub linear: Linearised,
}

impl Tangent {
    /// At parameters and magnitudes `x`.
    ///
    /// # Errors
    /// When the model fails there, or the user asked to stop.
    pub fn at(
        setup: Setup,
        active: &[&Candidate],
        covariance: &Covariance,
        prior: &Prior,
        x: &[f64],
    ) -> Result<Self, EvaluationFailure> {
        let (difference_mn, jacobian_mn) = ForceProblem::new(setup, active).with_jacobian(x)?;
        let gap_mn = -DVector::from_vec(difference_mn);
        let covariance = covariance.at(&(DVector::from_vec(setup.measured_mn()) - &gap_mn));
        let linear = linearised(&jacobian_mn, &gap_mn, &covariance, prior, x);
        Ok(Self { gap_mn, jacobian_mn, covariance, linear })
    }
}

/// The whitened design with the prior's rows last, and what it leaves of the gap.
pub fn linearised(
    jacobian_mn: &DMatrix<f64>,
    gap_mn: &DVector<f64>,
    covariance: &Covariance,
    prior: &Prior,
    x: &[f64],
) -> Linearised {
    let (design, residual) = whitened(jacobian_mn, gap_mn, covariance, prior, x);
    Linearised::new(design, &residual)
}

/// The whitened design and residual, with the prior's rows last.
fn whitened(
    jacobian_mn: &DMatrix<f64>,
    gap_mn: &DVector<f64>,
    covariance: &Covariance,
    prior: &Prior,
    x: &[f64],
) -> (DMatrix<f64>, DVector<f64>) {
    let (data, n) = jacobian_mn.shape();
    let mut design = covariance.apply_columns(jacobian_mn).resize_vertically(data + n, 0.0);
    let mut residual = covariance.apply(gap_mn).resize_vertically(data + n, 0.0);
    for (j, (left, deviation)) in prior.residual(x).iter().zip(&prior.deviation).enumerate() {
        design[(data + j, j)] = 1.0 / deviation;
        residual[data + j] = -left;
    }
    (design, residual)
}

impl Fit {
    /// A solution with its linearisation; all of its runs are in the cache.
    pub(in crate::inference) fn at(
        setup: Setup,
        active: &[&Candidate],
        covariance: &Covariance,
        solution: Solution,
    ) -> Result<Self, EvaluationFailure> {
        let prior = ForceProblem::new(setup, active).prior();
        let Tangent { gap_mn, jacobian_mn, covariance, linear } =
            Tangent::at(setup, active, covariance, &prior, &solution.x)?;
        let parameters = setup.unknowns.len();
        Ok(Self { solution, linear, gap_mn, jacobian_mn, parameters, prior, covariance, end: End::Minimum })
    }

    /// chi^2 at the minimum of the linearised model.
    pub fn foreseen(&self) -> f64 {
        self.linear.residual.norm_squared()
    }

    /// What some of the points alone say around the same optimum.
    pub fn part(&self, points: &[usize]) -> Self {
        let (gap_mn, jacobian_mn) = (self.gap_mn.select_rows(points), self.jacobian_mn.select_rows(points));
        let covariance = self.covariance.part(points);
        let linear = linearised(&jacobian_mn, &gap_mn, &covariance, &self.prior, &self.solution.x);
        Self { linear, gap_mn, jacobian_mn, covariance, ..self.clone() }
    }

    /// The fit to some of the points alone, of the model linearised around this one; `None` where they do not determine it.
    pub fn refitted_to(&self, points: &[usize]) -> Option<Self> {
        let Self { mut solution, mut gap_mn, jacobian_mn, covariance, linear, .. } = self.part(points);
        let (design, residual) = whitened(&jacobian_mn, &gap_mn, &covariance, &self.prior, &solution.x);
        let step = design.tr_mul(&design).cholesky()?.solve(&design.tr_mul(&residual));
        gap_mn -= &jacobian_mn * &step;
        solution.x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x += step);
        solution.chi_square = linear.residual.norm_squared();
        Some(Self { solution, linear, gap_mn, jacobian_mn, covariance, ..self.clone() })
    }

    /// What it leaves beside more errors than it was made with, of the model linearised around it.
    #[must_use]
    pub fn beside(&self, errors: Vec<Common>) -> Self {
        let covariance = self.covariance.with(errors);
        let linear = linearised(&self.jacobian_mn, &self.gap_mn, &covariance, &self.prior, &self.solution.x);
        let solution = Solution { chi_square: linear.residual.norm_squared(), ..self.solution.clone() };
        Self { solution, linear, covariance, ..self.clone() }
    }

    /// The same optimum, of models with the effects `active`, seen with another covariance.
    ///
    /// # Errors
    /// When the model fails there, or the user asked to stop.
    pub fn seen_with(
        self,
        setup: Setup,
        active: &[&Candidate],
        covariance: &Covariance,
    ) -> Result<Self, EvaluationFailure> {
        let Tangent { gap_mn, jacobian_mn, covariance, linear } =
            Tangent::at(setup, active, covariance, &self.prior, &self.solution.x)?;
        Ok(Self { gap_mn, jacobian_mn, covariance, linear, ..self })
    }

    /// The material parameters (optimiser's variables).
    pub fn x(&self) -> &[f64] {
        &self.solution.x[..self.parameters]
    }

    /// Precision that an unknown has before the measurement, and its mean beside the optimum: variables and magnitudes, then the
    /// heights of the common errors.
    pub fn known_before(&self, j: usize) -> (f64, f64) {
        match self.solution.x.get(j) {
            Some(x) => (self.prior.deviation[j].powi(-2), self.prior.mean[j] - x),
            None => (1.0, 0.0),
        }
    }

    /// The magnitudes.
    pub fn magnitudes(&self) -> &[f64] {
        &self.solution.x[self.parameters..]
    }

    /// chi^2 without what the size of the magnitudes adds to it: how well the data are met.
    pub fn misfit(&self) -> f64 {
        let sizes = self.prior.residual(&self.solution.x);
        self.solution.chi_square - sizes.iter().skip(self.parameters).map(|size| size * size).sum::<f64>()
    }

    /// Standard deviations of the magnitudes.
    pub fn magnitude_deviations(&self) -> Vec<f64> {
        let square = self.linear.design.tr_mul(&self.linear.design);
        let Some(covariance) = square.try_inverse() else {
            return vec![f64::INFINITY; self.magnitudes().len()];
        };
        (self.parameters..self.solution.x.len()).map(|j| covariance[(j, j)].max(0.0).sqrt()).collect()
    }

    /// Twice the log evidence (Laplace), up to what all models of these data share.
    ///
    /// `-chi^2 - ln det Sigma - ln det(W'W) - sum ln(prior variance)` of the parameters, and for each magnitude what
    /// `inference::magnitude` says of it.
    pub fn evidence(&self, active: &[&Candidate]) -> f64 {
        let variances: f64 = self.prior.deviation[..self.parameters].iter().map(|s| 2.0 * s.ln()).sum();
        let free = active.iter().filter(|c| is_continuous(c));
        let sizes = free.zip(self.magnitudes()).zip(self.magnitude_deviations());
        let size = |((candidate, m), s): ((&&Candidate, &f64), f64)| {
            prior_weight(*m, s, candidate.is_one_sided()) - 2.0 * s.ln()
        };
        let sizes: f64 = sizes.map(size).sum();
        -self.misfit() - self.covariance.log_determinant() - self.linear.log_curvature() - variances + sizes
    }
}
