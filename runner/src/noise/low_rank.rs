//! A covariance that is a diagonal and few common errors, and what makes it white.
//!
//! `Sigma = S (1 + V V') S` with `S` the white deviations and `V = S^-1 U` the common errors in units of them. With
//! the thin decomposition `V = Q diag(s) Z'` the symmetric inverse root is
//! `L^-1 = (1 + Q diag(1 / sqrt(1 + s^2) - 1) Q') S^-1`: cost linear in the number of points.

use crate::fit::products::products;
use crate::fit::{SharedNoise, Whitening};
use nalgebra::{DMatrix, DVector};

/// An error that many points share: its value at each point when it is one standard deviation large (mN).
#[derive(Debug, Clone, PartialEq)]
pub struct Common {
    /// What it is.
    pub name: String,
    /// Shape (mN).
    pub shape_mn: DVector<f64>,
    /// Whether it is a part of the computed force at each point.
    pub relative: bool,
    /// Degrees of freedom that its size was estimated with; infinite where it is known.
    pub degrees: f64,
    /// What it was estimated together with.
    pub group: Option<Group>,
    /// Whether it is an error of the model, and no part of what was measured beside the force.
    pub of_model: bool,
}

/// Errors that are larger or smaller together: their variances are as uncertain as one of these degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Group {
    /// What they are.
    pub of: Estimated,
    /// Degrees of freedom.
    pub degrees: f64,
}

/// What specimens tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Estimated {
    /// Heights of all tests, by the scatter of their specimens.
    Heights,
    /// Shapes of the test that begins with this point, by the mean of what their variances may be: the degrees are more than two.
    Shapes {
        /// Among the points of all tests.
        first_point: usize,
    },
}

/// Errors of one unknown size.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainSize {
    /// Places among the common errors.
    pub places: Vec<usize>,
    /// Degrees of freedom.
    pub degrees: f64,
    /// The variance is what is known times this number over a variate of chi^2 of these degrees.
    pub scale: f64,
}

impl Common {
    /// An error of known size that is no part of the force.
    pub fn additive(name: String, shape_mn: DVector<f64>) -> Self {
        Self { name, shape_mn, relative: false, degrees: f64::INFINITY, group: None, of_model: false }
    }

    /// An error of known size in proportion to the force.
    pub fn proportional(name: String, shape_mn: DVector<f64>) -> Self {
        Self { relative: true, ..Self::additive(name, shape_mn) }
    }

    /// The same as an error of the model.
    #[must_use]
    pub fn of_the_model(self) -> Self {
        Self { of_model: true, ..self }
    }
}

/// Covariance of the measured force minus the model's (mN^2).
#[derive(Debug, Clone)]
pub struct Covariance {
    white_mn: DVector<f64>,
    common: Vec<Common>,
    /// Errors that a fit takes up: of its values, not of the comparison.
    absorbed: Vec<Common>,
    /// The computed force that relative errors are given for (mN); empty where none is.
    reference_mn: DVector<f64>,
    q: DMatrix<f64>,
    /// `1 / sqrt(1 + s^2) - 1`.
    change: DVector<f64>,
    log_determinant: f64,
    /// Whether its size is known; otherwise it is what the fit leaves.
    known: bool,
}

/// Squared singular values below this part of the largest are rounding.
const ROUNDING: f64 = 1e-13;
/// Factor on the white deviation of a point at which nothing is known.
const UNKNOWN: f64 = 1e6;
/// Force below which there is none, over the largest.
const NO_FORCE: f64 = 1e-3;

