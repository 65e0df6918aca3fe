//! What the usual validators miss in an FMU.

use super::archive::LICENSES;
use super::binaries::lint_binaries;
use super::lint3;
use crate::fmi::{Files, FmiError, Fmu, ModelDescription, Range, VariableKind, Version};
use roxmltree::{Document, Node};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// Problems of an FMU.
#[derive(Debug, Default)]
pub struct Problems {
    /// Of its description, binary and files together.
    pub own: Vec<String>,
    /// What keeps its libraries from machines other than the one that built them.
    pub elsewhere: Vec<String>,
}

/// Problems of an archive or unpacked FMU.
///
/// # Errors
/// When it cannot be loaded at all.
pub fn lint(path: &Path) -> Result<Problems, FmiError> {
    let files = Arc::new(Files::open(path)?);
    let mut own = lint_description(&files.description()?)?;
    let fmu = Fmu::of(Arc::clone(&files))?;
    own.extend(lint_starts(&fmu)?);
    lint_files(path, files.root(), &mut own);
    let elsewhere = lint_binaries(files.root(), &fmu.description().model_identifier)
        .map_err(|source| FmiError::Io { path: files.root().join("binaries"), source })?;
    Ok(Problems { own, elsewhere })
}

/// The archive as a file, and what else is in it.
fn lint_files(path: &Path, root: &Path, problems: &mut Vec<String>) {
    if !root.join(LICENSES).is_file() {
        problems.push(format!("{LICENSES} is missing: the licences of what is linked into the binary"));
    }
    #[cfg(unix)]
    if path.is_file()
        && let Ok(file) = std::fs::metadata(path)
        && let Some(umask) = umask()
    {
        let mode = std::os::unix::fs::PermissionsExt::mode(&file.permissions());
        if 0o044 & !umask & !mode != 0 {
            problems.push(format!("the archive has mode {:o}: others cannot read it", mode & 0o777));
        }
    }
}

/// What this process takes away from the modes of its files, where the system tells.
#[cfg(unix)]
fn umask() -> Option<u32> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("Umask:"))?;
    u32::from_str_radix(line.trim(), 8).ok()
}

/// Problems of a `modelDescription.xml` alone.
///
/// # Errors
/// When it cannot be read at all.
pub fn lint_description(xml: &str) -> Result<Vec<String>, FmiError> {
    let description = ModelDescription::parse(xml)?;
    let document = Document::parse(xml)
        .map_err(|e| FmiError::BadDescription { line: e.pos().row, reason: e.to_string() })?;
    let root = document.root_element();
    let mut problems = Vec::new();
    lint_variables(&description, &mut problems);
    match description.version {
        Version::Two => {
            lint_structure(&description, root, &mut problems);
            lint_real_units(&description, &mut problems);
            lint_importers(root, &mut problems);
        }
        Version::Three => {
            lint3::lint_structure(root, &mut problems);
            lint3::lint_variables(&description, root, &mut problems);
        }
    }
    lint_units(&description, root, &mut problems);
    lint_experiment(root, &mut problems);
    let capabilities = description.capabilities;
    if capabilities.serialize_state && !capabilities.get_and_set_state {
        problems.push("canSerializeFMUstate without canGetAndSetFMUstate".to_owned());
    }
    let (name, guid) = (&description.model_identifier, &description.guid);
    if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        problems.push(format!("modelIdentifier `{name}` is not a C identifier"));
    }
    if guid.trim().is_empty() {
        problems.push("the GUID is empty".to_owned());
    }
    let categories: Vec<_> = names(root, "LogCategories", "Category");
    if categories.iter().collect::<HashSet<_>>().len() < categories.len() {
        problems.push("a log category is declared twice".to_owned());
    }
    Ok(problems)
}

fn lint_variables(description: &ModelDescription, problems: &mut Vec<String>) {
    let (mut names, mut references) = (HashSet::new(), HashSet::new());
    for variable in &description.variables {
        let name = &variable.name;
        if !names.insert(name) {
            problems.push(format!("{name}: the name is used twice"));
        }
        // Value references are counted per base type; aliases are not used here.
        let integers = matches!(variable.kind, VariableKind::Integer | VariableKind::Enumeration);
        let base = if integers { VariableKind::Integer } else { variable.kind };
        if !references.insert((base as u8, variable.value_reference)) {
            problems.push(format!("{name}: value reference {} is used twice", variable.value_reference));
        }
        if variable.description.trim().is_empty() {
            problems.push(format!("{name}: no description"));
        }
        let needs_start = matches!(variable.causality.as_str(), "parameter" | "input");
        match (&variable.start, variable.start_number()) {
            (None, _) if needs_start => problems.push(format!("{name}: no start value")),
            (Some(text), None) if variable.kind != VariableKind::String => {
                problems.push(format!("{name}: start `{text}` is not a value"));
            }
            (Some(text), Some(start)) if !start.is_finite() => {
                problems.push(format!("{name}: start `{text}` is not finite"));
            }
            (_, Some(start)) if start < variable.range.min || start > variable.range.max => {
                problems.push(format!("{name}: start {start} is outside its own range"));
            }
            _ => {}
        }
        let Range { min, max } = variable.range;
        if min.is_nan() || max.is_nan() || min > max {
            problems.push(format!("{name}: min {min} and max {max} are no range"));
        }
    }
}

