//! `modelDescription.xml` of FMI 2.0 and 3.0 co-simulation, both written from the one variable table.

mod fmi2;
pub mod fmi3;

use crate::interface::hash::hash_128;
use crate::interface::variables::{Causality, Enumeration, Kind, Unit, Value, Variability, Variable, table};
use crate::motion::protocol::Trapezoid;
use crate::solver::parameters::SolverParameters;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;
use std::sync::LazyLock;

/// Name of the model and of the binary inside the archive.
pub const MODEL_IDENTIFIER: &str = "poropunch";

/// Log category of failures, with what it tells.
pub const LOG_ERROR: (&str, &str) = ("logStatusError", "Why a call failed");
/// Log category of the life cycle and solver, with what it tells.
pub const LOG_EVENTS: (&str, &str) = ("logEvents", "Life cycle and solver statistics of each step");

/// Step of the default experiment (s): the corner of the default protocol lies on this grid.
const DEFAULT_STEP: f64 = 0.0625;

/// What an output depends on in initialisation mode, where it is not a constant.
const INITIAL_DEPENDENCIES: [(&str, &[&str]); 2] = [
    (
        "punch_displacement",
        &["displacement", "protocol.source", "protocol.start_gap", "protocol.source_number"],
    ),
    (
        "indentation",
        &[
            "displacement",
            "protocol.source",
            "protocol.start_gap",
            "protocol.source_number",
            "effect.offset.height",
        ],
    ),
];

/// GUID of this variable table and version: it changes with any change of the description.
pub fn guid() -> &'static str {
    static GUID: LazyLock<String> = LazyLock::new(|| braced(guid_bytes()));
    &GUID
}

/// Bytes as a GUID is written.
fn braced(bytes: &[u8; 16]) -> String {
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    let parts = [&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]];
    format!("{{{}}}", parts.join("-"))
}

/// The GUID's bytes, for saved states.
pub(crate) fn guid_bytes() -> &'static [u8; 16] {
    static BYTES: LazyLock<[u8; 16]> = LazyLock::new(|| hash_128(fmi2::document("", table()).as_bytes()));
    &BYTES
}

/// The whole document of FMI 2.0; that of FMI 3.0 is [`fmi3::xml`].
pub fn xml() -> String {
    fmi2::document(guid(), table())
}

type Xml = Writer<Vec<u8>>;
/// Attributes of an element, in their order.
type Attributes = Vec<(&'static str, String)>;

/// A document that `write` writes.
fn document(write: impl FnOnce(&mut Xml) -> io::Result<()>) -> String {
    let mut x = Writer::new_with_indent(Vec::new(), b' ', 2);
    let declaration = Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None));
    x.write_event(declaration).and_then(|()| write(&mut x)).expect("writing to memory does not fail");
    String::from_utf8(x.into_inner()).expect("names and texts are UTF-8") + "\n"
}

