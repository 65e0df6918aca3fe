//! `modelDescription.xml` (FMI 2.0 co-simulation), written from the variable table.

use crate::hash::fnv1a_128;
use crate::motion::protocol::Trapezoid;
use crate::variables::{Causality, Enumeration, Kind, Value, Variability, Variable, table, units};
use std::fmt::Write as _;
use std::sync::LazyLock;

/// Name of the model and of the binary inside the archive.
pub const MODEL_IDENTIFIER: &str = "poropunch";

/// Log category of failures, with what it tells.
pub const LOG_ERROR: (&str, &str) = ("logStatusError", "Why a call failed");
/// Log category of the life cycle and solver, with what it tells.
pub const LOG_EVENTS: (&str, &str) = ("logEvents", "Life cycle and solver statistics of each step");

/// GUID of this variable table and version: it changes with any change of the description.
pub fn guid() -> &'static str {
    static GUID: LazyLock<String> = LazyLock::new(|| {
        let hex = format!("{:032x}", guid_number());
        let parts = [&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]];
        format!("{{{}}}", parts.join("-"))
    });
    &GUID
}

/// The GUID as a number, for saved states.
pub(crate) fn guid_number() -> u128 {
    static NUMBER: LazyLock<u128> = LazyLock::new(|| fnv1a_128(document("").as_bytes()));
    *NUMBER
}

/// The whole document.
pub fn xml() -> String {
    document(guid())
}

fn document(guid: &str) -> String {
    let stop = Trapezoid::default().end_of_first_hold();
    let version = env!("CARGO_PKG_VERSION");
    let mut x = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    x += &format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{MODEL_IDENTIFIER}\" guid=\"{guid}\"\n    \
         description=\"Flat punch pressed into a poro-viscoelastic, water-saturated sample\"\n    \
         author=\"the poropunch authors\" version=\"{version}\" license=\"MIT OR Apache-2.0\"\n    \
         generationTool=\"poropunch {version}\" variableNamingConvention=\"structured\">\n"
    );
    x += &format!(
        "  <CoSimulation modelIdentifier=\"{MODEL_IDENTIFIER}\" canHandleVariableCommunicationStepSize=\"true\"\n    \
         canInterpolateInputs=\"true\" canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"\n    \
         canNotUseMemoryManagementFunctions=\"true\"/>\n"
    );
    unit_definitions(&mut x);
    type_definitions(&mut x);
    x += "  <LogCategories>\n";
    for (name, description) in [LOG_EVENTS, LOG_ERROR] {
        x += &format!("    <Category name=\"{name}\" description=\"{description}\"/>\n");
    }
    x += "  </LogCategories>\n";
    x += &format!("  <DefaultExperiment startTime=\"0.0\" stopTime=\"{stop:?}\" stepSize=\"0.1\"/>\n");
    x += "  <ModelVariables>\n";
    for (reference, variable) in table().iter().enumerate() {
        scalar_variable(&mut x, reference, variable);
    }
    x += "  </ModelVariables>\n";
    model_structure(&mut x);
    x += "</fmiModelDescription>\n";
    x
}

fn unit_definitions(x: &mut String) {
    *x += "  <UnitDefinitions>\n";
    for unit in units::ALL {
        let (kg, m, s) = unit.exponents;
        let base: String = [("kg", kg), ("m", m), ("s", s)]
            .iter()
            .filter(|(_, exponent)| *exponent != 0)
            .map(|(name, exponent)| format!(" {name}=\"{exponent}\""))
            .collect();
        *x += &format!(
            "    <Unit name=\"{}\"><BaseUnit{base}/><DisplayUnit name=\"{}\" factor=\"{:?}\"/></Unit>\n",
            unit.symbol, unit.display, unit.factor
        );
    }
    *x += "  </UnitDefinitions>\n";
}

fn type_definitions(x: &mut String) {
    let mut written: Vec<&Enumeration> = Vec::new();
    *x += "  <TypeDefinitions>\n";
    for variable in table() {
        let Kind::Enumeration(enumeration) = variable.kind else { continue };
        if written.contains(&enumeration) {
            continue;
        }
        written.push(enumeration);
        *x += &format!("    <SimpleType name=\"{}\">\n      <Enumeration>\n", enumeration.name);
        for ((name, description), value) in enumeration.items.iter().zip(1..) {
            let description = escape(description);
            *x +=
                &format!("        <Item name=\"{name}\" value=\"{value}\" description=\"{description}\"/>\n");
        }
        *x += "      </Enumeration>\n    </SimpleType>\n";
    }
    *x += "  </TypeDefinitions>\n";
}

fn scalar_variable(x: &mut String, reference: usize, variable: &Variable) {
    let (causality, initial) = match variable.causality {
        Causality::Parameter => ("parameter", " initial=\"exact\""),
        Causality::Input => ("input", ""),
        Causality::Output => ("output", " initial=\"calculated\""),
    };
    let variability = match variable.variability {
        Variability::Fixed => "fixed",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    };
    let start = match (variable.causality, variable.start()) {
        (Causality::Output, _) => String::new(),
        (_, Value::Real(v)) => format!(" start=\"{v:?}\""),
        (_, Value::Integer(v)) => format!(" start=\"{v}\""),
        (_, Value::Boolean(v)) => format!(" start=\"{v}\""),
        (_, Value::Text(v)) => format!(" start=\"{}\"", escape(&v)),
    };
    let kind = match variable.kind {
        Kind::Real { unit, range } => {
            let range =
                range.map(|(min, max)| format!(" min=\"{min:?}\" max=\"{max:?}\"")).unwrap_or_default();
            format!("Real unit=\"{}\" displayUnit=\"{}\"{range}{start}", unit.symbol, unit.display)
        }
        Kind::Integer { range } => {
            let range = range.map(|(min, max)| format!(" min=\"{min}\" max=\"{max}\"")).unwrap_or_default();
            format!("Integer{range}{start}")
        }
        Kind::Boolean => format!("Boolean{start}"),
        Kind::Text => format!("String{start}"),
        Kind::Enumeration(e) => {
            format!("Enumeration declaredType=\"{}\" min=\"1\" max=\"{}\"{start}", e.name, e.items.len())
        }
    };
    *x += &format!(
        "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" causality=\"{causality}\" \
         variability=\"{variability}\"{initial}\n      description=\"{}\">\n      <{kind}/>\n    </ScalarVariable>\n",
        escape(variable.name),
        escape(variable.description),
    );
}

fn model_structure(x: &mut String) {
    // Indices count from 1; the table's order makes them ascending.
    let outputs: Vec<usize> =
        (1..).zip(table()).filter(|(_, v)| v.causality == Causality::Output).map(|(i, _)| i).collect();
    *x += "  <ModelStructure>\n";
    for section in ["Outputs", "InitialUnknowns"] {
        *x += &format!("    <{section}>\n");
        for index in &outputs {
            // Writing to a String cannot fail.
            let _ = writeln!(x, "      <Unknown index=\"{index}\"/>");
        }
        *x += &format!("    </{section}>\n");
    }
    *x += "  </ModelStructure>\n";
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    #[test]
    fn committed_file_is_fresh() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../modelDescription.xml");
        let committed = std::fs::read_to_string(path).unwrap_or_default();
        assert!(
            committed == super::xml(),
            "modelDescription.xml is stale: run `cargo run --release -p poropunch --example model_description \
             > modelDescription.xml`"
        );
    }
}
