//! Numbers of units as people and engines write them: `1-20,35,40-50`.

/// Numbers in rising order, runs joined by a hyphen.
pub fn written(numbers: &[usize]) -> String {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for &n in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == n => *last = n,
            _ => runs.push((n, n)),
        }
    }
    let one = |(a, b): &(usize, usize)| if a == b { a.to_string() } else { format!("{a}-{b}") };
    runs.iter().map(one).collect::<Vec<_>>().join(",")
}

/// Reads them again.
///
/// # Errors
/// When a part is no number and no rising run.
pub fn read(text: &str) -> Result<Vec<usize>, String> {
    let bad = |part: &str| format!("`{part}` is no unit; write numbers from 1, as in 3 or 1-20,35");
    let mut numbers = Vec::new();
    for part in text.split(',').map(str::trim) {
        let (a, b) = part.split_once('-').unwrap_or((part, part));
        let number = |t: &str| t.trim().parse::<usize>().ok().filter(|n| *n > 0);
        let (a, b) = number(a).zip(number(b)).filter(|(a, b)| a <= b).ok_or_else(|| bad(part))?;
        numbers.extend(a..=b);
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_joined_and_read_again() {
        let numbers = [1, 2, 3, 7, 9, 10];
        assert_eq!(written(&numbers), "1-3,7,9-10");
        assert_eq!(read("1-3,7, 9-10").unwrap(), numbers);
        assert!(written(&[]).is_empty());
        for bad in ["", "0", "5-3", "a", "1,,2", "-1"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
