//! `modelDescription.xml`, read.

use super::FmiError;
use super::description3::variables3;
use super::places::Places;
use roxmltree::{Document, Node};

/// Version of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// What an FMU says about itself.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDescription {
    /// Version of FMI.
    pub version: Version,
    /// Name of the model.
    pub model_name: String,
    /// Name of the binary, without extension.
    pub model_identifier: String,
    /// Identity that binary and description must share: GUID or instantiation token.
    pub guid: String,
    /// Variables in the order of the file; every element of an array is one.
    pub variables: Vec<ScalarVariable>,
    /// What the binary can do.
    pub capabilities: Capabilities,
    /// Suggested experiment.
    pub default_experiment: DefaultExperiment,
    /// Where the variables of FMI 3.0 are.
    pub(super) places: Places,
}

/// Type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VariableKind {
    /// `Real`.
    Real,
    /// `Integer`.
    Integer,
    /// `Boolean`.
    Boolean,
    /// `String`.
    String,
    /// `Enumeration`: set and got as an integer.
    Enumeration,
}

/// One variable.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarVariable {
    /// Name.
    pub name: String,
    /// Value reference.
    pub value_reference: u32,
    /// Type.
    pub kind: VariableKind,
    /// `parameter`, `input`, `output`, `local`, ...
    pub causality: String,
    /// `fixed`, `tunable`, `discrete`, `continuous`, ...
    pub variability: String,
    /// Start value as written.
    pub start: Option<String>,
    /// Values that it may have.
    pub range: Range,
    /// Unit of the value.
    pub unit: Option<String>,
    /// Unit for people.
    pub display_unit: Option<String>,
    /// Value in `display_unit` of 1 `unit`; 1 where there is none.
    pub display_factor: f64,
    /// Items of an enumeration: name, value.
    pub items: Vec<(String, i32)>,
    /// Description.
    pub description: String,
}

/// Values between two, which are infinite where none is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl Range {
    /// Whether it holds a value.
    pub fn contains(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }

    /// Of the attributes of a declaration, as `attribute` finds them.
    pub(super) fn declared<'a>(
        node: Node,
        attribute: impl Fn(&'static str) -> Option<&'a str>,
    ) -> Result<Self, FmiError> {
        let end = |name, none| attribute(name).map_or(Ok(none), |text| parse(node, name, text));
        Ok(Self { min: end("min", f64::NEG_INFINITY)?, max: end("max", f64::INFINITY)? })
    }
}

impl ScalarVariable {
    /// The start value as a number, where it is one (Booleans: 0 or 1).
    pub fn start_number(&self) -> Option<f64> {
        match self.start.as_deref()? {
            "true" => Some(1.0),
            "false" => Some(0.0),
            text => text.parse().ok(),
        }
    }
}

/// What the binary can do, of what this program cares for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// Steps may differ in size.
    pub variable_step_size: bool,
    /// Takes derivatives of inputs.
    pub interpolate_inputs: bool,
    /// State can be got and set.
    pub get_and_set_state: bool,
    /// State can be serialised.
    pub serialize_state: bool,
    /// At most one instance per process.
    pub only_once_per_process: bool,
}

/// Suggested experiment.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DefaultExperiment {
    /// Start (s).
    pub start_time: Option<f64>,
    /// Stop (s).
    pub stop_time: Option<f64>,
    /// Step (s).
    pub step_size: Option<f64>,
}

impl ModelDescription {
    /// Reads the document.
    ///
    /// # Errors
    /// When it is not XML, not FMI 2.0 or 3, not co-simulation, or an attribute is missing or no number.
    pub fn parse(xml: &str) -> Result<Self, FmiError> {
        let document = Document::parse(xml)
            .map_err(|e| FmiError::BadDescription { line: e.pos().row, reason: e.to_string() })?;
        let root = document.root_element();
        if root.tag_name().name() != "fmiModelDescription" {
            return Err(bad(root, "the root element is not fmiModelDescription"));
        }
        let version = match required(root, "fmiVersion")? {
            version if version == "2.0" => Version::Two,
            // Minor versions of FMI 3 only add to it.
            version if version.starts_with("3.") => Version::Three,
            found => return Err(FmiError::Version { found }),
        };
        let co_simulation = child(root, "CoSimulation").ok_or(FmiError::NoCoSimulation)?;
        let flag = |name: &str| matches!(co_simulation.attribute(name), Some("true" | "1"));
        let (token, state) = match version {
            Version::Two => ("guid", "FMUstate"),
            Version::Three => ("instantiationToken", "FMUState"),
        };
        let capabilities = Capabilities {
            variable_step_size: flag("canHandleVariableCommunicationStepSize"),
            // FMI 3.0 has no derivatives of inputs.
            interpolate_inputs: version == Version::Two && flag("canInterpolateInputs"),
            get_and_set_state: flag(&format!("canGetAndSet{state}")),
            serialize_state: flag(&format!("canSerialize{state}")),
            only_once_per_process: flag("canBeInstantiatedOnlyOncePerProcess"),
        };
        let declared =
            child(root, "ModelVariables").ok_or_else(|| bad(root, "there is no ModelVariables"))?;
        let (variables, places) = match version {
            Version::Two => (scalar_variables(root, declared)?, Places::default()),
            Version::Three => variables3(root, declared)?,
        };
        Ok(Self {
            version,
            model_name: required(root, "modelName")?,
            model_identifier: required(co_simulation, "modelIdentifier")?,
            guid: required(root, token)?,
            variables,
            capabilities,
            default_experiment: default_experiment(root)?,
            places,
        })
    }

