//! A Prony series with non-negative weights: the few relaxation times that the evidence asks for.

use super::nonnegative::minimise;

/// Relaxation times per decade of the grid on which they are sought: half a step changes no force by half a per cent.
const PER_DECADE: usize = 100;

/// A linear problem `force = G_inf elastic + sum G_i relaxed(tau_i)`, every row divided by its deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    grid_s: Vec<f64>,
    /// Normal equations: the elastic column first, then those of the grid.
    gram: Vec<Vec<f64>>,
    product: Vec<f64>,
    square: f64,
    rows: usize,
}

/// A fitted series.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Long-term shear modulus (Pa).
    pub equilibrium_pa: f64,
    /// Relaxation times (s), ascending, with their shear moduli (Pa).
    pub branches: Vec<(f64, f64)>,
    /// Sum of the squared weighted residuals.
    pub chi_square: f64,
}

/// Relaxation times (s) from `shortest` to `longest`, evenly in the logarithm.
pub fn grid(shortest_s: f64, longest_s: f64) -> Vec<f64> {
    let decades = (longest_s / shortest_s).log10().max(0.0);
    let steps = (decades * PER_DECADE as f64).ceil().max(1.0);
    (0..=steps as usize).map(|k| shortest_s * 10f64.powf(decades * k as f64 / steps)).collect()
}

impl Problem {
    /// The problem of weighted forces, with the weighted columns of the equilibrium and of each relaxation time.
    pub fn new(grid_s: Vec<f64>, columns: &[Vec<f64>], force: &[f64]) -> Self {
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        let gram = columns.iter().map(|x| columns.iter().map(|y| dot(x, y)).collect()).collect();
        let product = columns.iter().map(|x| dot(x, force)).collect();
        Self { grid_s, gram, product, square: dot(force, force), rows: force.len() }
    }

    /// The series with one to `most` branches that the evidence prefers, but not fewer than `least`.
    ///
    /// The evidence is Schwarz's: chi^2 (per degree of freedom where it says that the deviations were too small) and two parameters per branch.
    pub fn best(&self, least: usize, most: usize) -> Series {
        let least = least.max(1);
        let mut places = Vec::new();
        let mut best: Option<(f64, Series)> = None;
        for n in 1..=most.max(least) {
            self.add(&mut places);
            let series = self.series(&places);
            let criterion = self.misfit(series.chi_square) + 2.0 * n as f64 * (self.rows as f64).ln();
            if n == least || (n > least && best.as_ref().is_none_or(|b| criterion < b.0)) {
                best = Some((criterion, series));
            }
        }
        best.map(|b| b.1).unwrap_or_default()
    }

    /// Minus twice the logarithm of the likelihood: of known deviations, or of deviations that are too small by a factor.
    fn misfit(&self, chi_square: f64) -> f64 {
        let n = self.rows as f64;
        if chi_square <= n { chi_square } else { n + n * (chi_square / n).ln() }
    }

    /// Adds the best further relaxation time, then moves each in turn until none can be bettered.
    fn add(&self, places: &mut Vec<usize>) {
        places.push(0);
        let mut order: Vec<usize> = (0..places.len()).rev().collect();
        let mut value = f64::INFINITY;
        loop {
            let before = value;
            for &k in &order {
                let at = |place: usize| {
                    let mut trial = places.clone();
                    trial[k] = place;
                    (self.value(&trial), place)
                };
                let others: Vec<usize> =
                    places.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, p)| *p).collect();
                let free = (0..self.grid_s.len()).filter(|p| !others.contains(p));
                if let Some(found) = free.map(at).min_by(|x, y| x.0.total_cmp(&y.0))
                    && found.0 < value
                {
                    (value, places[k]) = found;
                }
            }
            // Rounding must not keep it going.
            if before - value <= 1e-9 * self.square {
                break;
            }
            order.rotate_left(1);
        }
    }

    fn columns(places: &[usize]) -> Vec<usize> {
        std::iter::once(0).chain(places.iter().map(|p| p + 1)).collect()
    }

    fn value(&self, places: &[usize]) -> f64 {
        minimise(&self.gram, &self.product, &Self::columns(places)).1
    }

    fn series(&self, places: &[usize]) -> Series {
        let (weights, value) = minimise(&self.gram, &self.product, &Self::columns(places));
        let mut branches: Vec<(f64, f64)> =
            places.iter().zip(&weights[1..]).map(|(p, w)| (self.grid_s[*p], *w)).collect();
        branches.sort_by(|x, y| x.0.total_cmp(&y.0));
        Series { equilibrium_pa: weights[0], branches, chi_square: (self.square + value).max(0.0) }
    }
}