impl Covariance {
    /// From the white deviation of each point (mN), positive, and the common errors.
    pub fn new(white_mn: DVector<f64>, common: Vec<Common>) -> Self {
        let n = white_mn.len();
        let log_white = 2.0 * white_mn.iter().map(|s| s.ln()).sum::<f64>();
        let reference_mn = DVector::zeros(0);
        if common.is_empty() {
            let (q, change) = (DMatrix::zeros(n, 0), DVector::zeros(0));
            let log_determinant = log_white;
            return Self {
                white_mn,
                common,
                absorbed: vec![],
                reference_mn,
                q,
                change,
                log_determinant,
                known: true,
            };
        }
        let columns: Vec<DVector<f64>> = common.iter().map(|c| c.shape_mn.component_div(&white_mn)).collect();
        let v = DMatrix::from_columns(&columns);
        let eigen = products(&v, |_, _| None).symmetric_eigen();
        let least = ROUNDING * eigen.eigenvalues.amax();
        let kept: Vec<usize> =
            (0..eigen.eigenvalues.len()).filter(|&k| eigen.eigenvalues[k] > least).collect();
        let squares = eigen.eigenvalues.select_rows(&kept);
        let mut q = &v * eigen.eigenvectors.select_columns(&kept);
        q.column_iter_mut().zip(squares.iter()).for_each(|(mut c, s2)| c /= s2.sqrt());
        let change = squares.map(|s2| 1.0 / (1.0 + s2).sqrt() - 1.0);
        let more: f64 = squares.map(f64::ln_1p).sum();
        let log_determinant = log_white + more;
        Self { white_mn, common, absorbed: vec![], reference_mn, q, change, log_determinant, known: true }
    }

    /// Independent errors of which only the ratios are known (mN).
    pub fn of_unknown_size(white_mn: DVector<f64>) -> Self {
        Self { known: false, ..Self::new(white_mn, vec![]) }
    }

    /// Whether its size is known.
    pub fn is_known(&self) -> bool {
        self.known
    }

    /// The same with these white deviations and computed force, and each common error changed.
    fn rebuilt(
        &self,
        white_mn: DVector<f64>,
        change: impl Fn(&Common) -> Common,
        reference_mn: DVector<f64>,
    ) -> Self {
        let common = self.common.iter().map(&change).filter(|c| c.shape_mn.amax() > 0.0).collect();
        let absorbed = self.absorbed.iter().map(&change).collect();
        Self { known: self.known, reference_mn, absorbed, ..Self::new(white_mn, common) }
    }

    /// The same for a fit that takes up these errors.
    #[must_use]
    pub fn absorbing(self, absorbed: Vec<Common>) -> Self {
        Self { absorbed, ..self }
    }

    /// Errors that a fit takes up: of its values, not of the comparison.
    pub fn absorbed(&self) -> &[Common] {
        &self.absorbed
    }

    /// All errors this many times as large, and the white ones `white` times more.
    #[must_use]
    pub fn scaled(&self, all: f64, white: f64) -> Self {
        let larger = |c: &Common| Common { shape_mn: &c.shape_mn * all, ..c.clone() };
        self.rebuilt(&self.white_mn * (all * white), larger, self.reference_mn.clone())
    }

    /// The same with the white deviation of each point times its own factor.
    #[must_use]
    pub fn with_white_times(&self, factors: &[f64]) -> Self {
        let white_mn = self.white_mn.component_mul(&DVector::from_row_slice(factors));
        self.rebuilt(white_mn, Common::clone, self.reference_mn.clone())
    }

    /// Of some of the points.
    #[must_use]
    pub fn part(&self, points: &[usize]) -> Self {
        let of = |v: &DVector<f64>| if v.is_empty() { v.clone() } else { v.select_rows(points) };
        let cut = |c: &Common| Common { shape_mn: of(&c.shape_mn), ..c.clone() };
        self.rebuilt(of(&self.white_mn), cut, of(&self.reference_mn))
    }

    /// The same, whose relative errors are those at this computed force (mN).
    #[must_use]
    pub fn relative_to(mut self, force_mn: DVector<f64>) -> Self {
        self.reference_mn = force_mn;
        self
    }

