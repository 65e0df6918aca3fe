//! VTK's XML formats: one frame as an unstructured grid (.vtu), a series as a collection (.pvd).
//!
//! The one crate for them, vtkio, has had no stable release since 2021, so the elements are named here. Arrays are base64, each
//! with its length before it: what every reader of VTK's files knows.

use crate::fields::{Field, Fields};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use quick_xml::Writer;
use quick_xml::events::BytesText;
use std::io;

/// VTK's number of the biquadratic quadrilateral.
const BIQUADRATIC_QUAD: u8 = 28;

type Xml = Writer<Vec<u8>>;

/// A frame at `time` (s).
pub(super) fn frame(fields: &Fields, time: f64) -> String {
    document("UnstructuredGrid", &[("version", "1.0"), ("header_type", "UInt64")], |x| {
        x.create_element("FieldData").write_inner_content(|x| {
            let single = [("NumberOfTuples", "1".to_owned())];
            array(x, "Float64", "TimeValue", single, bytes(&[time], f64::to_le_bytes))
        })?;
        let (points, cells) = (fields.points.len().to_string(), fields.cells.len().to_string());
        let piece = [("NumberOfPoints", points.as_str()), ("NumberOfCells", &cells)];
        x.create_element("Piece").with_attributes(piece).write_inner_content(|x| piece_of(x, fields))?;
        Ok(())
    })
}

fn piece_of(x: &mut Xml, fields: &Fields) -> io::Result<()> {
    for (section, data) in [("PointData", &fields.point_data), ("CellData", &fields.cell_data)] {
        x.create_element(section).write_inner_content(|x| data.iter().try_for_each(|f| field_array(x, f)))?;
    }
    x.create_element("Points").write_inner_content(|x| {
        let coordinates = bytes(fields.points.as_flattened(), f64::to_le_bytes);
        array(x, "Float64", "points", [("NumberOfComponents", "3".to_owned())], coordinates)
    })?;
    x.create_element("Cells").write_inner_content(|x| {
        let cells = fields.cells.len();
        let nodes: Vec<i64> = fields.cells.as_flattened().iter().map(|&node| i64::from(node)).collect();
        array(x, "Int64", "connectivity", [], bytes(&nodes, i64::to_le_bytes))?;
        let ends: Vec<i64> = (1..).map(|n: i64| n * crate::mesh::NODES as i64).take(cells).collect();
        array(x, "Int64", "offsets", [], bytes(&ends, i64::to_le_bytes))?;
        array(x, "UInt8", "types", [], vec![BIQUADRATIC_QUAD; cells])
    })?;
    Ok(())
}

/// A series of frames: times (s) and files relative to the collection's folder.
pub(super) fn collection<'a>(mut frames: impl Iterator<Item = (f64, &'a str)>) -> String {
    document("Collection", &[("version", "1.0")], |x| {
        frames.try_for_each(|(time, file)| {
            let time = format!("{time:?}");
            let attributes = [("timestep", time.as_str()), ("part", "0"), ("file", file)];
            x.create_element("DataSet").with_attributes(attributes).write_empty()?;
            Ok(())
        })
    })
}

/// A file with one element named `kind`.
fn document(
    kind: &str,
    attributes: &[(&str, &str)],
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> String {
    let mut x = Writer::new_with_indent(b"<?xml version=\"1.0\"?>\n".to_vec(), b' ', 0);
    let file = x.create_element("VTKFile").with_attributes([("type", kind), ("byte_order", "LittleEndian")]);
    file.with_attributes(attributes.iter().copied())
        .write_inner_content(|x| {
            x.create_element(kind).write_inner_content(content)?;
            Ok(())
        })
        .expect("writing to memory does not fail");
    String::from_utf8(x.into_inner()).expect("names and texts are UTF-8") + "\n"
}

fn field_array(x: &mut Xml, field: &Field) -> io::Result<()> {
    let components = field.quantity.components;
    let names: Vec<String> = (0..components.len()).map(|k| format!("ComponentName{k}")).collect();
    let count = [("NumberOfComponents", components.len().to_string())];
    let named = names.iter().zip(components).map(|(key, name)| (key.as_str(), (*name).to_owned()));
    // Readers take a scalar for a list of one-vectors where its number of components is given.
    let attributes = count.into_iter().chain(named).filter(|_| components.len() > 1);
    let values = bytes(&field.values, f64::to_le_bytes);
    array(x, "Float64", field.quantity.name, attributes, values)
}

fn bytes<T: Copy, const N: usize>(values: &[T], of: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&value| of(value)).collect()
}

fn array<'a>(
    x: &mut Xml,
    kind: &str,
    name: &str,
    attributes: impl IntoIterator<Item = (&'a str, String)>,
    bytes: Vec<u8>,
) -> io::Result<()> {
    let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
    block.extend(bytes);
    let mut element = x.create_element("DataArray").with_attributes([("type", kind), ("Name", name)]);
    for (key, value) in attributes {
        element = element.with_attribute((key, value.as_str()));
    }
    let text = STANDARD.encode(block);
    element.with_attribute(("format", "binary")).write_text_content(BytesText::from_escaped(text))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_their_length_and_their_values() {
        let mut x = Writer::new(Vec::new());
        array(&mut x, "Float64", "n", [], bytes(&[1.0, -2.5], f64::to_le_bytes)).unwrap();
        let x = String::from_utf8(x.into_inner()).unwrap();
        let text = x.split(['>', '<']).nth(2).unwrap();
        let block = STANDARD.decode(text).unwrap();
        assert_eq!(block[..8], 16_u64.to_le_bytes());
        assert_eq!(block[8..16], 1.0_f64.to_le_bytes());
        assert_eq!(block[16..], (-2.5_f64).to_le_bytes());
    }

    #[test]
    fn names_of_files_are_escaped() {
        let text = collection([(0.5, "a & \"b\"/x.vtu")].into_iter());
        assert!(text.contains("timestep=\"0.5\" part=\"0\" file=\"a &amp; &quot;b&quot;/x.vtu\""), "{text}");
    }
}