fn lint_structure(description: &ModelDescription, root: Node, problems: &mut Vec<String>) {
    let outputs: Vec<usize> = (1..)
        .zip(&description.variables)
        .filter(|(_, variable)| variable.causality == "output")
        .map(|(index, _)| index)
        .collect();
    for section in ["Outputs", "InitialUnknowns"] {
        let node = root.descendants().find(|node| node.has_tag_name(section));
        let unknowns = node.into_iter().flat_map(|n| n.children().collect::<Vec<_>>());
        let indices: Vec<usize> = unknowns.filter_map(|node| node.attribute("index")?.parse().ok()).collect();
        if !indices.is_sorted() {
            problems.push(format!("{section} are not in ascending order"));
        }
        let (found, expected): (HashSet<_>, HashSet<_>) =
            (indices.iter().collect(), outputs.iter().collect());
        if found.len() < indices.len() {
            problems.push(format!("{section} name a variable twice"));
        }
        // Every initial unknown of ours is an output with `initial="calculated"`.
        if found != expected {
            problems.push(format!("{section} are not exactly the outputs"));
        }
    }
}

fn lint_real_units(description: &ModelDescription, problems: &mut Vec<String>) {
    for variable in description.variables.iter().filter(|v| v.kind == VariableKind::Real) {
        if variable.unit.is_none() {
            problems.push(format!("{}: no unit", variable.name));
        }
    }
}

fn lint_units(description: &ModelDescription, root: Node, problems: &mut Vec<String>) {
    let units: HashSet<String> = names(root, "UnitDefinitions", "Unit").into_iter().collect();
    for variable in &description.variables {
        let name = &variable.name;
        if variable.unit.as_ref().is_some_and(|unit| !units.contains(unit)) {
            problems.push(format!("{name}: its unit is not defined"));
        }
        if let (Some(unit), Some(display)) = (&variable.unit, &variable.display_unit) {
            let defined = root.descendants().filter(|n| n.has_tag_name("Unit")).any(|n| {
                n.attribute("name") == Some(unit)
                    && n.children().any(|d| d.attribute("name") == Some(display.as_str()))
            });
            if !defined {
                problems.push(format!("{name}: its display unit is not defined"));
            }
        }
    }
    for unit in root.descendants().filter(|node| node.has_tag_name("Unit")) {
        for part in ["BaseUnit", "DisplayUnit"] {
            if !unit.children().any(|child| child.has_tag_name(part)) {
                problems
                    .push(format!("unit {}: no {part}", unit.attribute("name").unwrap_or("without name")));
            }
        }
    }
}

/// What importers need without any standard's demanding it: OMSimulator finds an algebraic loop where no dependencies
/// are told, comparers and solvers take 1 for a missing nominal value, a missing tolerance or end for their own.
fn lint_importers(root: Node, problems: &mut Vec<String>) {
    let all = |tag: &'static str| root.descendants().filter(move |node| node.has_tag_name(tag));
    for unknown in all("Unknown").filter(|node| node.attribute("dependencies").is_none()) {
        problems.push(format!("unknown {}: no dependencies", unknown.attribute("index").unwrap_or_default()));
    }
    for variable in all("ScalarVariable") {
        let real = variable.children().find(|node| node.has_tag_name("Real"));
        let nominal = real.map(|r| r.attribute("nominal").and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0));
        if nominal.is_some_and(|nominal| nominal <= 0.0 || !nominal.is_finite()) {
            problems.push(format!("{}: no nominal value", variable.attribute("name").unwrap_or_default()));
        }
    }
    let mut described = HashSet::new();
    for variable in all("ScalarVariable") {
        let (name, text) = (variable.attribute("name"), variable.attribute("description"));
        if text.is_some_and(|text| !described.insert(text)) {
            problems.push(format!("{}: the description of another", name.unwrap_or_default()));
        }
    }
}

fn lint_experiment(root: Node, problems: &mut Vec<String>) {
    let all = |tag: &'static str| root.descendants().filter(move |node| node.has_tag_name(tag));
    for base in all("Unit").filter(|unit| unit.attribute("name") == Some("rad")) {
        if !base.children().any(|child| child.attribute("rad") == Some("1")) {
            problems.push("unit rad: no rad=\"1\" in its BaseUnit".to_owned());
        }
    }
    for name in ["stopTime", "tolerance", "stepSize"] {
        if !all("DefaultExperiment").any(|node| node.attribute(name).is_some()) {
            problems.push(format!("DefaultExperiment: no {name}"));
        }
    }
}

/// Start values of the description against the binary's.
fn lint_starts(fmu: &Fmu) -> Result<Vec<String>, FmiError> {
    let mut instance = fmu.instantiate("lint")?;
    instance.setup_experiment(0.0, None)?;
    instance.enter_initialization_mode()?;
    let mut problems = Vec::new();
    for variable in &fmu.description().variables {
        let reference = [variable.value_reference];
        if variable.kind == VariableKind::String {
            let (actual, start) = (instance.get_string(&reference)?, &variable.start);
            if start.as_ref().is_some_and(|start| *start != actual[0]) {
                let name = &variable.name;
                problems.push(format!("{name}: start is another in the description than in the binary"));
            }
            continue;
        }
        let Some(start) = variable.start_number() else { continue };
        let actual = match variable.kind {
            VariableKind::Real => instance.get_real(&reference)?[0],
            VariableKind::Integer | VariableKind::Enumeration => {
                f64::from(instance.get_integer(&reference)?[0])
            }
            VariableKind::Boolean => f64::from(u8::from(instance.get_boolean(&reference)?[0])),
            VariableKind::String => continue,
        };
        if actual.to_bits() != start.to_bits() {
            let name = &variable.name;
            problems.push(format!("{name}: start is {start} in the description and {actual} in the binary"));
        }
    }
    Ok(problems)
}

fn names(root: Node, section: &str, tag: &str) -> Vec<String> {
    let section = root.children().find(|node| node.has_tag_name(section));
    let nodes = section.into_iter().flat_map(|node| node.children().collect::<Vec<_>>());
    nodes
        .filter(|node| node.has_tag_name(tag))
        .filter_map(|n| n.attribute("name").map(str::to_owned))
        .collect()
}