    /// Of a model that computes this force (mN): relative errors are as much larger at each point as it is.
    #[must_use]
    pub fn at(&self, force_mn: &DVector<f64>) -> Self {
        let moved = |c: &Common| match self.part_of_force(c) {
            Some(part) => Common { shape_mn: part.component_mul(force_mn), ..c.clone() },
            None => c.clone(),
        };
        self.rebuilt(self.white_mn.clone(), moved, force_mn.clone())
    }

    /// The same with further errors that are no part of the computed force.
    #[must_use]
    pub fn with(&self, more: impl IntoIterator<Item = Common>) -> Self {
        let common = self.common.iter().cloned().chain(more).collect();
        let (known, absorbed) = (self.known, self.absorbed.clone());
        let reference_mn = self.reference_mn.clone();
        Self { known, absorbed, reference_mn, ..Self::new(self.white_mn.clone(), common) }
    }

    /// The same for one who does not know what was measured at `points`.
    #[must_use]
    pub fn without(&self, points: &[usize]) -> Self {
        let mut white_mn = self.white_mn.clone();
        points.iter().for_each(|&i| white_mn[i] *= UNKNOWN);
        self.rebuilt(white_mn, Common::clone, self.reference_mn.clone())
    }

    /// Force next to which there is none (mN).
    fn no_force_mn(&self) -> f64 {
        NO_FORCE * self.reference_mn.amax()
    }

    /// Whether an error grows with what is computed.
    fn is_part_of_force(&self, common: &Common) -> bool {
        common.relative && self.no_force_mn() > 0.0
    }

    /// A relative error over the force; next to no force there is next to no error.
    fn part_of_force(&self, common: &Common) -> Option<DVector<f64>> {
        let least = self.no_force_mn();
        let over = |shape: f64, f: f64| shape * f / (f * f + least * least);
        self.is_part_of_force(common).then(|| common.shape_mn.zip_map(&self.reference_mn, over))
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.white_mn.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.white_mn.is_empty()
    }

    /// White deviation of each point (mN).
    pub fn white_mn(&self) -> &DVector<f64> {
        &self.white_mn
    }

    /// The errors that points share.
    pub fn common(&self) -> &[Common] {
        &self.common
    }

    /// The common errors whose sizes were estimated together.
    pub fn uncertain_sizes(&self) -> Vec<UncertainSize> {
        let mut sizes: Vec<(Group, Vec<usize>)> = Vec::new();
        for (k, group) in self.common.iter().enumerate().filter_map(|(k, c)| Some((k, c.group?))) {
            match sizes.iter_mut().find(|(known, _)| *known == group) {
                Some((_, places)) => places.push(k),
                None => sizes.push((group, vec![k])),
            }
        }
        let one = |(Group { of, degrees }, places)| {
            let scale = if of == Estimated::Heights { degrees } else { degrees - 2.0 };
            UncertainSize { places, degrees, scale }
        };
        sizes.into_iter().map(one).collect()
    }

    /// Shapes of the common errors (mN), one column each.
    pub fn common_columns(&self) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.len(), self.common.len());
        for (mut column, common) in columns.column_iter_mut().zip(&self.common) {
            column.copy_from(&common.shape_mn);
        }
        columns
    }

    /// ln det Sigma.
    pub fn log_determinant(&self) -> f64 {
        self.log_determinant
    }

    /// Standard deviation of each point, white and common (mN).
    pub fn total_mn(&self) -> DVector<f64> {
        let at = |i: usize| {
            let common: f64 = self.common.iter().map(|c| c.shape_mn[i].powi(2)).sum();
            (self.white_mn[i].powi(2) + common).sqrt()
        };
        DVector::from_fn(self.len(), |i, _| at(i))
    }
}

impl SharedNoise for Covariance {
    fn white(&self) -> &DVector<f64> {
        &self.white_mn
    }

