//! Pareto-smoothed importance weights (Vehtari, Simpson, Gelman, Yao and Gabry, J. Mach. Learn. Res. 25, 2024).

/// Fewest weights of a tail that a distribution is fitted to.
const FEWEST: usize = 5;

/// Weights (sum 1) from their logarithms, the largest replaced by the quantiles of the Pareto distribution that fits them, and its
/// shape k: the weights have a finite variance below 1/2, and their mean can be trusted up to 0.7. Infinite where too few points
/// have a weight.
pub fn smoothed(logarithms: &[f64]) -> (Vec<f64>, f64) {
    let n = logarithms.len();
    let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut weights: Vec<f64> = logarithms.iter().map(|l| (l - largest).exp()).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| weights[*a].total_cmp(&weights[*b]));
    let tail = (0.2 * n as f64).min(3.0 * (n as f64).sqrt()).ceil() as usize;
    let mut k = f64::INFINITY;
    if largest.is_finite() && tail >= FEWEST && tail < n {
        let cut = weights[order[n - tail - 1]];
        let excess: Vec<f64> = order[n - tail..].iter().map(|i| weights[*i] - cut).collect();
        if cut > 0.0 && excess[0] >= 0.0 && excess[tail - 1] > 0.0 {
            let (shape, scale) = generalised_pareto(&excess);
            k = shape;
            let quantile = |p: f64| {
                let q =
                    if shape.abs() < 1e-9 { -(1.0 - p).ln() } else { ((1.0 - p).powf(-shape) - 1.0) / shape };
                (cut + scale * q).min(1.0)
            };
            for (rank, i) in order[n - tail..].iter().enumerate() {
                weights[*i] = quantile((rank as f64 + 0.5) / tail as f64);
            }
        } else if cut > 0.0 {
            // All weights of the tail are alike.
            k = f64::NEG_INFINITY;
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    (weights, k)
}

/// Shape and scale of the generalised Pareto distribution of ascending values from 0 on (Zhang and Stephens, Technometrics 51, 2009),
/// the shape drawn towards 1/2 as by ten further values.
fn generalised_pareto(x: &[f64]) -> (f64, f64) {
    const PRIOR: f64 = 10.0;
    let n = x.len() as f64;
    let (largest, quartile) = (x[x.len() - 1], x[((n / 4.0 + 0.5).floor() as usize).max(1) - 1]);
    let quartile = quartile.max(1e-12 * largest);
    let points = 30 + n.sqrt().floor() as usize;
    let shape = |theta: f64| x.iter().map(|x| (-theta * x).ln_1p()).sum::<f64>() / n;
    let theta =
        |j: usize| (1.0 / largest) + (1.0 - (points as f64 / (j as f64 - 0.5)).sqrt()) / (3.0 * quartile);
    let thetas: Vec<f64> = (1..=points).map(theta).filter(|t| *t < 1.0 / largest && *t != 0.0).collect();
    let likelihood = |t: &f64| {
        let k = shape(*t);
        n * ((-t / k).ln() - k - 1.0)
    };
    let logarithms: Vec<f64> = thetas.iter().map(likelihood).collect();
    let best = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weight = |l: &f64| if l.is_finite() { (l - best).exp() } else { 0.0 };
    let weights: Vec<f64> = logarithms.iter().map(weight).collect();
    let total: f64 = weights.iter().sum();
    let mean = thetas.iter().zip(&weights).map(|(t, w)| t * w).sum::<f64>() / total;
    let k = shape(mean);
    let scale = -k / mean;
    ((k * n + 0.5 * PRIOR) / (n + PRIOR), scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of a Pareto distribution of shape `k`.
    fn quantiles(k: f64, n: usize) -> Vec<f64> {
        let p = |i: usize| (i as f64 + 0.5) / n as f64;
        (0..n).map(|i| ((1.0 - p(i)).powf(-k) - 1.0) / k).collect()
    }

    #[test]
    fn the_shape_of_a_tail_is_recovered() {
        for k in [0.2, 0.5, 0.9, 1.5] {
            let (found, scale) = generalised_pareto(&quantiles(k, 400));
            assert!((found - k).abs() < 0.12 && (scale - 1.0).abs() < 0.15, "{k}: {found} {scale}");
        }
    }

    #[test]
    fn heavy_weights_are_told_from_light_ones() {
        let logarithms = |k: f64| quantiles(k, 2000).iter().map(|w| (1.0 + w).ln()).collect::<Vec<f64>>();
        assert!(smoothed(&logarithms(0.3)).1 < 0.6);
        assert!(smoothed(&logarithms(1.2)).1 > 0.9);
        let (weights, k) = smoothed(&[0.5; 100]);
        assert!(k < 0.0 && weights.iter().all(|w| (w - 0.01).abs() < 1e-12));
        assert_eq!(smoothed(&[f64::NEG_INFINITY, f64::NEG_INFINITY, 0.0]).1, f64::INFINITY);
    }
}
