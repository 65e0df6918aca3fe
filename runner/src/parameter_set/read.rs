//! An SSV file as settings of a model.

use super::unit::{Definition, exponents};
use super::{SSC, SSV};
use crate::fmi::ScalarVariable;
use crate::output::read_input;
use crate::pool::Wiring;
use crate::setting::{SettingError, number_in, variable_named};
use crate::units::Unit;
use roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A parameter set that cannot be used.
#[derive(Debug, Error)]
pub enum ParameterSetError {
    /// The file itself.
    #[error("{}: cannot be read: {source}; check the path", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// No SSV, or a parameter or unit that is not as SSV has it.
    #[error("{}: line {line}: {problem}", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u32,
        /// What is wrong, and the remedy.
        problem: String,
    },
    /// A value that the model's parameter cannot have.
    #[error("{}: line {line}: {source}", file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u32,
        /// Reason.
        source: SettingError,
    },
}

/// A parameter set, as its file has it.
#[derive(Debug)]
pub struct ParameterSet {
    file: PathBuf,
    entries: Vec<Entry>,
    units: BTreeMap<String, Definition>,
}

#[derive(Debug)]
struct Entry {
    name: String,
    line: u32,
    value: String,
    unit: Option<String>,
}

impl ParameterSet {
    /// Reads the file.
    ///
    /// # Errors
    /// When it cannot be read, or is no SSV file of scalars.
    pub fn read(file: &Path) -> Result<Self, ParameterSetError> {
        let unreadable = |source| ParameterSetError::Unreadable { file: file.to_owned(), source };
        let bytes = read_input(file).map_err(unreadable)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            unreadable(std::io::Error::new(std::io::ErrorKind::InvalidData, "it is not UTF-8"))
        })?;
        Self::parse(&text)
            .map_err(|(line, problem)| ParameterSetError::Format { file: file.to_owned(), line, problem })
            .map(|set| Self { file: file.to_owned(), ..set })
    }

    /// Reads the document; complaints come with their line.
    fn parse(text: &str) -> Result<Self, (u32, String)> {
        let document = Document::parse(text).map_err(|e| (e.pos().row, format!("this is no XML: {e}")))?;
        let root = document.root_element();
        let line = |node: Node| document.text_pos_at(node.range().start).row;
        if !root.has_tag_name((SSV, "ParameterSet")) {
            let found = root.tag_name();
            let namespace = found.namespace().unwrap_or("none");
            let problem = format!(
                "the root element is `{}` of the namespace {namespace}; a parameter set is a `ParameterSet` of {SSV}",
                found.name()
            );
            return Err((line(root), problem));
        }
        let mut entries: Vec<Entry> = Vec::new();
        let mut names = BTreeSet::new();
        for node in elements(root, SSV, "Parameters").flat_map(|p| elements(p, SSV, "Parameter")) {
            let entry = entry(node).map_err(|problem| (line(node), problem))?;
            if !names.insert(entry.name.clone()) {
                return Err((line(node), format!("{} is there twice; keep one of the two", entry.name)));
            }
            entries.push(Entry { line: line(node), ..entry });
        }
        let mut units = BTreeMap::new();
        for node in elements(root, SSV, "Units").flat_map(|units| elements(units, SSC, "Unit")) {
            let name = node.attribute("name").unwrap_or_default();
            if let Some(base) = elements(node, SSC, "BaseUnit").next() {
                let read = Definition::read(base);
                let problem = |e| (line(base), format!("unit `{name}`: {e}; write a number"));
                units.insert(name.to_owned(), read.map_err(problem)?);
            }
        }
        Ok(Self { file: PathBuf::new(), entries, units })
    }

    /// What the set says, as `NAME=VALUE UNIT` of the model's parameters; what the model has not is left out, as SSP asks.
    ///
    /// # Errors
    /// A value that cannot be read, has the unit of another quantity, or is not admissible; a unit that the file defines otherwise than
    /// its name says; a file that has none of the model's parameters.
    pub fn settings(&self, wiring: &Wiring) -> Result<Vec<String>, ParameterSetError> {
        let own: Vec<(&Entry, &ScalarVariable)> = self.of(wiring).collect();
        if let (true, Some(first)) = (own.is_empty(), self.entries.first()) {
            let source = match variable_named(wiring, &first.name) {
                Err(source) => source,
                Ok(_) => SettingError::NotAnAssignment(first.name.clone()),
            };
            return Err(self.value_error(first, source));
        }
        own.into_iter().map(|(entry, variable)| self.setting(entry, variable)).collect()
    }

    /// What was read leniently: values without a unit, and parameters that the model has not.
    pub fn notes(&self, wiring: &Wiring) -> Vec<String> {
        let has_unit = |v: &ScalarVariable| v.unit.as_deref().is_some_and(|unit| unit != "1");
        let bare = self.of(wiring).filter(|(e, v)| e.unit.is_none() && has_unit(v));
        let bare: Vec<String> = bare
            .map(|(e, v)| format!("{} = {} {}", e.name, e.value, v.unit.as_deref().unwrap_or_default()))
            .collect();
        let foreign = self.entries.iter().filter(|e| !wiring.parameters.contains_key(&e.name));
        let foreign: Vec<&str> = foreign.map(|e| e.name.as_str()).collect();
        let file = self.file.display();
        let mut notes = Vec::new();
        if !bare.is_empty() {
            notes.push(format!("{file}: no unit, so the model's own: {}", bare.join(", ")));
        }
        if !foreign.is_empty() {
            notes.push(format!("{file}: not in this model, left out: {}", foreign.join(", ")));
        }
        notes
    }

    /// Entries that are parameters of the model.
    fn of<'a>(&'a self, wiring: &'a Wiring) -> impl Iterator<Item = (&'a Entry, &'a ScalarVariable)> {
        self.entries.iter().filter_map(|entry| Some((entry, wiring.parameters.get(&entry.name)?)))
    }

    fn setting(&self, entry: &Entry, variable: &ScalarVariable) -> Result<String, ParameterSetError> {
        let (value, unit) = match &entry.unit {
            None => {
                (entry.value.clone(), variable.unit.clone().filter(|unit| unit != "1").unwrap_or_default())
            }
            Some(unit) => self.in_known_unit(entry, unit, variable)?,
        };
        let text = format!("{value} {unit}");
        number_in(variable, &text).map_err(|source| self.value_error(entry, source))?;
        Ok(format!("{}={}", entry.name, text.trim_end()))
    }

    /// Value and unit, where the file's own definition of the unit is heeded.
    fn in_known_unit(
        &self,
        entry: &Entry,
        unit: &str,
        variable: &ScalarVariable,
    ) -> Result<(String, String), ParameterSetError> {
        let by_name = Ok((entry.value.clone(), unit.to_owned()));
        let Some(definition) = self.units.get(unit).filter(|d| !d.others) else { return by_name };
        let problem = |problem: String| ParameterSetError::Format {
            file: self.file.clone(),
            line: entry.line,
            problem: format!("{}: {problem}", entry.name),
        };
        if let Some(known) = Unit::parse(unit) {
            let why = format!(
                "the file's definition of the unit `{unit}` is not what `{unit}` is; mend its BaseUnit"
            );
            return if definition.is(&known) { by_name } else { Err(problem(why)) };
        }
        // A name of the file's own: what it defines, in SI.
        let wanted = variable.unit.as_deref().and_then(Unit::parse).map(|unit| unit.dimension);
        let Some(dimension) = wanted.filter(|d| exponents(*d) == definition.exponents) else {
            let wanted = variable.unit.as_deref().unwrap_or("a number");
            return Err(problem(format!(
                "`{unit}`, as the file defines it, is no unit of {wanted}; give one"
            )));
        };
        let value: f64 =
            entry.value.trim().parse().map_err(|_| problem(format!("`{}` is no number", entry.value)))?;
        let si = value * definition.factor + definition.offset;
        Ok((format!("{si:?}"), Unit::si(dimension).symbol.to_owned()))
    }

    fn value_error(&self, entry: &Entry, source: SettingError) -> ParameterSetError {
        ParameterSetError::Value { file: self.file.clone(), line: entry.line, source }
    }
}

