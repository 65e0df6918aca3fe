//! The document of FMI 2.0: every row of the table is a scalar variable.

use super::{
    INITIAL_DEPENDENCIES, MODEL_IDENTIFIER, Xml, causality, default_experiment, empty, enumerations, items,
    log_categories, range, real, root, text, unit_definitions, variability,
};
use crate::interface::variables::{Causality, Kind, Variable, by_name};
use std::io;

pub(super) fn document(guid: &str, variables: &[Variable]) -> String {
    super::document(|x| root(x, [("fmiVersion", "2.0"), ("guid", guid)], |x| write(x, variables)))
}

fn write(x: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    x.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", MODEL_IDENTIFIER),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canInterpolateInputs", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
            ("canNotUseMemoryManagementFunctions", "true"),
        ])
        .write_empty()?;
    x.create_element("UnitDefinitions").write_inner_content(unit_definitions)?;
    x.create_element("TypeDefinitions").write_inner_content(|x| type_definitions(x, variables))?;
    log_categories(x)?;
    default_experiment(x)?;
    x.create_element("ModelVariables").write_inner_content(|x| {
        (0_u32..).zip(variables).try_for_each(|(reference, v)| scalar_variable(x, reference, v))
    })?;
    x.create_element("ModelStructure").write_inner_content(|x| model_structure(x, variables))?;
    Ok(())
}

fn type_definitions(x: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    for enumeration in enumerations(variables) {
        let simple = x.create_element("SimpleType").with_attribute(("name", enumeration.name));
        simple.write_inner_content(|x| {
            x.create_element("Enumeration").write_inner_content(|x| items(x, enumeration))?;
            Ok(())
        })?;
    }
    Ok(())
}

fn scalar_variable(x: &mut Xml, reference: u32, variable: &Variable) -> io::Result<()> {
    let (causality, initial) = causality(variable.causality);
    let variability = variability(variable.variability);
    let reference = reference.to_string();
    x.create_element("ScalarVariable")
        .with_attributes([
            ("name", variable.name),
            ("valueReference", &reference),
            ("causality", causality),
            ("variability", variability),
        ])
        .with_attributes(initial.map(|initial| ("initial", initial)))
        .new_line()
        .with_attribute(("description", variable.description))
        .write_inner_content(|x| typed(x, variable))?;
    Ok(())
}

/// The element of the variable's type.
fn typed(x: &mut Xml, variable: &Variable) -> io::Result<()> {
    let (name, mut attributes) = match variable.kind {
        Kind::Real { unit, range } => ("Real", real(unit, range, variable.nominal())),
        Kind::Integer { range: bounds } => ("Integer", range(bounds)),
        Kind::Boolean => ("Boolean", Vec::new()),
        Kind::Text => ("String", Vec::new()),
        Kind::Enumeration(e) => {
            let declared = vec![("declaredType", e.name.to_owned())];
            ("Enumeration", [declared, range(Some((1, e.items.len())))].concat())
        }
    };
    if variable.causality != Causality::Output {
        attributes.push(("start", text(variable.start())));
    }
    empty(x, name, &attributes)
}

/// Outputs are those of the last step: at the same instant they depend on no input.
fn model_structure(x: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    // Indices count from 1; the table's order makes them ascending.
    let outputs = || (1..).zip(variables).filter(|(_, v)| v.causality == Causality::Output);
    let unknown = |x: &mut Xml, index: usize, dependencies: String| {
        empty(x, "Unknown", &vec![("index", index.to_string()), ("dependencies", dependencies)])
    };
    x.create_element("Outputs")
        .write_inner_content(|x| outputs().try_for_each(|(index, _)| unknown(x, index, String::new())))?;
    x.create_element("InitialUnknowns").write_inner_content(|x| {
        outputs().try_for_each(|(index, variable)| {
            let known = INITIAL_DEPENDENCIES.iter().find(|(name, _)| *name == variable.name);
            let mut indices: Vec<u32> = known
                .iter()
                .flat_map(|(_, names)| names.iter().filter_map(|name| by_name(name)))
                .map(|(reference, _)| reference + 1)
                .collect();
            indices.sort_unstable();
            let indices: Vec<String> = indices.iter().map(u32::to_string).collect();
            unknown(x, index, indices.join(" "))
        })
    })?;
    Ok(())
}
