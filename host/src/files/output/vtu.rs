//! The deformed body for `ParaView` and similar programs: VTK XML, unstructured grid, ASCII.

use std::fmt::Write as _;

use chaincell_kernel::{Model, Stress};

use super::pressure::contact_pressure_pa;
use crate::engine::{Engine, Nodes, to_m};

/// VTK's cell types of a point, a line, a triangle and a tetrahedron.
const VERTEX: u8 = 1;
const LINE: u8 = 3;
const TRIANGLE: u8 = 5;
const TETRAHEDRON: u8 = 10;

/// Returns a file with the nodes' positions as [`Engine::nodes`](crate::engine::Engine::nodes) gives them,
/// their displacement, input id, marks of fixed and of contact cells, the pressure of tools \[Pa\] if there are
/// any (`contact_pressure_pa`), and strain and stress of a body of nodal shapes (`stress_data`). The elements
/// are tetrahedra, or else surface triangles, or else links. A body that is cut has the copies of its split cells
/// behind the others, with the ids of the cells that were split, and its tetrahedra have those of their side.
#[must_use]
pub fn vtu(engine: &mut Engine<'_>, nodes: &Nodes) -> String {
    let (mut pressure_pa, cut) = (contact_pressure_pa(engine, nodes), engine.cut_cells());
    let with_copies = cut.as_ref().map(|cut| engine.with_copies(nodes, cut));
    let nodes = with_copies.as_ref().unwrap_or(nodes);
    // The forces are shared to the cells of the whole body.
    pressure_pa.iter_mut().for_each(|values| values.resize(nodes.ids.len(), 0.0));
    // Tissue has no embedded mesh: its points are its cells, the body's and the first of the spare ones.
    let copies = cut.as_ref().map_or(0, |cut| cut.origins.len());
    let stresses = engine.stresses(0..engine.network().model().body_cells() + copies);
    let (model, contacts) = (engine.network().model(), engine.contacts());
    let (fine, positions_m) = (model.fine_nodes() > 0, &nodes.positions_m);
    let elements = match &cut {
        Some(cut) => tetrahedra(&cut.tetrahedra),
        None if fine => fine_elements(model, &nodes.ids),
        None => elements(model),
    };
    let origins = cut.as_ref().map_or(&[][..], |cut| &cut.origins);
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" \
         byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n",
    );
    let (points, count) = (positions_m.len(), elements.corners.len() / elements.corners_each);
    let _ = writeln!(text, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{count}\">");
    text.push_str("<Points>\n");
    rows(&mut text, "position_m", positions_m.iter().copied());
    text.push_str("</Points>\n<Cells>\n");
    integers(&mut text, "connectivity", elements.corners.iter().copied());
    integers(&mut text, "offsets", (1..=count).map(|n| (n * elements.corners_each) as u32));
    integers(&mut text, "types", std::iter::repeat_n(u32::from(elements.kind), count));
    text.push_str("</Cells>\n<PointData Vectors=\"displacement_m\">\n");
    let pressure = pressure_pa
        .map(|values| PointArray { name: "contact_pressure_pa", values: Values::Numbers(values) });
    let stress = stresses.as_deref().map(stress_data).into_iter().flatten();
    let arrays =
        point_data(model, nodes, contacts, origins).into_iter().chain(pressure).chain(stress);
    arrays.for_each(|array| array.write(&mut text));
    text.push_str("</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    text
}

/// An array with a number or a vector at each point.
struct PointArray {
    name: &'static str,
    values: Values,
}

enum Values {
    Vectors(Vec<[f64; 3]>),
    Tensors(Vec<[f64; 6]>),
    Numbers(Vec<f64>),
    Integers(Vec<u32>),
}

impl PointArray {
    fn write(self, text: &mut String) {
        match self.values {
            Values::Vectors(values) => rows(text, self.name, values.into_iter()),
            Values::Tensors(values) => rows(text, self.name, values.into_iter()),
            Values::Numbers(values) => numbers(text, self.name, &values),
            Values::Integers(values) => integers(text, self.name, values.into_iter()),
        }
    }
}

