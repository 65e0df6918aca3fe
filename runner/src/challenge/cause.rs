//! What can be behind a case, whoever computes it.

use super::form::Form;
use poropunch_maker::Effect;
use serde::{Deserialize, Serialize};

/// A cause with its size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "source", rename_all = "kebab-case")]
pub enum Cause {
    /// Of the near ground, computed with the engine.
    Engine(Form),
    /// Of the wide ground, computed by the independent solver.
    Maker(Effect),
    /// Of single specimens, whoever computes the others.
    Specimen(Flaw),
}

/// What is wrong with one specimen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum Flaw {
    /// Outside the catalogue: it is cracked, and softens while it is held.
    BadSpecimen {
        /// Part of its force that goes.
        loss: f64,
        /// In this time (s).
        time_s: f64,
    },
}

impl Cause {
    /// Name in the catalogue; `None` outside of it.
    pub fn effect(&self) -> Option<&'static str> {
        match self {
            Self::Engine(form) => form.effect(),
            Self::Maker(effect) => effect.catalogue(),
            Self::Specimen(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both grounds have an overshoot with the same fields: the key tells them apart, and each has a form for the table of scores.
    #[test]
    fn causes_are_read_as_they_were_written() {
        let causes = [
            Cause::Engine(Form::Overshoot { length: 1e-5, frequency: 3.0, decay_s: 0.2 }),
            Cause::Maker(Effect::Overshoot { length: 1e-5, frequency: 3.0, decay_s: 0.2 }),
            Cause::Specimen(Flaw::BadSpecimen { loss: 0.1, time_s: 7.0 }),
        ];
        for cause in causes {
            let value = serde_json::to_value(&cause).unwrap();
            assert!(value["form"].is_string() && cause.effect().is_none());
            assert_eq!(serde_json::from_value::<Cause>(value).unwrap(), cause);
        }
    }
}
