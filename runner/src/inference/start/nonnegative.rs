//! Non-negative least squares of a few columns, from their normal equations.

/// Weights `x >= 0` of the columns `chosen` that minimise `x A x / 2 - b x`, and twice that minimum.
///
/// The best feasible solution of a subset of the columns: where the unconstrained one has a negative weight, each
/// column in turn is left out. Meant for up to six columns.
pub fn minimise(a: &[Vec<f64>], b: &[f64], chosen: &[usize]) -> (Vec<f64>, f64) {
    if chosen.is_empty() {
        return (Vec::new(), 0.0);
    }
    if let Some(x) = solve(a, b, chosen)
        && x.iter().all(|x| *x >= 0.0)
    {
        let value = -x.iter().zip(chosen).map(|(x, &j)| x * b[j]).sum::<f64>();
        return (x, value);
    }
    let without = |k: usize| {
        let rest: Vec<usize> = chosen.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, j)| *j).collect();
        let (mut x, value) = minimise(a, b, &rest);
        x.insert(k, 0.0);
        (x, value)
    };
    let all = (0..chosen.len()).map(without);
    all.min_by(|x, y| x.1.total_cmp(&y.1)).unwrap_or_default()
}

/// The unconstrained weights by Cholesky's factors; none where columns are alike to rounding.
fn solve(a: &[Vec<f64>], b: &[f64], chosen: &[usize]) -> Option<Vec<f64>> {
    let n = chosen.len();
    let mut l = vec![vec![0.0; n]; n];
    let mut x = vec![0.0; n];
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = a[chosen[i]][chosen[j]] - dot;
            if i == j {
                if rest <= 1e-12 * a[chosen[i]][chosen[i]] {
                    return None;
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
        let dot: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (b[chosen[i]] - dot) / l[i][i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - dot) / l[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_best_that_are_not_negative() {
        // The unconstrained minimum is (2, -1); with x_2 = 0 it is 3 / 2.
        let (a, b) = (vec![vec![2.0, 1.0], vec![1.0, 2.0]], vec![3.0, 0.0]);
        let (x, value) = minimise(&a, &b, &[0, 1]);
        assert!((x[0] - 1.5).abs() < 1e-12 && x[1] == 0.0 && (value + 4.5).abs() < 1e-12, "{x:?} {value}");
        let (x, _) = minimise(&a, &[3.0, 3.0], &[0, 1]);
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-12));
        assert_eq!(minimise(&a, &[-1.0, -1.0], &[0, 1]), (vec![0.0, 0.0], 0.0));
    }
}