/// Returns all arrays at the points, in the order of the nodes; the last ones are copies of the cells `origins`.
fn point_data(
    model: &Model<'_>,
    nodes: &Nodes,
    contacts: &[u16],
    origins: &[u16],
) -> Vec<PointArray> {
    let (fine, positions_m) = (model.fine_nodes() > 0, &nodes.positions_m);
    let body = positions_m.len() - origins.len();
    let cell_of = |point: usize| match point.checked_sub(body) {
        Some(copy) => origins.get(copy).copied().unwrap_or(u16::MAX),
        None => point as u16,
    };
    let rest_of = |point: usize| match nodes.ids.get(point) {
        Some(&id) if fine => model.fine_rest(id as usize).unwrap_or_default(),
        _ => model.rest_position(cell_of(point).into()),
    };
    let displacements = positions_m.iter().enumerate().map(|(point, position)| {
        let rest = to_m(model, rest_of(point).map(f64::from));
        std::array::from_fn(|axis| position[axis] - rest[axis])
    });
    let cells: Vec<u16> = if fine {
        nodes.ids.iter().map(|&id| model.cell_of_input(id).unwrap_or(u16::MAX)).collect()
    } else {
        (0..positions_m.len()).map(cell_of).collect()
    };
    let marks = |marked: &[u16]| -> Vec<u32> {
        cells.iter().map(|cell| marked.binary_search(cell).is_ok().into()).collect()
    };
    vec![
        PointArray { name: "displacement_m", values: Values::Vectors(displacements.collect()) },
        PointArray { name: "node", values: Values::Integers(nodes.ids.clone()) },
        PointArray { name: "fixed", values: Values::Integers(marks(model.fixed())) },
        PointArray { name: "contact", values: Values::Integers(marks(contacts)) },
    ]
}

/// Returns strain and stress at the points: the principal stretches, the largest first, the Cauchy stress, that after
/// von Mises, and the mean stress \[Pa\].
fn stress_data(stresses: &[Stress]) -> Vec<PointArray> {
    let of = |name, number: fn(&Stress) -> f32| {
        let numbers = stresses.iter().map(|stress| f64::from(number(stress))).collect();
        PointArray { name, values: Values::Numbers(numbers) }
    };
    let elements_pa = stresses.iter().map(|stress| stress.elements_pa().map(f64::from)).collect();
    let stretches = stresses.iter().map(|stress| stress.stretches.map(f64::from)).collect();
    vec![
        PointArray { name: "stretches", values: Values::Vectors(stretches) },
        PointArray { name: "stress_pa", values: Values::Tensors(elements_pa) },
        of("von_mises_pa", Stress::von_mises_pa),
        of("mean_stress_pa", Stress::mean_pa),
    ]
}

/// The elements with which a model is shown.
struct Elements {
    kind: u8,
    corners_each: usize,
    corners: Vec<u32>,
}

/// Returns the elements of the embedded mesh, or points if it has none.
fn fine_elements(model: &Model<'_>, ids: &[u32]) -> Elements {
    // Every id of an element is in the list.
    let point = |id: &u32| ids.binary_search(id).unwrap_or_default() as u32;
    let corners = |ids: &[u32]| -> Vec<u32> { ids.iter().map(point).collect() };
    if !model.fine_tetrahedra().is_empty() {
        let corners = corners(model.fine_tetrahedra().as_flattened());
        return Elements { kind: TETRAHEDRON, corners_each: 4, corners };
    }
    if !model.fine_triangles().is_empty() {
        let corners = corners(model.fine_triangles().as_flattened());
        return Elements { kind: TRIANGLE, corners_each: 3, corners };
    }
    Elements { kind: VERTEX, corners_each: 1, corners: (0..ids.len() as u32).collect() }
}

fn tetrahedra(cells: &[[u16; 4]]) -> Elements {
    Elements { kind: TETRAHEDRON, corners_each: 4, corners: wide(cells.as_flattened()) }
}

fn elements(model: &Model<'_>) -> Elements {
    if !model.tetrahedra().is_empty() {
        return tetrahedra(model.tetrahedra());
    }
    if !model.triangles().is_empty() {
        let corners = wide(model.triangles().as_flattened());
        return Elements { kind: TRIANGLE, corners_each: 3, corners };
    }
    let corners = (0..model.cells())
        .flat_map(|cell| model.row(cell).map(move |link| (cell, model.upper()[link])))
        .flat_map(|(cell, upper)| [cell as u32, upper.into()])
        .collect();
    Elements { kind: LINE, corners_each: 2, corners }
}

fn wide(cells: &[u16]) -> Vec<u32> {
    cells.iter().map(|&cell| cell.into()).collect()
}

/// An array with `N` numbers at each point.
fn rows<const N: usize>(text: &mut String, name: &str, values: impl Iterator<Item = [f64; N]>) {
    let _ = writeln!(
        text,
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{N}\" format=\"ascii\">"
    );
    for row in values {
        for (at, value) in row.into_iter().enumerate() {
            let _ = write!(text, "{}{value:.8e}", if at == 0 { "" } else { " " });
        }
        text.push('\n');
    }
    text.push_str("</DataArray>\n");
}

fn numbers(text: &mut String, name: &str, values: &[f64]) {
    let _ = writeln!(text, "<DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">");
    for value in values {
        let _ = writeln!(text, "{value:.8e}");
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