    fn shared(&self, computed: &DVector<f64>) -> DMatrix<f64> {
        let mut columns = self.common_columns();
        for (mut column, common) in columns.column_iter_mut().zip(&self.common) {
            if let Some(part) = self.part_of_force(common) {
                column.copy_from(&part.component_mul(computed));
            }
        }
        columns
    }

    fn grows(&self) -> Vec<bool> {
        self.common.iter().map(|c| self.is_part_of_force(c)).collect()
    }

    fn growth(&self, heights: &DVector<f64>) -> DVector<f64> {
        let mut sum = DVector::zeros(self.len());
        for (common, height) in self.common.iter().zip(heights.iter()) {
            if let Some(part) = self.part_of_force(common) {
                sum.axpy(*height, &part, 1.0);
            }
        }
        sum
    }
}

impl Whitening for Covariance {
    fn apply(&self, values: &DVector<f64>) -> DVector<f64> {
        let scaled = values.component_div(&self.white_mn);
        let inside = self.q.tr_mul(&scaled).component_mul(&self.change);
        scaled + &self.q * inside
    }

    fn white_part(&self, values: &DVector<f64>) -> DVector<f64> {
        // S (L^-1)' with L^-1 = (1 + Q c Q') S^-1.
        values + &self.q * self.q.tr_mul(values).component_mul(&self.change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_turns_the_covariance_into_the_unit_matrix() {
        let white = DVector::from_vec(vec![0.5, 1.0, 2.0, 0.7]);
        let shape = |v: [f64; 4]| Common::additive("c".into(), DVector::from_row_slice(&v));
        // The third is a multiple of the first: the shapes need not be independent.
        let common =
            vec![shape([1.0, 2.0, 3.0, 4.0]), shape([0.0, 1.0, -1.0, 0.5]), shape([2.0, 4.0, 6.0, 8.0])];
        let covariance = Covariance::new(white.clone(), common);
        let u = covariance.common_columns();
        let sigma = DMatrix::from_diagonal(&white.map(|s| s * s)) + &u * u.transpose();
        let half = covariance.apply_columns(&sigma).transpose();
        let unit = covariance.apply_columns(&half);
        assert!((unit - DMatrix::identity(4, 4)).amax() < 1e-10);
        assert!((covariance.log_determinant() - sigma.determinant().ln()).abs() < 1e-9);
        assert!((covariance.total_mn()[2] - sigma[(2, 2)].sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_point_that_is_not_known_counts_for_nothing() {
        let shape = DVector::from_vec(vec![1.0, 2.0, 3.0]);
        let common = Common::proportional("c".into(), shape);
        let reference = DVector::from_vec(vec![2.0, 4.0, 6.0]);
        let all =
            Covariance::new(DVector::from_vec(vec![0.5, 0.7, 2.0]), vec![common]).relative_to(reference);
        let whitened = |third: f64| all.without(&[2]).apply(&DVector::from_vec(vec![1.0, 1.0, third]));
        let square = whitened(0.0).norm_squared();
        assert!((square - whitened(5.0).norm_squared()).abs() < 1e-6 * square);
        let known = all.without(&[]).apply(&DVector::from_vec(vec![1.0, 1.0, 0.0])).norm_squared();
        assert!((square - known).abs() > 1e-3 * square);
        // Errors in proportion to the force go on growing with it, but for what `NO_FORCE` takes of them.
        let twice = all.without(&[2]).at(&DVector::from_vec(vec![4.0, 8.0, 12.0]));
        assert!((twice.common()[0].shape_mn[1] - 4.0).abs() < 1e-5 * 4.0);
    }

    #[test]
    fn without_common_errors_points_are_divided_by_their_deviation() {
        let covariance = Covariance::new(DVector::from_vec(vec![0.5, 2.0]), vec![]);
        assert_eq!(covariance.apply(&DVector::from_vec(vec![1.0, 1.0])).as_slice(), [2.0, 0.5]);
    }
}
