//! The catalogue of effects as a table of the documentation.

use super::variables::{self, Kind, Variable};
use crate::effect::{CATALOGUE, Course, Place, Setting, Sign, Variant};

/// The documentation of the catalogue, `fmu/src/effect/README.md`.
pub fn markdown() -> String {
    let mut text = String::from(
        "# Effects\n\n\
         What the plain model leaves out. Every effect is null by default, and the model is then the plain one, \
         bit for bit.\n\
         Written from the descriptors in this folder by `cargo run --release -q -p poropunch --example \
         effect_table > fmu/src/effect/README.md`.\n\n\
         Along the force's way - specimen, contact, machine, sensor - every effect acts on what those before it \
         leave. How to add one stands at the end.\n",
    );
    for place in [Place::Specimen, Place::Contact, Place::Machine, Place::Sensor, Place::Numerics] {
        let here: Vec<_> = CATALOGUE.iter().filter(|effect| effect.place == place).collect();
        if here.is_empty() {
            continue;
        }
        text += &format!("\n## {}\n\n", capital(place.name()));
        text += "| effect | variant: parameters, null -> plausible scale | physics | revealed by | mimicked by |\n";
        text += "|---|---|---|---|---|\n";
        for effect in here {
            let variants: Vec<_> = effect.variants.iter().map(variant).collect();
            text += &format!(
                "| {} (`{}`) | {} | {} | {} | {} |\n",
                effect.title,
                effect.name,
                variants.join("<br>"),
                effect.physics,
                effect.revealed_by,
                effect.mimicked_by
            );
        }
    }
    text + "\n" + include_str!("../effect/recipe.md")
}

fn variant(variant: &Variant) -> String {
    let settings: Vec<_> = variant.settings.iter().map(setting).collect();
    let sign = match variant.sign {
        _ if variant.is_switch() => "; on or off",
        Sign::OneSided => "",
        Sign::TwoSided => "; either sign",
    };
    let differences = if variant.differentiable { "" } else { "; no sensitivities" };
    format!("{}: {}{sign}{differences}", variant.name, settings.join(", "))
}

fn setting(setting: &Setting) -> String {
    let Some((_, variable)) = variables::by_name(setting.parameter) else {
        return setting.parameter.to_owned();
    };
    let unit = variable.unit().map(|unit| unit.symbol).filter(|&symbol| symbol != "1").unwrap_or("");
    let course = if setting.course == Course::Geometric { " (log)" } else { "" };
    let (null, probe) = (value(variable, setting.null), value(variable, setting.probe));
    let values = if null == probe { null } else { format!("{null} -> {probe}") };
    format!("`{}` {values} {unit}{course}", setting.parameter).trim_end().to_owned()
}

fn value(variable: &Variable, value: f64) -> String {
    match variable.kind {
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Enumeration(e) => {
            let item = e.items.iter().zip(1..).find(|(_, number)| f64::from(*number) == value);
            item.map_or_else(|| value.to_string(), |((name, _), _)| (*name).to_owned())
        }
        _ if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) => format!("{value:e}"),
        _ => value.to_string(),
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{PARAMETERS, by_name};
    use crate::interface::variables::Causality;

    /// Every parameter exists, can be set, and starts at null; every probe is admissible.
    #[test]
    fn settings_are_variables_that_start_at_null() {
        for effect in CATALOGUE {
            assert!(!effect.variants.is_empty(), "{}", effect.name);
            let words = [effect.physics, effect.revealed_by, effect.mimicked_by];
            assert!(words.iter().all(|w| !w.is_empty()), "{}", effect.name);
            for setting in effect.variants.iter().flat_map(|v| v.settings) {
                let (_, variable) = variables::by_name(setting.parameter)
                    .unwrap_or_else(|| panic!("{}: {}", effect.name, setting.parameter));
                assert_eq!(variable.causality, Causality::Parameter, "{}", variable.name);
                assert_eq!(variable.start_number(), setting.null, "{}", variable.name);
                if let Kind::Real { range: Some((min, max)), .. } = variable.kind {
                    assert!((min..=max).contains(&setting.probe), "{}", variable.name);
                }
                if setting.course == Course::Geometric {
                    assert!(setting.probe / setting.null > 0.0, "{}", variable.name);
                }
            }
        }
    }

    /// Names are unique, variants too; every parameter `effect.<name>.*` belongs to the effect's settings.
    #[test]
    fn names_are_consistent() {
        assert_eq!(CATALOGUE.len(), PARAMETERS.len());
        for (k, effect) in CATALOGUE.iter().enumerate() {
            assert!(CATALOGUE[..k].iter().all(|other| other.name != effect.name), "{}", effect.name);
            assert!(effect.mimics.iter().all(|name| by_name(name).is_some()), "{}", effect.name);
            assert!(!effect.mimics.contains(&effect.name), "{}", effect.name);
            for (i, variant) in effect.variants.iter().enumerate() {
                assert!(effect.variants[..i].iter().all(|other| other.name != variant.name));
            }
            for parameter in PARAMETERS[k] {
                let prefix = format!("effect.{}.", effect.name);
                assert!(parameter.name.starts_with(&prefix), "{} in {}", parameter.name, effect.name);
                let mut settings = effect.variants.iter().flat_map(|v| v.settings);
                assert!(settings.any(|s| s.parameter == parameter.name), "{}", parameter.name);
            }
        }
    }

    #[test]
    fn committed_table_is_fresh() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/effect/README.md");
        let committed = std::fs::read_to_string(path).unwrap_or_default();
        assert!(committed == markdown(), "{path} is stale: its third paragraph names the command");
    }
}
