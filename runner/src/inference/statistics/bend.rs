//! How the valley of chi^2 bends.

use nalgebra::DVector;

/// A principal direction of the variables' covariance that the data hardly determine, and where the valley's floor lies along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Bend {
    /// One standard deviation along the direction, from the optimum.
    pub deviation: DVector<f64>,
    /// Points of the floor, from the optimum: how many deviations along the direction, and where.
    pub floor: Vec<(f64, DVector<f64>)>,
}

impl Bend {
    /// `c` of the floor `z d + c z^2 / 2`, `d` one deviation along the direction.
    pub fn curvature(&self) -> DVector<f64> {
        DVector::from_fn(self.deviation.len(), |i, _| {
            self.second_derivative(self.deviation[i], &|by| Some(by[i]))
        })
    }

    /// `h` of a quantity `g z + h z^2 / 2`, by least squares beside its slope `g` at the optimum, which is known; 0 of no points.
    fn second_derivative(&self, slope: f64, moved: &dyn Fn(&DVector<f64>) -> Option<f64>) -> f64 {
        let (mut product, mut square) = (0.0, 0.0);
        for (z, by) in &self.floor {
            let Some(change) = moved(by) else { continue };
            let weight = 0.5 * z * z;
            product += weight * (change - slope * z);
            square += weight * weight;
        }
        if square > 0.0 { product / square } else { 0.0 }
    }

    /// What it does to a quantity's mean, and adds to its variance, `moved(by)` being the change from the optimum: of `g z + h z^2 / 2`, z
    /// standard normal, the mean is `h / 2` and the variance `g^2 + h^2 / 2`.
    pub(super) fn moments(
        &self,
        gradient: &DVector<f64>,
        moved: &dyn Fn(&DVector<f64>) -> Option<f64>,
    ) -> (f64, f64) {
        let curvature = self.second_derivative(gradient.dot(&self.deviation), moved);
        (0.5 * curvature, 0.5 * curvature * curvature)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = 2 x + 3 x^2 / 2 along a direction of one half: with z = x / 0.5 the mean is 3 / 8 and the variance (3 / 4)^2 / 2 more.
    #[test]
    fn a_parabola_has_its_moments() {
        let deviation = DVector::from_vec(vec![0.5, 0.0]);
        let at = |x: f64| (x / 0.5, DVector::from_vec(vec![x, 2.0 * x + 1.5 * x * x]));
        let bend = Bend { deviation, floor: vec![at(0.4), at(-0.3)] };
        let (mean, variance) = bend.moments(&DVector::from_vec(vec![2.0, 0.0]), &|by| Some(by[1]));
        assert!((mean - 0.375).abs() < 1e-12 && (variance - 0.28125).abs() < 1e-12, "{mean} {variance}");
    }
}
