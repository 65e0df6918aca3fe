//! An effect that the model does not have: which parameters of the FMU switch it on, by how much, and what of it.
//!
//! A magnitude is counted in plausible scales of the effect, so that 1 means "as large as one would expect it"
//! and 0 is the plain model.

use crate::noise::{Common, Observation, form_errors};
use nalgebra::DVector;
use schemars::JsonSchema;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// The material, or the body made of it.
    Specimen,
    /// Between punch or support and specimen.
    Contact,
    /// Frame and drive.
    Machine,
    /// Load cell and its electronics.
    Sensor,
    /// Mesh, time steps, read-out of the simulation.
    Numerics,
    /// Nobody said: an effect that the user declared.
    Declared,
}

/// Which magnitudes an effect can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sign {
    /// 0 or more.
    Positive,
    /// Of both signs.
    Either,
    /// On (1) or off (0), nothing between.
    Switch,
}

/// Whether all tests share the magnitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scope {
    /// One magnitude for all tests.
    Shared,
    /// A magnitude for each test but the first: what all tests share, the parameters absorb.
    BetweenTests,
}

/// Sets parameters of the FMU for a magnitude (in plausible scales); the others hold their values already.
pub type Action = Arc<dyn Fn(&mut BTreeMap<String, f64>, f64) + Send + Sync>;

/// A model extension that is off at magnitude 0.
#[derive(Clone)]
pub struct Effect {
    /// Short name, e.g. `drift`.
    pub name: String,
    /// Name of the effect that it is a variant of.
    pub family: String,
    /// In words.
    pub title: String,
    /// Where it acts.
    pub place: Place,
    /// Its magnitudes.
    pub sign: Sign,
    /// Shared by the tests or not.
    pub scope: Scope,
    /// Magnitude 1, in `unit`.
    pub scale: f64,
    /// Unit of the scale, for people.
    pub unit: String,
    /// Largest magnitude that is tried, in plausible scales.
    pub largest: f64,
    /// Which data would reveal it.
    pub reveals: String,
    /// Whether the FMU's derivatives by the material parameters may be on with it.
    pub differentiable: bool,
    /// Whether it is a number (a height, a position) and no law of nature, of which there are other forms.
    pub is_a_number: bool,
    /// Parameters that it sets; an FMU without them cannot be asked.
    pub parameters: Vec<String>,
    /// How it sets them.
    pub action: Action,
}

impl Effect {
    /// By what nature's change of the force may deviate in its form from this effect's (`change_mn`, mN, all points), by the part
    /// `form` of it; nothing for a number, which has no other form.
    pub fn errors_of_form(
        &self,
        observations: &[Observation],
        change_mn: &DVector<f64>,
        form: f64,
    ) -> Vec<Common> {
        if self.is_a_number {
            return vec![];
        }
        form_errors(observations, change_mn, form)
    }
}

impl fmt::Debug for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Effect").field("name", &self.name).field("scale", &self.scale).finish_non_exhaustive()
    }
}

/// An effect in all tests, or in one of them.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The effect.
    pub effect: Arc<Effect>,
    /// Index of the only test it acts in.
    pub test: Option<usize>,
    /// Name, with the test's where there is one.
    pub name: String,
}

impl Candidate {
    /// Everything that the effects can be in these tests.
    pub fn of(effects: &[Effect], tests: &[String]) -> Vec<Self> {
        let one = |effect: &Effect| -> Vec<Self> {
            let effect = Arc::new(effect.clone());
            match effect.scope {
                Scope::Shared => vec![Self { name: effect.name.clone(), test: None, effect }],
                Scope::BetweenTests => (1..tests.len())
                    .map(|t| Self {
                        name: format!("{} of {} against {}", effect.name, tests[t], tests[0]),
                        test: Some(t),
                        effect: Arc::clone(&effect),
                    })
                    .collect(),
            }
        };
        effects.iter().flat_map(one).collect()
    }

    /// Sets the parameters of a test's run.
    pub fn apply(&self, values: &mut BTreeMap<String, f64>, test: usize, magnitude: f64) {
        if self.test.is_none_or(|t| t == test) && magnitude != 0.0 {
            (self.effect.action)(values, magnitude);
        }
    }

    /// Magnitudes that are tried, in plausible scales.
    pub fn range(&self) -> (f64, f64) {
        match self.effect.sign {
            Sign::Positive => (0.0, self.effect.largest),
            Sign::Either => (-self.effect.largest, self.effect.largest),
            Sign::Switch => (0.0, 1.0),
        }
    }

    /// Whether only positive magnitudes mean something.
    pub fn is_one_sided(&self) -> bool {
        self.effect.sign != Sign::Either
    }

    /// The score as evidence for the effect: negative magnitudes of a positive effect are none.
    pub fn one_sided(&self, score: f64) -> f64 {
        if self.is_one_sided() { score.max(0.0) } else { score.abs() }
    }
}

/// Whether an effect has a magnitude between off and on.
pub fn is_continuous(candidate: &Candidate) -> bool {
    candidate.effect.sign != Sign::Switch
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn effect(scope: Scope, sign: Sign) -> Effect {
        Effect {
            name: "thing".into(),
            family: "thing".into(),
            title: "a thing".into(),
            place: Place::Sensor,
            sign,
            scope,
            scale: 1.0,
            unit: String::new(),
            largest: 5.0,
            reveals: String::new(),
            differentiable: true,
            is_a_number: false,
            parameters: vec!["p".into()],
            action: Arc::new(|values, magnitude| {
                values.insert("p".into(), 2.0 * magnitude);
            }),
        }
    }

    #[test]
    fn effects_between_tests_leave_out_the_first() {
        let tests = ["P1".to_owned(), "P2".to_owned(), "P3".to_owned()];
        let effects = [effect(Scope::Shared, Sign::Either), effect(Scope::BetweenTests, Sign::Either)];
        let all = Candidate::of(&effects, &tests);
        assert_eq!(all.iter().map(|c| c.test).collect::<Vec<_>>(), [None, Some(1), Some(2)]);
        let mut values = BTreeMap::new();
        all[1].apply(&mut values, 0, 1.0);
        assert!(values.is_empty());
        all[1].apply(&mut values, 1, 1.5);
        assert_eq!(values["p"], 3.0);
        assert!(Candidate::of(&effects[1..], &tests[..1]).is_empty());
    }

    #[test]
    fn a_score_against_the_sign_is_no_evidence() {
        let one = |sign| Candidate::of(&[effect(Scope::Shared, sign)], &["P1".into()])[0].clone();
        assert_eq!(one(Sign::Positive).one_sided(-3.0), 0.0);
        assert_eq!(one(Sign::Either).one_sided(-3.0), 3.0);
        assert_eq!((one(Sign::Positive).range(), one(Sign::Switch).range()), ((0.0, 5.0), (0.0, 1.0)));
    }
}
