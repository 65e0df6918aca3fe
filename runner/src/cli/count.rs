//! Counts on the command line: whole numbers with a range, also written `1e5`.

/// Output times: more would fill the memory before anything is computed.
pub fn points(text: &str) -> Result<usize, String> {
    between(text, 2, 1_000_000)
}

/// Starts of a fit.
pub fn starts(text: &str) -> Result<usize, String> {
    between(text, 1, 10_000)
}

/// Evaluations of a fit.
pub fn evaluations(text: &str) -> Result<usize, String> {
    between(text, 1, 1_000_000)
}

/// Specimens behind a spread.
pub fn specimens(text: &str) -> Result<usize, String> {
    between(text, 2, 1_000_000)
}

/// Instances at a time; 0 is one per core.
pub fn jobs(text: &str) -> Result<usize, String> {
    let cores = std::thread::available_parallelism().map_or(1, Into::into);
    between(text, 0, 64.max(4 * cores))
}

fn between(text: &str, least: usize, most: usize) -> Result<usize, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("`{text}` is not a whole number"))?;
    if value.fract() != 0.0 || !value.is_finite() {
        return Err(format!("`{text}` is not a whole number"));
    }
    if (least as f64..=most as f64).contains(&value) {
        return Ok(value as usize);
    }
    Err(format!("must be between {least} and {most}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_ranges() {
        assert_eq!(points("1e5"), Ok(100_000));
        assert_eq!(starts("8"), Ok(8));
        assert_eq!(jobs("0"), Ok(0));
        for (result, part) in [
            (points("1e9"), "between 2 and 1000000"),
            (points("1.5"), "not a whole number"),
            (points("-3"), "between"),
            (points("NaN"), "not a whole number"),
            (starts("0"), "between 1 and"),
            (jobs("100000"), "between 0 and"),
            (evaluations("many"), "not a whole number"),
        ] {
            let error = result.unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