fn elements<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    namespace: &'static str,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name((namespace, name)))
}

fn entry(node: Node) -> Result<Entry, String> {
    let name = node.attribute("name").ok_or("a Parameter without a name; give it one")?.to_owned();
    let typed = node.children().find(|child| child.is_element() && child.tag_name().namespace() == Some(SSV));
    let typed =
        typed.ok_or_else(|| format!("{name} has no value; write for example <ssv:Real value=\"1\"/>"))?;
    let kind = typed.tag_name().name();
    if matches!(kind, "String" | "Binary") {
        return Err(format!(
            "{name} is a {kind}; only numbers, truth values and items can be set: leave it out"
        ));
    }
    let value =
        typed.attribute("value").ok_or_else(|| format!("{name}: {kind} without a value; give it one"))?;
    if value.split_whitespace().count() != 1 || node.children().any(|c| c.tag_name().name() == "Dimension") {
        return Err(format!("{name}: `{value}` is no single value; arrays cannot be set"));
    }
    let unit = typed.attribute("unit").map(str::trim).filter(|unit| !unit.is_empty()).map(str::to_owned);
    Ok(Entry { name, line: 0, value: value.to_owned(), unit })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::Fmu;
    use crate::parameter_set::ssv;
    use crate::pool::wiring::Names;
    use crate::setting::settings_from;

    fn wiring() -> Wiring {
        Wiring::new(Fmu::builtin().unwrap().description(), &Names::default()).unwrap()
    }

    fn set(parameters: &str, units: &str) -> String {
        format!(
            "<?xml version=\"1.0\"?>\n<v:ParameterSet xmlns:v=\"{SSV}\" xmlns:c=\"{SSC}\" version=\"1.0\" name=\"s\">\n\
             <v:Parameters>\n{parameters}\n</v:Parameters><v:Units>{units}</v:Units></v:ParameterSet>"
        )
    }

    fn real(name: &str, value: &str, unit: &str) -> String {
        let unit = if unit.is_empty() { String::new() } else { format!(" unit=\"{unit}\"") };
        format!("<v:Parameter name=\"{name}\"><v:Real value=\"{value}\"{unit}/></v:Parameter>")
    }

    fn values(text: &str) -> Result<BTreeMap<String, f64>, String> {
        let wiring = wiring();
        let read = ParameterSet::parse(text).map_err(|(line, problem)| format!("line {line}: {problem}"))?;
        let settings = read.settings(&wiring).map_err(|e| e.to_string())?;
        Ok(settings_from(&wiring, &settings).unwrap())
    }

    #[test]
    fn units_convert_by_name_by_definition_and_by_default() {
        let units = "<c:Unit name=\"darcy\"><c:BaseUnit m=\"2\" factor=\"9.869233e-13\"/></c:Unit>\
                     <c:Unit name=\"kPa\"><c:BaseUnit kg=\"1\" m=\"-1\" s=\"-2\" factor=\"1000\"/></c:Unit>";
        let parameters = [
            real("material.permeability", "2", "darcy"),
            real("material.equilibrium.mu", "-0.2", "kPa"),
            real("geometry.punch_radius", "0.002", ""),
            real("geometry.sample_height", "8", "mm"),
            "<v:Parameter name=\"mesh.preset\"><v:Enumeration value=\"coarse\"/></v:Parameter>".to_owned(),
            "<v:Parameter name=\"boundary.drained_punch\"><v:Boolean value=\"true\"/></v:Parameter>"
                .to_owned(),
        ];
        let read = values(&set(&parameters.join("\n"), units)).unwrap();
        let near = |name: &str, value: f64| {
            assert!((read[name] / value - 1.0).abs() < 1e-12, "{name}: {}", read[name])
        };
        near("material.permeability", 2.0 * 9.869_233e-13);
        near("material.equilibrium.mu", -200.0);
        near("geometry.punch_radius", 2e-3);
        near("geometry.sample_height", 8e-3);
        assert_eq!(read["boundary.drained_punch"], 1.0);
        assert_eq!(read.len(), 6);
    }

    #[test]
    fn complaints_name_parameter_unit_and_remedy() {
        let kilopascal = "<c:Unit name=\"kPa\"><c:BaseUnit kg=\"1\" m=\"-1\" s=\"-2\"/></c:Unit>";
        let own = "<c:Unit name=\"x\"><c:BaseUnit kg=\"1\"/></c:Unit>";
        let cases = [
            (real("material.permeability", "1", "mm"), "", "`mm` is not a unit of Area; known: m^2"),
            (real("material.permeability", "1", "acre"), "", "unknown unit `acre`"),
            (real("material.equilibrium.mu", "1", "kPa"), kilopascal, "mend its BaseUnit"),
            (real("material.equilibrium.mu", "1", "x"), own, "no unit of Pa; give one"),
            (real("material.n0s", "2", ""), "", "outside its bounds"),
            (real("material.n0", "2", ""), "", "did you mean material.n0s"),
            (real("material.n0s", "0.1 0.2", ""), "", "no single value"),
            (real("material.n0s", "0.1", "") + "\n" + &real("material.n0s", "0.2", ""), "", "twice"),
            (
                "<v:Parameter name=\"fields.path\"><v:String value=\"a\"/></v:Parameter>".to_owned(),
                "",
                "is a String",
            ),
        ];
        for (parameters, units, words) in cases {
            let error = values(&set(&parameters, units)).unwrap_err();
            let line = if words == "twice" { "line 5" } else { "line 4" };
            assert!(error.contains(words) && error.contains(line), "{words}: {error}");
        }
        assert!(values("<a/>").unwrap_err().contains("a parameter set is a `ParameterSet`"));
    }

    #[test]
    fn what_the_model_has_not_is_left_out_and_told() {
        let text = set(&(real("engine.torque", "1", "N") + &real("geometry.punch_radius", "0.002", "")), "");
        let read = ParameterSet::parse(&text).unwrap();
        assert_eq!(read.settings(&wiring()).unwrap(), ["geometry.punch_radius=0.002 m"]);
        let notes = read.notes(&wiring());
        assert!(notes[0].contains("geometry.punch_radius = 0.002 m"), "{notes:?}");
        assert!(notes[1].contains("left out: engine.torque"), "{notes:?}");
    }

    #[test]
    fn what_is_written_is_read_again() {
        let wiring = wiring();
        let all = wiring.parameters.iter();
        let starts: BTreeMap<String, f64> =
            all.filter_map(|(name, v)| Some((name.clone(), v.start_number()?))).collect();
        let read = values(&ssv("all", &wiring, &starts)).unwrap();
        assert_eq!(read.len(), starts.len());
        for (name, value) in &starts {
            assert!((read[name] - value).abs() <= 1e-15 * value.abs(), "{name}: {} for {value}", read[name]);
        }
    }
}
