//! Values of a model's parameters as an SSV file.

use super::unit::exponents;
use super::{SSC, SSV};
use crate::fmi::{ScalarVariable, VariableKind};
use crate::pool::Wiring;
use crate::units::Unit;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::collections::BTreeMap;
use std::io;

/// The parameter set `name`: values in the model's own units, so that importers that pass units by read it alike.
pub fn ssv(name: &str, wiring: &Wiring, values: &BTreeMap<String, f64>) -> String {
    let known = values.iter().filter_map(|(name, value)| Some((wiring.parameters.get(name)?, *value)));
    let known: Vec<(&ScalarVariable, f64)> = known.filter(|(v, _)| v.kind != VariableKind::String).collect();
    let mut x = Writer::new_with_indent(Vec::new(), b' ', 2);
    write(&mut x, name, &known).expect("writing to memory does not fail");
    String::from_utf8(x.into_inner()).expect("names and texts are UTF-8") + "\n"
}

type Xml = Writer<Vec<u8>>;

fn write(x: &mut Xml, name: &str, values: &[(&ScalarVariable, f64)]) -> io::Result<()> {
    x.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let root = x.create_element("ssv:ParameterSet").with_attributes([
        ("xmlns:ssv", SSV),
        ("xmlns:ssc", SSC),
        ("version", "1.0"),
        ("name", name),
        ("generationTool", concat!("poropunch ", env!("CARGO_PKG_VERSION"))),
    ]);
    root.write_inner_content(|x| {
        x.create_element("ssv:Parameters")
            .write_inner_content(|x| values.iter().try_for_each(|(v, value)| parameter(x, v, *value)))?;
        let units: BTreeMap<&str, Unit> = values.iter().filter_map(|(v, _)| unit(v)).collect();
        if units.is_empty() {
            return Ok(());
        }
        x.create_element("ssv:Units")
            .write_inner_content(|x| units.iter().try_for_each(|(name, unit)| definition(x, name, unit)))?;
        Ok(())
    })?;
    Ok(())
}

/// The unit by which a value is written, where it can be defined.
fn unit(variable: &ScalarVariable) -> Option<(&str, Unit)> {
    let name = variable.unit.as_deref().filter(|_| variable.kind == VariableKind::Real)?;
    Some((name, Unit::parse(name)?))
}

fn parameter(x: &mut Xml, variable: &ScalarVariable, value: f64) -> io::Result<()> {
    let item = || variable.items.iter().find(|(_, number)| f64::from(*number) == value);
    let (kind, text) = match variable.kind {
        VariableKind::Boolean => ("ssv:Boolean", (value != 0.0).to_string()),
        VariableKind::Integer => ("ssv:Integer", format!("{value}")),
        VariableKind::Enumeration => {
            ("ssv:Enumeration", item().map_or_else(|| format!("{value}"), |(name, _)| name.clone()))
        }
        // Shortest digits that give the same number.
        VariableKind::Real | VariableKind::String => ("ssv:Real", format!("{value:?}")),
    };
    x.create_element("ssv:Parameter").with_attribute(("name", variable.name.as_str())).write_inner_content(
        |x| {
            let element = x.create_element(kind).with_attribute(("value", text.as_str()));
            match unit(variable) {
                Some((name, _)) => element.with_attribute(("unit", name)).write_empty()?,
                None => element.write_empty()?,
            };
            Ok(())
        },
    )?;
    Ok(())
}

fn definition(x: &mut Xml, name: &str, unit: &Unit) -> io::Result<()> {
    let (kg, m, s) = exponents(unit.dimension);
    let powers = [("kg", kg), ("m", m), ("s", s)].into_iter().filter(|(_, exponent)| *exponent != 0);
    let mut attributes: Vec<(&str, String)> = powers.map(|(name, e)| (name, e.to_string())).collect();
    if unit.factor != 1.0 {
        attributes.push(("factor", format!("{:?}", unit.factor)));
    }
    x.create_element("ssc:Unit").with_attribute(("name", name)).write_inner_content(|x| {
        let attributes = attributes.iter().map(|(name, value)| (*name, value.as_str()));
        x.create_element("ssc:BaseUnit").with_attributes(attributes).write_empty()?;
        Ok(())
    })?;
    Ok(())
}
