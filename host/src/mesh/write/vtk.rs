//! Unstructured grids, legacy VTK 2.0 and XML, ASCII: groups are the numbers `group` of the cells.
//!
//! A tetrahedron has the number of one group. Groups that share tetrahedra with another, or that
//! triangles or points carry, have additional cells after the tetrahedra.

use std::fmt::Write as _;

use super::carried::{Carried, Elements, carried, numbers, renamed};
use super::{Written, digits, line};
use crate::mesh::Mesh;

/// VTK's numbers for a point, a triangle and a tetrahedron.
const KINDS: [(usize, u8); 3] = [(1, 1), (3, 5), (4, 10)];

/// The cells of a file.
struct Grid {
    cells: Vec<Vec<u32>>,
    groups: Vec<i64>,
    notes: Vec<String>,
}

impl Grid {
    fn new(mesh: &Mesh) -> Self {
        let mut cells: Vec<Vec<u32>> = mesh.tetrahedra.iter().map(|ids| ids.to_vec()).collect();
        let mut groups = vec![0; cells.len()];
        let carried = carried(mesh);
        let mut notes = Vec::new();
        for (Carried { name, elements }, number) in carried.iter().zip(numbers(&carried)) {
            notes.extend(renamed(name, &number.to_string()));
            match elements {
                Elements::Tetrahedra(all) if all.iter().all(|&at| groups[at as usize] == 0) => {
                    all.iter().for_each(|&at| groups[at as usize] = number);
                    continue;
                }
                Elements::Tetrahedra(_) => {
                    cells.extend(mesh.groups[*name].iter().map(|&node| vec![node]));
                }
                Elements::Triangles(all) => {
                    cells.extend(all.iter().map(|&at| mesh.triangles[at as usize].to_vec()));
                }
                Elements::Points(all) => cells.extend(all.iter().map(|&node| vec![node])),
            }
            groups.resize(cells.len(), number);
        }
        Self { cells, groups, notes }
    }

    fn types(&self) -> impl Iterator<Item = u8> {
        let kind = |cell: &Vec<u32>| KINDS.iter().find(|(nodes, _)| *nodes == cell.len());
        self.cells.iter().map(move |cell| kind(cell).map_or(0, |(_, kind)| *kind))
    }
}

pub(super) fn legacy(mesh: &Mesh) -> Result<Written, String> {
    let grid = Grid::new(mesh);
    let mut text =
        String::from("# vtk DataFile Version 2.0\nchaincell\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    let _ = writeln!(text, "POINTS {} double", mesh.nodes_m.len());
    mesh.nodes_m.iter().for_each(|place| line(&mut text, place.map(digits)));
    let (count, size) =
        (grid.cells.len(), grid.cells.iter().map(|cell| 1 + cell.len()).sum::<usize>());
    let _ = writeln!(text, "CELLS {count} {size}");
    for cell in &grid.cells {
        line(&mut text, std::iter::once(cell.len() as u32).chain(cell.iter().copied()));
    }
    let _ = writeln!(text, "CELL_TYPES {count}");
    grid.types().for_each(|kind| line(&mut text, [kind]));
    if !mesh.groups.is_empty() {
        let _ = writeln!(text, "CELL_DATA {count}\nSCALARS group int 1\nLOOKUP_TABLE default");
        grid.groups.iter().for_each(|group| line(&mut text, [group]));
    }
    Ok(Written { text, notes: grid.notes })
}

pub(super) fn xml(mesh: &Mesh) -> Result<Written, String> {
    let grid = Grid::new(mesh);
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" \
         byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n",
    );
    // Points.
    let (points, count) = (mesh.nodes_m.len(), grid.cells.len());
    let _ =
        writeln!(text, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{count}\">\n<Points>");
    text.push_str(
        "<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\">\n",
    );
    mesh.nodes_m.iter().for_each(|place| line(&mut text, place.map(digits)));
    text.push_str("</DataArray>\n</Points>\n<Cells>\n");
    // Cells: their nodes, the ends of their lists, their types.
    array(&mut text, "Int32", "connectivity", |text| {
        grid.cells.iter().for_each(|cell| line(text, cell));
    });
    array(&mut text, "Int32", "offsets", |text| {
        let mut end = 0;
        for cell in &grid.cells {
            end += cell.len();
            line(text, [end]);
        }
    });
    array(&mut text, "UInt8", "types", |text| grid.types().for_each(|kind| line(text, [kind])));
    text.push_str("</Cells>\n");
    // Groups.
    if !mesh.groups.is_empty() {
        text.push_str("<CellData Scalars=\"group\">\n");
        array(&mut text, "Int32", "group", |text| {
            grid.groups.iter().for_each(|group| line(text, [group]));
        });
        text.push_str("</CellData>\n");
    }
    text.push_str("</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    Ok(Written { text, notes: grid.notes })
}

fn array(text: &mut String, kind: &str, name: &str, fill: impl FnOnce(&mut String)) {
    let _ = writeln!(text, "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">");
    fill(text);
    text.push_str("</DataArray>\n");
}
