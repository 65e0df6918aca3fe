//! Variables of FMI 3.0 in `modelDescription.xml`: every element of an array becomes a scalar variable.

use super::FmiError;
use super::description::{
    Range, ScalarVariable, VariableKind, bad, child, display_factor, items, number, required,
};
use super::places::{Base, Elements, Place, Places};
use poropunch::model_description::fmi3::ELEMENTS;
use roxmltree::Node;
use std::collections::BTreeMap;

/// Arrays of more elements are not looked into: nobody addresses their elements one by one.
const MOST_ELEMENTS: usize = 1 << 16;

/// Scalar variables of the declared ones, and where they stand.
pub fn variables3(root: Node, declared: Node) -> Result<(Vec<ScalarVariable>, Places), FmiError> {
    let nodes: Vec<Node> = declared.children().filter(Node::is_element).collect();
    let mut next =
        1 + nodes.iter().filter_map(|&node| reference(node, "valueReference").ok()).max().unwrap_or(0);
    let sizes = sizes(&nodes);
    let (mut variables, mut places) = (Vec::new(), Places::default());
    for &node in &nodes {
        variable(root, node, &sizes, &mut next, &mut variables, &mut places)?;
    }
    Ok((variables, places))
}

fn reference(node: Node, name: &str) -> Result<u32, FmiError> {
    required(node, name)?.parse().map_err(|_| bad(node, &format!("{name} is not a number")))
}

/// Start values of what may be the size of an array.
fn sizes(nodes: &[Node]) -> BTreeMap<u32, usize> {
    let sizes = nodes.iter().filter(|node| node.has_tag_name("UInt64"));
    let size = |node: &Node| {
        Some((reference(*node, "valueReference").ok()?, node.attribute("start")?.parse().ok()?))
    };
    sizes.filter_map(size).collect()
}

fn base(tag: &str) -> Option<(VariableKind, Base)> {
    Some(match tag {
        "Float64" => (VariableKind::Real, Base::Float64),
        "Float32" => (VariableKind::Real, Base::Float32),
        "Int8" => (VariableKind::Integer, Base::Int8),
        "UInt8" => (VariableKind::Integer, Base::UInt8),
        "Int16" => (VariableKind::Integer, Base::Int16),
        "UInt16" => (VariableKind::Integer, Base::UInt16),
        "Int32" => (VariableKind::Integer, Base::Int32),
        "UInt32" => (VariableKind::Integer, Base::UInt32),
        "Int64" => (VariableKind::Integer, Base::Int64),
        "UInt64" => (VariableKind::Integer, Base::UInt64),
        "Enumeration" => (VariableKind::Enumeration, Base::Int64),
        "Boolean" => (VariableKind::Boolean, Base::Boolean),
        "String" => (VariableKind::String, Base::String),
        // Binaries and clocks: nothing of this program's.
        _ => return None,
    })
}

/// The scalars of one variable.
fn variable(
    root: Node,
    node: Node,
    sizes: &BTreeMap<u32, usize>,
    next: &mut u32,
    variables: &mut Vec<ScalarVariable>,
    places: &mut Places,
) -> Result<(), FmiError> {
    let Some((kind, base)) = base(node.tag_name().name()) else { return Ok(()) };
    let (name, own) = (required(node, "name")?, reference(node, "valueReference")?);
    let shape = shape(node, sizes)?;
    let count = shape.iter().try_fold(1_usize, |n, &size| n.checked_mul(size));
    let count = count.filter(|&n| n <= MOST_ELEMENTS).ok_or_else(|| bad(node, "too many elements"))?;
    let starts = starts(node, kind);
    let declared = node.attribute("declaredType").and_then(|name| type_definition(root, name));
    let attribute = |name| node.attribute(name).or_else(|| declared.and_then(|d| d.attribute(name)));
    let (unit, display_unit) = (attribute("unit"), attribute("displayUnit"));
    let factor = match (unit, display_unit) {
        (Some(unit), Some(display)) => display_factor(root, unit, display)?,
        _ => 1.0,
    };
    let names = element_names(node, &name, &shape, count);
    for (index, name) in names.into_iter().enumerate() {
        let value_reference = if shape.is_empty() {
            own
        } else {
            *next += 1;
            *next - 1
        };
        places.scalars.insert(value_reference, Place { reference: own, index, base });
        variables.push(ScalarVariable {
            name,
            value_reference,
            kind,
            causality: node.attribute("causality").unwrap_or("local").to_owned(),
            variability: node
                .attribute("variability")
                .map_or_else(|| default_variability(kind), str::to_owned),
            // One start for all elements is allowed.
            start: starts.get(index).or(starts.first()).cloned(),
            range: Range::declared(node, attribute)?,
            unit: unit.map(str::to_owned),
            display_unit: display_unit.map(str::to_owned),
            display_factor: factor,
            items: declared.map(items).transpose()?.unwrap_or_default(),
            description: node.attribute("description").unwrap_or_default().to_owned(),
        });
    }
    let of_this = &variables[variables.len() - count..];
    let elements = Elements {
        numbers: of_this.iter().map(|v| v.start_number().unwrap_or(0.0)).collect(),
        texts: of_this.iter().map(|v| v.start.clone().unwrap_or_default()).collect(),
    };
    places.starts.insert(own, elements);
    Ok(())
}

fn default_variability(kind: VariableKind) -> String {
    if kind == VariableKind::Real { "continuous" } else { "discrete" }.to_owned()
}

fn shape(node: Node, sizes: &BTreeMap<u32, usize>) -> Result<Vec<usize>, FmiError> {
    let dimensions = node.children().filter(|node| node.has_tag_name("Dimension"));
    let size = |dimension: Node| match number(dimension, "start")? {
        Some(size) if size >= 0.0 => Ok(size as usize),
        _ => {
            let variable = reference(dimension, "valueReference")?;
            sizes.get(&variable).copied().ok_or_else(|| bad(dimension, "a dimension without a size"))
        }
    };
    dimensions.map(size).collect()
}

/// Start values of the elements.
fn starts(node: Node, kind: VariableKind) -> Vec<String> {
    if kind != VariableKind::String {
        return node.attribute("start").unwrap_or_default().split_whitespace().map(str::to_owned).collect();
    }
    let starts = node.children().filter(|node| node.has_tag_name("Start"));
    starts.map(|start| start.attribute("value").unwrap_or_default().to_owned()).collect()
}

/// Names of a variable's elements: its own, those that it tells, or with their indices, from 1 and row by row.
fn element_names(node: Node, name: &str, shape: &[usize], count: usize) -> Vec<String> {
    if shape.is_empty() {
        return vec![name.to_owned()];
    }
    let annotations = node.children().filter(|node| node.has_tag_name("Annotations"));
    let told = annotations
        .flat_map(|node| node.children().collect::<Vec<_>>())
        .find(|node| node.attribute("type") == Some(ELEMENTS))
        .and_then(|node| node.text());
    let told: Vec<String> = told.unwrap_or_default().split_whitespace().map(str::to_owned).collect();
    if told.len() == count {
        return told;
    }
    let with_indices = |element: usize| {
        let mut rest = element;
        let mut indices: Vec<String> = Vec::with_capacity(shape.len());
        for &size in shape.iter().rev() {
            indices.push((rest % size + 1).to_string());
            rest /= size;
        }
        indices.reverse();
        format!("{name}[{}]", indices.join(","))
    };
    (0..count).map(with_indices).collect()
}

fn type_definition<'a>(root: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    child(root, "TypeDefinitions")?.children().find(|node| node.attribute("name") == Some(name))
}