    /// Variable called `name`.
    ///
    /// # Errors
    /// When there is none.
    pub fn variable(&self, name: &str) -> Result<&ScalarVariable, FmiError> {
        let found = self.variables.iter().find(|variable| variable.name == name);
        found.ok_or_else(|| FmiError::UnknownVariable(name.to_owned()))
    }
}

fn default_experiment(root: Node) -> Result<DefaultExperiment, FmiError> {
    let Some(node) = child(root, "DefaultExperiment") else { return Ok(DefaultExperiment::default()) };
    Ok(DefaultExperiment {
        start_time: number(node, "startTime")?,
        stop_time: number(node, "stopTime")?,
        step_size: number(node, "stepSize")?,
    })
}

fn scalar_variables(root: Node, declared: Node) -> Result<Vec<ScalarVariable>, FmiError> {
    let nodes = declared.children().filter(|node| node.has_tag_name("ScalarVariable"));
    nodes.map(|node| scalar_variable(root, node)).collect()
}

fn scalar_variable(root: Node, node: Node) -> Result<ScalarVariable, FmiError> {
    let (kind, typed) = node
        .children()
        .find_map(|child| {
            let kind = match child.tag_name().name() {
                "Real" => VariableKind::Real,
                "Integer" => VariableKind::Integer,
                "Boolean" => VariableKind::Boolean,
                "String" => VariableKind::String,
                "Enumeration" => VariableKind::Enumeration,
                _ => return None,
            };
            Some((kind, child))
        })
        .ok_or_else(|| bad(node, "a ScalarVariable without a type"))?;
    let declared = typed.attribute("declaredType").and_then(|name| simple_type(root, name));
    let attribute = |name| typed.attribute(name).or_else(|| declared.and_then(|d| d.attribute(name)));
    let reference = required(node, "valueReference")?;
    let unit = attribute("unit").map(str::to_owned);
    let display_unit = attribute("displayUnit").map(str::to_owned);
    let display_factor = match (&unit, &display_unit) {
        (Some(unit), Some(display)) => display_factor(root, unit, display)?,
        _ => 1.0,
    };
    let items = declared.map(items).transpose()?.unwrap_or_default();
    Ok(ScalarVariable {
        name: required(node, "name")?,
        value_reference: reference.parse().map_err(|_| bad(node, "valueReference is not a number"))?,
        kind,
        causality: node.attribute("causality").unwrap_or("local").to_owned(),
        variability: node.attribute("variability").unwrap_or("continuous").to_owned(),
        start: typed.attribute("start").map(str::to_owned),
        range: Range::declared(typed, attribute)?,
        unit,
        display_unit,
        display_factor,
        items,
        description: node.attribute("description").unwrap_or_default().to_owned(),
    })
}

/// The typed element inside a SimpleType.
fn simple_type<'a>(root: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    let types = child(root, "TypeDefinitions")?;
    let found = types.children().find(|node| node.attribute("name") == Some(name))?;
    found.children().find(Node::is_element)
}

pub(super) fn items(enumeration: Node) -> Result<Vec<(String, i32)>, FmiError> {
    let nodes = enumeration.children().filter(|node| node.has_tag_name("Item"));
    let item = |node: Node| {
        let value = required(node, "value")?;
        Ok((
            required(node, "name")?,
            value.parse().map_err(|_| bad(node, "an item's value is not a number"))?,
        ))
    };
    nodes.map(item).collect()
}

pub(super) fn display_factor(root: Node, unit: &str, display: &str) -> Result<f64, FmiError> {
    let units = child(root, "UnitDefinitions").into_iter().flat_map(|node| node.children());
    let displays = units
        .filter(|node| node.attribute("name") == Some(unit))
        .flat_map(|node| node.children().collect::<Vec<_>>())
        .find(|node| node.has_tag_name("DisplayUnit") && node.attribute("name") == Some(display));
    Ok(displays.map(|node| number(node, "factor")).transpose()?.flatten().unwrap_or(1.0))
}

pub(super) fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(name))
}

pub(super) fn required(node: Node, name: &str) -> Result<String, FmiError> {
    let value = node.attribute(name).map(str::to_owned);
    value.ok_or_else(|| bad(node, &format!("{} has no attribute {name}", node.tag_name().name())))
}

pub(super) fn number(node: Node, name: &str) -> Result<Option<f64>, FmiError> {
    node.attribute(name).map(|text| parse(node, name, text)).transpose()
}

fn parse(node: Node, name: &str, text: &str) -> Result<f64, FmiError> {
    text.trim().parse().map_err(|_| bad(node, &format!("{name}=\"{text}\" is not a number")))
}

pub(super) fn bad(node: Node, reason: &str) -> FmiError {
    let line = node.document().text_pos_at(node.range().start).row;
    FmiError::BadDescription { line, reason: reason.to_owned() }
}
