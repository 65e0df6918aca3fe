//! What an effect declares about itself: static data for screening, reports and documentation.

use super::parameter::Access;
use super::{EffectParameters, PARAMETERS};

/// Where in the force's way an effect acts; the order is that in which they act.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The sample and its constitutive laws.
    Specimen,
    /// Between sample and punch or support.
    Contact,
    /// The frame between drive and punch.
    Machine,
    /// The load cell and its electronics.
    Sensor,
    /// The computation, not the experiment.
    Numerics,
}

impl Place {
    /// For a person.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Specimen => "specimen",
            Self::Contact => "contact",
            Self::Machine => "machine",
            Self::Sensor => "sensor",
            Self::Numerics => "numerics",
        }
    }
}

/// How a parameter follows the magnitude `m` of a variant: 0 is null, 1 its plausible scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// `null + m (probe - null)`.
    Linear,
    /// `null (probe / null)^m`; both have the same sign and are not 0.
    Geometric,
    /// `m probe`: it keeps its ratio to what is linear beside it.
    Proportional,
    /// `probe` wherever `m` is not 0: a switch, or a value that matters only while the effect acts.
    Switch,
}

/// Which magnitudes mean something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// `m >= 0` only: the plausible scale shows the sign.
    OneSided,
    /// Both signs.
    TwoSided,
}

/// One parameter of the FMU that a variant sets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Name in the variable table.
    pub parameter: &'static str,
    /// Value without the effect, the variable's start; Booleans 0 or 1, enumerations their number (SI).
    pub null: f64,
    /// Value at the plausible scale (SI).
    pub probe: f64,
    /// How it follows the magnitude.
    pub course: Course,
}

impl Setting {
    /// Value at the magnitude `m` (SI).
    pub fn at(&self, m: f64) -> f64 {
        match self.course {
            _ if m == 0.0 => self.null,
            Course::Linear => self.null + m * (self.probe - self.null),
            Course::Geometric => self.null * (self.probe / self.null).powf(m),
            Course::Proportional => m * self.probe,
            Course::Switch => self.probe,
        }
    }
}

/// One way in which an effect can be present, with a magnitude of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    /// Name, unique within the effect.
    pub name: &'static str,
    /// The parameters it moves, together.
    pub settings: &'static [Setting],
    /// Which magnitudes mean something.
    pub sign: Sign,
    /// Whether `solver.sensitivities` may be on with it.
    pub differentiable: bool,
}

impl Variant {
    /// Whether it is on or off, without a magnitude between.
    pub fn is_switch(&self) -> bool {
        self.settings.iter().all(|s| s.course == Course::Switch)
    }
}

/// One effect of the catalogue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// Name: that of its file and of its parameters `effect.<name>.*`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// Where it acts.
    pub place: Place,
    /// How it can be present.
    pub variants: &'static [Variant],
    /// The physics, in two sentences.
    pub physics: &'static str,
    /// What data reveal it.
    pub revealed_by: &'static str,
    /// What else looks like it, in words.
    pub mimicked_by: &'static str,
    /// Names of the effects among those; parameters of the plain model are not listed.
    pub mimics: &'static [&'static str],
}

impl Effect {
    /// An effect of which nothing is told yet but its name, what it is and where it acts.
    pub(super) const fn new(name: &'static str, title: &'static str, place: Place) -> Self {
        Self { name, title, place, variants: &[], physics: "", revealed_by: "", mimicked_by: "", mimics: &[] }
    }

    /// The physics, in two sentences.
    pub(super) const fn physics(self, physics: &'static str) -> Self {
        Self { physics, ..self }
    }

    /// What data reveal it.
    pub(super) const fn revealed_by(self, revealed_by: &'static str) -> Self {
        Self { revealed_by, ..self }
    }

    /// What else looks like it, in words, and the effects among that.
    pub(super) const fn mimicked_by(
        self,
        mimicked_by: &'static str,
        mimics: &'static [&'static str],
    ) -> Self {
        Self { mimicked_by, mimics, ..self }
    }

    /// How it can be present.
    pub(super) const fn variants(self, variants: &'static [Variant]) -> Self {
        Self { variants, ..self }
    }

    /// The parameter by which it acts: one that measures its magnitude and is not at its null.
    pub fn acting(&self, effects: &EffectParameters) -> Option<&'static str> {
        let mut magnitudes =
            self.variants.iter().flat_map(|v| v.settings).filter(|s| s.course != Course::Switch);
        let differs = |setting: &&Setting| {
            let declared = PARAMETERS.iter().copied().flatten().find(|p| p.name == setting.parameter);
            matches!(declared.map(|p| p.access), Some(Access::Real { get, .. }) if get(effects) != setting.null)
        };
        magnitudes.find(differs).map(|setting| setting.parameter)
    }

    /// Whether it acts.
    pub fn acts(&self, effects: &EffectParameters) -> bool {
        self.acting(effects).is_some()
    }
}

pub(super) const fn linear(parameter: &'static str, null: f64, probe: f64) -> Setting {
    Setting { parameter, null, probe, course: Course::Linear }
}

pub(super) const fn geometric(parameter: &'static str, null: f64, probe: f64) -> Setting {
    Setting { parameter, null, probe, course: Course::Geometric }
}

pub(super) const fn proportional(parameter: &'static str, null: f64, probe: f64) -> Setting {
    Setting { parameter, null, probe, course: Course::Proportional }
}

pub(super) const fn switch(parameter: &'static str, null: f64, probe: f64) -> Setting {
    Setting { parameter, null, probe, course: Course::Switch }
}

/// A variant with `m >= 0` whose sensitivities are computed.
pub(super) const fn one_sided(name: &'static str, settings: &'static [Setting]) -> Variant {
    Variant { name, settings, sign: Sign::OneSided, differentiable: true }
}

/// A variant with both signs whose sensitivities are computed.
pub(super) const fn two_sided(name: &'static str, settings: &'static [Setting]) -> Variant {
    Variant { name, settings, sign: Sign::TwoSided, differentiable: true }
}

impl Variant {
    /// The same, refused together with `solver.sensitivities`.
    pub(super) const fn without_sensitivities(mut self) -> Self {
        self.differentiable = false;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn courses_lead_from_null_to_the_probe() {
        for setting in [linear("a", 2.0, 5.0), geometric("a", -2.0, -8.0), switch("a", 0.0, 1.0)] {
            assert_eq!(setting.at(0.0), setting.null);
            approx::assert_relative_eq!(setting.at(1.0), setting.probe, max_relative = 1e-15);
        }
        assert_eq!(linear("a", 2.0, 5.0).at(-1.0), -1.0);
        assert_eq!(geometric("a", -2.0, -8.0).at(0.5), -4.0);
    }

    #[test]
    fn an_effect_acts_where_its_magnitude_is_not_null() {
        let mut effects = EffectParameters::default();
        effects.softening.delay = 20.0;
        assert_eq!(crate::effect::softening::EFFECT.acting(&effects), None);
        effects.softening.loss = 0.1;
        assert_eq!(crate::effect::softening::EFFECT.acting(&effects), Some("effect.softening.loss"));
        assert!(!crate::effect::slip::EFFECT.acts(&effects));
    }
}
