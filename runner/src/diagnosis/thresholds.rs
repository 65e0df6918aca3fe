//! The constants that decide an answer, each with its reason. What halving and doubling each of them changes stands in this folder's
//! README (`tests/thresholds/study.py`).

use thiserror::Error;

/// A change of a constant that cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("--threshold {text}: write NAME=VALUE with a positive value and one of these names: {names}")]
pub struct ThresholdError {
    text: String,
    names: String,
}

/// All of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thresholds {
    /// Family-wise probability under noise below which there is a gap: one null in twenty may pass this gate, and meets the plain
    /// model's prior odds behind it.
    pub significant: f64,
    /// A chi^2 that noise exceeds more seldom is a gap, wherever it is: no noise that we know so badly is so far off.
    pub flagrant: f64,
    /// Probability under noise below which a refit does not meet the data: five times stricter than the gate, since of all refits the
    /// best is looked at.
    pub inadequate: f64,
    /// Twice the log evidence, or chi^2, by which a model must lead for the others to be left out of the answer: odds of twenty.
    pub decisive: f64,
    /// Prior odds of a pair, and of something outside the catalogue, against a single effect, as twice their logarithm: one in seven.
    pub complexity: f64,
    /// Twice the log evidence that a second effect must promise in the rest of the best single one to be tried: odds of fifty, as some twenty
    /// effects stand for it.
    pub second: f64,
    /// Nature's law of the first effect may deviate from the catalogue's by this part of it; what a second one does must be more than
    /// that explains. A lag of two stages deviates from one of one by as much.
    pub form: f64,
    /// A rest of the gap below this part, in units of the noise, is a matter of the effect's form: another program's forms of the catalogue's
    /// effects left up to 0.55 (`data/practice/slow-branch`); wrong answers 0.58 or more (a clock that drifts, called offset with compliance; a pair
    /// called another one). A pair, or what is a number, may leave less (`confirming.rs`).
    pub rest: f64,
    /// A magnitude of which more than this part of the prior's variance is left was not learned from what was fitted.
    pub learned: f64,
    /// An effect that explains less than this part of what matters is a finding only where data that were not fitted confirm it: where it
    /// would be chosen without them, and surely takes `1 - rest` of their gap. A null of an independent solver shows effects of 0.6; of five cases with 0.6 to 0.75 none had a
    /// gap that matters for somebody who knows it.
    pub immaterial: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self {
            significant: 0.05,
            flagrant: 1e-4,
            inadequate: 0.01,
            decisive: 6.0,
            complexity: 4.0,
            second: 8.0,
            form: 0.3,
            rest: 0.56,
            learned: 0.5,
            immaterial: 0.75,
        }
    }
}

impl Thresholds {
    /// Sets some of them, each written `NAME=VALUE`.
    ///
    /// # Errors
    /// When it is written otherwise, no constant has the name, or the value is not positive.
    pub fn with(mut self, changes: &[String]) -> Result<Self, ThresholdError> {
        for text in changes {
            let refused = || ThresholdError {
                text: text.clone(),
                names: Self::default().named().map(|(n, _)| n).join(", "),
            };
            let (name, value) = text.split_once('=').ok_or_else(refused)?;
            let value: f64 =
                value.trim().parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite()).ok_or_else(refused)?;
            let (_, constant) =
                self.named().into_iter().find(|(n, _)| *n == name.trim()).ok_or_else(refused)?;
            *constant = value;
        }
        Ok(self)
    }

    fn named(&mut self) -> [(&'static str, &mut f64); 10] {
        [
            ("significant", &mut self.significant),
            ("flagrant", &mut self.flagrant),
            ("inadequate", &mut self.inadequate),
            ("decisive", &mut self.decisive),
            ("complexity", &mut self.complexity),
            ("second", &mut self.second),
            ("form", &mut self.form),
            ("rest", &mut self.rest),
            ("learned", &mut self.learned),
            ("immaterial", &mut self.immaterial),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_changed_by_their_names() {
        let changed =
            Thresholds::default().with(&["decisive=12".to_owned(), "form = 0.6".to_owned()]).unwrap();
        assert_eq!(changed, Thresholds { decisive: 12.0, form: 0.6, ..Thresholds::default() });
        for text in ["decisive", "decisiv=12", "decisive=0", "decisive=NaN"] {
            let error = Thresholds::default().with(&[text.to_owned()]).unwrap_err().to_string();
            assert!(error.contains(text) && error.contains("significant, flagrant"), "{error}");
        }
    }
}
