//! The documents of FMI 3.0: scalars and arrays as [`Port`] groups the table's rows; terminals.

use super::{
    Attributes, INITIAL_DEPENDENCIES, MODEL_IDENTIFIER, Xml, braced, causality, default_experiment, empty,
    enumerations, items, log_categories, range, real, root, text, unit_definitions, variability,
};
use crate::interface::hash::hash_128;
use crate::interface::variables::ports::{BaseType, POINTS, POINTS_RANGE, Port};
use crate::interface::variables::{Causality, Kind, Readings, Settings, Value, table};
use crate::unit::{METRE, SECOND};
use quick_xml::events::BytesText;
use std::io;
use std::sync::LazyLock;

/// Version of the standard, in both documents.
const VERSION: &str = "3.0";

/// What the punch's terminal consists of: the variables and their names in it.
const PUNCH: [(&str, &str); 4] = [
    ("displacement", "displacement"),
    ("displacement_rate", "velocity"),
    ("punch_displacement", "reached_displacement"),
    ("force", "force"),
];

/// Side of the square icon (px).
pub const ICON_SIZE: u32 = 128;

/// Type of the annotation that tells the names of an array's elements in FMI 2.0, on the command line and in files.
pub const ELEMENTS: &str = "org.poropunch.elements";

/// Identity of this description: it changes with any change of it.
pub fn instantiation_token() -> &'static str {
    static TOKEN: LazyLock<String> = LazyLock::new(|| braced(&hash_128(document("").as_bytes())));
    &TOKEN
}

/// `modelDescription.xml`.
pub fn xml() -> String {
    document(instantiation_token())
}

fn document(token: &str) -> String {
    super::document(|x| root(x, [("fmiVersion", VERSION), ("instantiationToken", token)], write))
}

fn write(x: &mut Xml) -> io::Result<()> {
    x.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", MODEL_IDENTIFIER),
            ("canGetAndSetFMUState", "true"),
            ("canSerializeFMUState", "true"),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("providesIntermediateUpdate", "true"),
            ("mightReturnEarlyFromDoStep", "true"),
            ("canReturnEarlyAfterIntermediateUpdate", "true"),
            ("hasEventMode", "true"),
        ])
        .write_empty()?;
    x.create_element("UnitDefinitions").write_inner_content(unit_definitions)?;
    x.create_element("TypeDefinitions").write_inner_content(|x| {
        for enumeration in enumerations(table()) {
            let definition = x.create_element("EnumerationType").with_attribute(("name", enumeration.name));
            definition.write_inner_content(|x| items(x, enumeration))?;
        }
        Ok(())
    })?;
    log_categories(x)?;
    default_experiment(x)?;
    x.create_element("ModelVariables")
        .write_inner_content(|x| Port::all().try_for_each(|port| variable(x, port)))?;
    x.create_element("ModelStructure").write_inner_content(model_structure)?;
    Ok(())
}

fn variable(x: &mut Xml, port: Port) -> io::Result<()> {
    let (role, initial) = match port {
        Port::Time => ("independent", None),
        Port::Points => ("structuralParameter", Some("exact")),
        _ => causality(port.causality()),
    };
    let (name, reference) = (port.name(), port.reference().to_string());
    let head = [
        ("name", name.as_str()),
        ("valueReference", &reference),
        ("causality", role),
        ("variability", variability(port.variability())),
    ];
    let mut attributes = attributes(port);
    if port.is_intermediate() {
        attributes.push(("intermediateUpdate", "true".to_owned()));
    }
    // A calculated value and the time have no start.
    let start = start(port).filter(|_| initial != Some("calculated") && port != Port::Time);
    let is_text = port.base_type() == BaseType::String;
    attributes.extend(start.clone().filter(|_| !is_text).map(|start| ("start", start)));
    let element = x
        .create_element(port.base_type().name())
        .with_attributes(head)
        .with_attributes(initial.map(|initial| ("initial", initial)))
        .with_attributes(attributes.iter().map(|(name, value)| (*name, value.as_str())))
        .new_line()
        .with_attribute(("description", port.description().as_str()));
    let text_start = start.filter(|_| is_text);
    if !port.is_array() && text_start.is_none() {
        element.write_empty()?;
        return Ok(());
    }
    element.write_inner_content(|x| {
        if port.is_array() && port.variable().is_some() {
            elements(x, port)?;
        }
        for size in port.shape() {
            empty(x, "Dimension", &vec![("start", size.to_string())])?;
        }
        if port.is_history() {
            empty(x, "Dimension", &vec![("valueReference", Port::Points.reference().to_string())])?;
        }
        text_start.iter().try_for_each(|start| empty(x, "Start", &vec![("value", start.clone())]))
    })?;
    Ok(())
}