/// The root element: what the model is.
fn root(
    x: &mut Xml,
    identity: [(&'static str, &str); 2],
    write: impl Fn(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    let [(version_name, fmi), (identity_name, identity)] = identity;
    let root = x.create_element("fmiModelDescription").with_attributes([
        (version_name, fmi),
        ("modelName", MODEL_IDENTIFIER),
        (identity_name, identity),
        ("description", "Flat punch pressed into a poro-viscoelastic, water-saturated sample"),
        ("author", "the poropunch authors"),
        ("version", version),
        ("license", "MIT OR Apache-2.0"),
        ("generationTool", &format!("poropunch {version}")),
        ("variableNamingConvention", "structured"),
    ]);
    root.write_inner_content(write)?;
    Ok(())
}

fn log_categories(x: &mut Xml) -> io::Result<()> {
    x.create_element("LogCategories").write_inner_content(|x| {
        for (name, description) in [LOG_EVENTS, LOG_ERROR] {
            let category = [("name", name), ("description", description)];
            x.create_element("Category").with_attributes(category).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Every enumeration of some variables once.
fn enumerations(variables: &[Variable]) -> Vec<&'static Enumeration> {
    let mut all: Vec<&Enumeration> = Vec::new();
    for variable in variables {
        if let Kind::Enumeration(enumeration) = variable.kind
            && !all.contains(&enumeration)
        {
            all.push(enumeration);
        }
    }
    all
}

fn items(x: &mut Xml, enumeration: &Enumeration) -> io::Result<()> {
    for ((name, description), value) in enumeration.items.iter().zip(1..) {
        let item = [("name", *name), ("value", &format!("{value}")), ("description", description)];
        x.create_element("Item").with_attributes(item).write_empty()?;
    }
    Ok(())
}

/// Role, and whether the start value is the value.
fn causality(causality: Causality) -> (&'static str, Option<&'static str>) {
    match causality {
        Causality::Parameter => ("parameter", Some("exact")),
        Causality::Input => ("input", None),
        Causality::Output => ("output", Some("calculated")),
    }
}

fn variability(variability: Variability) -> &'static str {
    match variability {
        Variability::Fixed => "fixed",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    }
}

fn range<T: std::fmt::Debug>(range: Option<(T, T)>) -> Attributes {
    range.map_or_else(Vec::new, |(min, max)| vec![("min", format!("{min:?}")), ("max", format!("{max:?}"))])
}

/// Unit, range and usual size of a Real.
fn real(unit: &Unit, bounds: Option<(f64, f64)>, nominal: f64) -> Attributes {
    let units = vec![("unit", unit.symbol.to_owned()), ("displayUnit", unit.display.to_owned())];
    [units, range(bounds), vec![("nominal", format!("{nominal:?}"))]].concat()
}

/// A value as XML writes it.
fn text(value: Value) -> String {
    match value {
        Value::Real(v) => format!("{v:?}"),
        Value::Integer(v) => v.to_string(),
        Value::Boolean(v) => v.to_string(),
        Value::Text(v) => v,
        Value::Count(v) => v.to_string(),
    }
}

fn empty(x: &mut Xml, name: &str, attributes: &Attributes) -> io::Result<()> {
    let attributes = attributes.iter().map(|(name, value)| (*name, value.as_str()));
    x.create_element(name).with_attributes(attributes).write_empty()?;
    Ok(())
}

fn default_experiment(x: &mut Xml) -> io::Result<()> {
    let attributes = vec![
        ("startTime", "0.0".to_owned()),
        ("stopTime", format!("{:?}", Trapezoid::default().end_of_first_hold())),
        ("tolerance", format!("{:?}", SolverParameters::default().tolerance)),
        ("stepSize", format!("{DEFAULT_STEP:?}")),
    ];
    empty(x, "DefaultExperiment", &attributes)
}

fn unit_definitions(x: &mut Xml) -> io::Result<()> {
    for unit in crate::unit::ALL {
        let (kg, m, s) = unit.exponents;
        let base = [("kg", kg), ("m", m), ("s", s), ("rad", unit.radians)];
        let base = base.into_iter().filter(|(_, exponent)| *exponent != 0);
        let base = base.map(|(name, exponent)| (name, exponent.to_string())).collect();
        let display = vec![("name", unit.display.to_owned()), ("factor", format!("{:?}", unit.factor))];
        x.create_element("Unit").with_attribute(("name", unit.symbol)).write_inner_content(|x| {
            empty(x, "BaseUnit", &base)?;
            empty(x, "DisplayUnit", &display)
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::cosimulation::Slave;
    use crate::interface::variables::by_name;

    #[test]
    fn the_guid_changes_with_the_table() {
        let hash = |table: &[Variable]| hash_128(fmi2::document("", table).as_bytes());
        let mut other = table().to_vec();
        assert_eq!(hash(&other), *guid_bytes());
        other[3].description = "another";
        assert_ne!(hash(&other), *guid_bytes());
        other = table().to_vec();
        other.swap(4, 5);
        assert_ne!(hash(&other), *guid_bytes());
    }

    /// Every settable variable is changed by itself; which outputs change before the first step?
    #[test]
    fn initial_dependencies_are_complete_and_true() {
        let outputs = || (0..).zip(table()).filter(|(_, v)| v.causality == Causality::Output);
        let read = |slave: &Slave| -> Vec<Value> { outputs().map(|(r, _)| slave.get(r).unwrap()).collect() };
        for inputs in [false, true] {
            let plain = || {
                let mut slave = Slave::new();
                let source = by_name("protocol.source").unwrap().0;
                slave.set(&[(source, Value::Integer(if inputs { 1 } else { 2 }))]).unwrap();
                slave
            };
            let before = read(&plain());
            for (reference, variable) in (0..).zip(table()) {
                if variable.causality == Causality::Output {
                    continue;
                }
                let changed = match (variable.kind, variable.start()) {
                    (Kind::Real { range: Some((min, max)), .. }, Value::Real(v)) => {
                        Value::Real(if v == 0.5 * (min + max) { max } else { 0.5 * (min + max) })
                    }
                    (Kind::Enumeration(_), Value::Integer(v)) => Value::Integer(3 - v.min(2)),
                    (Kind::Integer { .. }, Value::Integer(v)) => Value::Integer(v + 1),
                    (Kind::Boolean, Value::Boolean(v)) => Value::Boolean(!v),
                    _ => continue,
                };
                let mut slave = plain();
                slave.set(&[(reference, changed)]).unwrap();
                for (((_, output), old), new) in outputs().zip(&before).zip(read(&slave)) {
                    let listed = INITIAL_DEPENDENCIES
                        .iter()
                        .any(|(name, on)| *name == output.name && on.contains(&variable.name));
                    assert!(listed || *old == new, "{} depends on {}", output.name, variable.name);
                }
            }
        }
        for name in INITIAL_DEPENDENCIES.iter().flat_map(|(output, on)| on.iter().chain([output])) {
            assert!(by_name(name).is_some(), "{name}");
        }
    }

    #[test]
    fn the_corner_of_the_default_protocol_lies_on_the_default_grid() {
        for (time, _) in Trapezoid::default().first_hold().unwrap().points() {
            assert_eq!((time / DEFAULT_STEP).fract(), 0.0, "{time} s");
        }
    }

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
