//! Geometric grading of one direction.

/// Distances of the layer boundaries from the graded end, ascending, the last one exactly `length`.
///
/// Layers start with `first` and grow by the factor `growth`.
pub fn layers(length: f64, first: f64, growth: f64) -> Vec<f64> {
    let mut sizes = Vec::new();
    let (mut size, mut sum) = (first.min(length), 0.0);
    while sum < length * (1.0 - 1e-9) {
        sizes.push(size);
        sum += size;
        size *= growth;
    }
    // The count whose total is nearest to the length.
    if sizes.len() > 1 && sum - length > 0.5 * sizes[sizes.len() - 1] {
        sum -= sizes.pop().unwrap_or(0.0);
    }
    // The excess is taken out of the large layers, so that the first sizes stay as asked.
    let excess = sum - length;
    let weight: f64 = sizes.iter().map(|s| s * s).sum();
    let mut distance = 0.0;
    let mut distances: Vec<f64> = sizes
        .iter()
        .map(|s| {
            distance += s - excess * s * s / weight;
            distance
        })
        .collect();
    if let Some(last) = distances.last_mut() {
        *last = length;
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_first_size_and_ends_exactly() {
        let d = layers(10.0, 0.01, 2.0);
        assert!((d[0] - 0.01).abs() < 1e-4 && *d.last().unwrap() == 10.0);
        let mut sizes = vec![d[0]];
        sizes.extend(d.windows(2).map(|w| w[1] - w[0]));
        assert!(sizes.windows(2).all(|w| w[1] > 0.4 * w[0] && w[1] < 3.0 * w[0]), "{sizes:?}");
    }

    #[test]
    fn a_first_size_beyond_the_length_gives_one_layer() {
        assert_eq!(layers(1.0, 5.0, 2.0), vec![1.0]);
    }
}