/// Names of an array's elements.
fn elements(x: &mut Xml, port: Port) -> io::Result<()> {
    let names: Vec<&str> = port.rows().filter_map(|row| Some(table().get(row as usize)?.name)).collect();
    x.create_element("Annotations").write_inner_content(|x| {
        let annotation = x.create_element("Annotation").with_attribute(("type", ELEMENTS));
        annotation.write_text_content(BytesText::new(&names.join(" ")))?;
        Ok(())
    })?;
    Ok(())
}

/// Unit, range, type.
fn attributes(port: Port) -> Attributes {
    let history = |unit| real(unit, None, unit.nominal);
    match (port, port.variable().map(|variable| (variable, variable.kind))) {
        (Port::Time | Port::HistoryTime, _) => history(&SECOND),
        (Port::HistoryDisplacement, _) => history(&METRE),
        (Port::Points, _) => range(Some(POINTS_RANGE)),
        // Its columns have units of their own.
        (Port::Sensitivities, _) => Vec::new(),
        (_, Some((variable, Kind::Real { unit, range }))) => real(unit, range, variable.nominal()),
        (_, Some((_, Kind::Integer { range: bounds }))) => range(bounds),
        (_, Some((_, Kind::Enumeration(e)))) => {
            let declared = vec![("declaredType", e.name.to_owned())];
            [declared, range(Some((1, e.items.len())))].concat()
        }
        (_, Some((_, Kind::Boolean | Kind::Text)) | None) => Vec::new(),
    }
}

/// Start values, those of an array one after the other.
fn start(port: Port) -> Option<String> {
    let mut values: Vec<Value> = Vec::new();
    port.read(&Settings::default(), &Readings::default(), 0.0, &mut values);
    let texts: Vec<String> = values.into_iter().map(text).collect();
    (!texts.is_empty()).then(|| texts.join(" "))
}

/// Outputs are those of the last step: at the same instant they depend on no input.
fn model_structure(x: &mut Xml) -> io::Result<()> {
    let outputs = || Port::all().filter(|&port| port.causality() == Causality::Output && port != Port::Time);
    let unknown = |x: &mut Xml, name: &str, port: Port, dependencies: String| {
        let attributes =
            vec![("valueReference", port.reference().to_string()), ("dependencies", dependencies)];
        empty(x, name, &attributes)
    };
    outputs().try_for_each(|port| unknown(x, "Output", port, String::new()))?;
    outputs().try_for_each(|port| {
        let known = INITIAL_DEPENDENCIES.iter().find(|(name, _)| *name == port.name());
        let known = known.iter().flat_map(|(_, names)| names.iter().copied());
        let history = Port::HistoryDisplacement.name();
        let history = known.clone().next().map(|_| [POINTS, history.as_str()]).into_iter().flatten();
        // The integer twins are not there.
        let ports = known.chain(history).filter_map(Port::by_name);
        let mut references: Vec<u32> = ports.map(Port::reference).collect();
        references.sort_unstable();
        let references: Vec<String> = references.iter().map(u32::to_string).collect();
        unknown(x, "InitialUnknown", port, references.join(" "))
    })
}

/// `terminalsAndIcons/terminalsAndIcons.xml`: the punch as one thing to connect, and the icon.
pub fn terminals() -> String {
    super::document(|x| {
        let root = x.create_element("fmiTerminalsAndIcons").with_attribute(("fmiVersion", VERSION));
        root.write_inner_content(|x| {
            x.create_element("GraphicalRepresentation").write_inner_content(|x| {
                let half = (f64::from(ICON_SIZE) / 2.0).to_string();
                let low = format!("-{half}");
                let corners = || {
                    vec![("x1", low.clone()), ("y1", low.clone()), ("x2", half.clone()), ("y2", half.clone())]
                };
                let scale = vec![("suggestedScalingFactorTo_mm", "0.2".to_owned())];
                empty(x, "CoordinateSystem", &[corners(), scale].concat())?;
                empty(x, "Icon", &corners())
            })?;
            x.create_element("Terminals").write_inner_content(|x| {
                let terminal = x.create_element("Terminal").with_attributes([
                    ("name", "punch"),
                    ("matchingRule", "bus"),
                    ("description", "The punch: where it is to go, how fast, where it is, the force on it"),
                ]);
                terminal.write_inner_content(|x| {
                    PUNCH.iter().try_for_each(|(variable, member)| {
                        let names =
                            [("variableName", *variable), ("memberName", member), ("variableKind", "signal")];
                        x.create_element("TerminalMemberVariable").with_attributes(names).write_empty()?;
                        Ok(())
                    })
                })?;
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_connect_variables() {
        for (variable, _) in PUNCH {
            assert!(Port::by_name(variable).is_some(), "{variable}");
        }
    }
}
