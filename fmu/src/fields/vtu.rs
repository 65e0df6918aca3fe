//! VTK's XML formats: one frame as an unstructured grid (.vtu), a series as a collection (.pvd).
//!
//! Written here because the only crate for it, vtkio, has had no stable release since 2021. Arrays are base64, each
//! with its length before it: what every reader of VTK's files knows.

use super::{Field, Fields};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write as _;

/// VTK's number of the biquadratic quadrilateral.
const BIQUADRATIC_QUAD: u8 = 28;

/// A frame at `time` (s).
pub(super) fn frame(fields: &Fields, time: f64) -> String {
    let mut x = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n",
    );
    array(&mut x, "Float64", "TimeValue", " NumberOfTuples=\"1\"", bytes(&[time], f64::to_le_bytes));
    x += "</FieldData>\n";
    // Writing to a String cannot fail.
    let (points, cells) = (fields.points.len(), fields.cells.len());
    let _ = writeln!(x, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
    for (section, data) in [("PointData", &fields.point_data), ("CellData", &fields.cell_data)] {
        let _ = writeln!(x, "<{section}>");
        data.iter().for_each(|field| field_array(&mut x, field));
        let _ = writeln!(x, "</{section}>");
    }
    x += "<Points>\n";
    let coordinates = bytes(fields.points.as_flattened(), f64::to_le_bytes);
    array(&mut x, "Float64", "points", " NumberOfComponents=\"3\"", coordinates);
    x += "</Points>\n<Cells>\n";
    let nodes: Vec<i64> = fields.cells.as_flattened().iter().map(|&node| i64::from(node)).collect();
    array(&mut x, "Int64", "connectivity", "", bytes(&nodes, i64::to_le_bytes));
    let ends: Vec<i64> = (1..).map(|n: i64| n * crate::mesh::NODES as i64).take(cells).collect();
    array(&mut x, "Int64", "offsets", "", bytes(&ends, i64::to_le_bytes));
    array(&mut x, "UInt8", "types", "", vec![BIQUADRATIC_QUAD; cells]);
    x += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    x
}

/// A series of frames: times (s) and files relative to the collection's folder.
pub(super) fn collection<'a>(frames: impl Iterator<Item = (f64, &'a str)>) -> String {
    let mut x = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
         <Collection>\n",
    );
    for (time, file) in frames {
        let file =
            file.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
        let _ = writeln!(x, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>");
    }
    x += "</Collection>\n</VTKFile>\n";
    x
}

fn field_array(x: &mut String, field: &Field) {
    let components = field.quantity.components;
    let mut attributes = String::new();
    // Readers take a scalar for a list of one-vectors where its number of components is given.
    if components.len() > 1 {
        let _ = write!(attributes, " NumberOfComponents=\"{}\"", components.len());
        for (k, name) in components.iter().enumerate() {
            let _ = write!(attributes, " ComponentName{k}=\"{name}\"");
        }
    }
    array(x, "Float64", field.quantity.name, &attributes, bytes(&field.values, f64::to_le_bytes));
}

fn bytes<T: Copy, const N: usize>(values: &[T], of: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&value| of(value)).collect()
}

fn array(x: &mut String, kind: &str, name: &str, attributes: &str, bytes: Vec<u8>) {
    let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
    block.extend(bytes);
    let _ = write!(x, "<DataArray type=\"{kind}\" Name=\"{name}\"{attributes} format=\"binary\">");
    STANDARD.encode_string(block, x);
    x.push_str("</DataArray>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_their_length_and_their_values() {
        let mut x = String::new();
        array(&mut x, "Float64", "n", "", bytes(&[1.0, -2.5], f64::to_le_bytes));
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
