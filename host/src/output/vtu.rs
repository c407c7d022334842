//! The deformed body for `ParaView` and the like: VTK XML, unstructured grid, ASCII.

use std::fmt::Write as _;

use chaincell_kernel::Model;

use crate::engine::to_m;

/// VTK's numbers for a line, a triangle and a tetrahedron.
const LINE: u8 = 3;
const TRIANGLE: u8 = 5;
const TETRAHEDRON: u8 = 10;

/// Positions \[m\] in the model's cell order, with displacement, input id and a mark on fixed and
/// on contact cells; drawn as tetrahedra, else as surface triangles, else as links.
#[must_use]
pub fn vtu(model: &Model<'_>, positions_m: &[[f64; 3]], contacts: &[u16]) -> String {
    let elements = elements(model);
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" \
         byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n",
    );
    let (points, cells) = (positions_m.len(), elements.corners.len() / elements.corners_each);
    let _ = writeln!(text, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
    text.push_str("<Points>\n");
    vectors(&mut text, "position_m", positions_m.iter().copied());
    text.push_str("</Points>\n<Cells>\n");
    integers(&mut text, "connectivity", elements.corners.iter().map(|&cell| cell.into()));
    integers(&mut text, "offsets", (1..=cells).map(|n| (n * elements.corners_each) as u32));
    integers(&mut text, "types", std::iter::repeat_n(u32::from(elements.kind), cells));
    text.push_str("</Cells>\n<PointData Vectors=\"displacement_m\">\n");
    let displacements = positions_m.iter().enumerate().map(|(cell, position)| {
        let rest = to_m(model, model.rest_position(cell).map(f64::from));
        std::array::from_fn(|axis| position[axis] - rest[axis])
    });
    vectors(&mut text, "displacement_m", displacements);
    integers(&mut text, "node", model.input_id().iter().copied());
    let marks = |marked: &[u16]| -> Vec<u32> {
        (0..points).map(|cell| marked.binary_search(&(cell as u16)).is_ok().into()).collect()
    };
    integers(&mut text, "fixed", marks(model.fixed()).into_iter());
    integers(&mut text, "contact", marks(contacts).into_iter());
    text.push_str("</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    text
}

/// The best drawing that a model carries.
struct Elements {
    kind: u8,
    corners_each: usize,
    corners: Vec<u16>,
}

fn elements(model: &Model<'_>) -> Elements {
    if !model.tetrahedra().is_empty() {
        let corners = model.tetrahedra().as_flattened().to_vec();
        return Elements { kind: TETRAHEDRON, corners_each: 4, corners };
    }
    if !model.triangles().is_empty() {
        let corners = model.triangles().as_flattened().to_vec();
        return Elements { kind: TRIANGLE, corners_each: 3, corners };
    }
    let corners = (0..model.cells())
        .flat_map(|cell| model.row(cell).flat_map(move |link| [cell as u16, model.upper()[link]]))
        .collect();
    Elements { kind: LINE, corners_each: 2, corners }
}

fn vectors(text: &mut String, name: &str, values: impl Iterator<Item = [f64; 3]>) {
    let _ = writeln!(
        text,
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"ascii\">"
    );
    for [x, y, z] in values {
        let _ = writeln!(text, "{x:.8e} {y:.8e} {z:.8e}");
    }
    text.push_str("</DataArray>\n");
}

fn integers(text: &mut String, name: &str, values: impl Iterator<Item = u32>) {
    let kind = if name == "types" { "UInt8" } else { "UInt32" };
    let _ = writeln!(text, "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">");
    for (at, value) in values.enumerate() {
        let _ = write!(text, "{value}{}", if at % 16 == 15 { '\n' } else { ' ' });
    }
    text.push_str("\n</DataArray>\n");
}
