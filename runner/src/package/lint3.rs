//! The same lint for what FMI 3.0 writes in another way.

use crate::fmi::{ModelDescription, VariableKind};
use roxmltree::Node;
use std::collections::HashSet;

/// Outputs and initial unknowns by their value references, with dependencies.
pub fn lint_structure(root: Node, problems: &mut Vec<String>) {
    let nodes = |tag: &'static str| root.descendants().filter(move |node| node.has_tag_name(tag));
    let variables = root.children().find(|node| node.has_tag_name("ModelVariables"));
    let outputs: HashSet<&str> = variables
        .into_iter()
        .flat_map(|node| node.children().collect::<Vec<_>>())
        .filter(|node| node.attribute("causality") == Some("output"))
        .filter_map(|node| node.attribute("valueReference"))
        .collect();
    for tag in ["Output", "InitialUnknown"] {
        let references: Vec<&str> = nodes(tag).filter_map(|node| node.attribute("valueReference")).collect();
        let found: HashSet<&str> = references.iter().copied().collect();
        if found.len() < references.len() {
            problems.push(format!("{tag} names a variable twice"));
        }
        // Every initial unknown of ours is an output with `initial="calculated"`.
        if found != outputs {
            problems.push(format!("{tag} elements are not exactly the outputs"));
        }
        for unknown in nodes(tag).filter(|node| node.attribute("dependencies").is_none()) {
            let reference = unknown.attribute("valueReference").unwrap_or_default();
            problems.push(format!("{tag} {reference}: no dependencies"));
        }
    }
    if nodes("ModelVariables")
        .flat_map(|n| n.children())
        .filter(|n| n.attribute("causality") == Some("independent"))
        .count()
        != 1
    {
        problems.push("there is not exactly one independent variable".to_owned());
    }
}

/// What importers need of single variables.
pub fn lint_variables(description: &ModelDescription, root: Node, problems: &mut Vec<String>) {
    let variables = root.children().find(|node| node.has_tag_name("ModelVariables"));
    let variables: Vec<Node> =
        variables.into_iter().flat_map(|node| node.children()).filter(Node::is_element).collect();
    let mut described = HashSet::new();
    for node in &variables {
        let name = node.attribute("name").unwrap_or_default();
        // A matrix may have columns of several units.
        let dimensions = node.children().filter(|node| node.has_tag_name("Dimension")).count();
        let nominal = node.attribute("nominal").and_then(|text| text.parse::<f64>().ok()).unwrap_or(0.0);
        if node.has_tag_name("Float64") && dimensions < 2 && !(nominal > 0.0 && nominal.is_finite()) {
            problems.push(format!("{name}: no nominal value"));
        }
        if node.has_tag_name("Float64") && dimensions < 2 && node.attribute("unit").is_none() {
            problems.push(format!("{name}: no unit"));
        }
        if node.attribute("description").is_some_and(|text| !described.insert(text)) {
            problems.push(format!("{name}: the description of another"));
        }
    }
    for variable in &description.variables {
        let is_text = variable.kind == VariableKind::String;
        let is_settable =
            matches!(variable.causality.as_str(), "parameter" | "structuralParameter" | "input");
        if is_settable && !is_text && variable.start_number().is_none() {
            problems.push(format!("{}: no start value", variable.name));
        }
    }
}
