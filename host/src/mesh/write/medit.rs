//! Medit 2, ASCII: groups are reference numbers of tetrahedra, triangles of the surface, or vertices.
//!
//! Each element has one number. A group that shares its elements with another becomes one of vertices;
//! if its vertices have a number already, the mesh is refused.

use std::fmt::Write as _;

use super::carried::{Carried, Elements, carried, numbers, renamed};
use super::{Written, digits, line};
use crate::mesh::Mesh;

pub(super) fn write(mesh: &Mesh) -> Result<Written, String> {
    let groups = carried(mesh);
    let mut vertices = vec![0i64; mesh.nodes_m.len()];
    let mut tetrahedra = vec![0i64; mesh.tetrahedra.len()];
    let mut triangles = vec![0i64; mesh.triangles.len()];
    let mut notes = Vec::new();
    // Each group numbers its elements, else its vertices.
    for (Carried { name, elements }, number) in groups.iter().zip(numbers(&groups)) {
        let of_points = name.strip_prefix("points:").and_then(|number| number.parse().ok());
        let number = of_points.unwrap_or(number);
        let is_taken = match elements {
            Elements::Tetrahedra(all) if of_points.is_none() => claim(&mut tetrahedra, all, number),
            Elements::Triangles(all) if of_points.is_none() => claim(&mut triangles, all, number),
            _ => false,
        };
        if is_taken {
            notes.extend(renamed(name, &number.to_string()));
        } else if claim(&mut vertices, &mesh.groups[*name], number) {
            notes.extend(renamed(name, &format!("points:{number}")));
        } else {
            return Err(format!(
                "the group '{name}' shares elements and vertices with other groups, each of which has one \
                 number in a .mesh file; write .msh or .inp"
            ));
        }
    }
    // Vertices, triangles with a number, tetrahedra.
    let mut text = String::from("MeshVersionFormatted 2\nDimension\n3\n");
    let _ = writeln!(text, "Vertices\n{}", mesh.nodes_m.len());
    for (place, reference) in mesh.nodes_m.iter().zip(&vertices) {
        let [x, y, z] = place.map(digits);
        let _ = writeln!(text, "{x} {y} {z} {reference}");
    }
    let numbered = || mesh.triangles.iter().zip(&triangles).filter(|(_, number)| **number != 0);
    if numbered().count() > 0 {
        let _ = writeln!(text, "Triangles\n{}", numbered().count());
        numbered().for_each(|(ids, number)| element(&mut text, ids, *number));
    }
    let _ = writeln!(text, "Tetrahedra\n{}", mesh.tetrahedra.len());
    mesh.tetrahedra
        .iter()
        .zip(&tetrahedra)
        .for_each(|(ids, number)| element(&mut text, ids, *number));
    text.push_str("End\n");
    Ok(Written { text, notes })
}

/// Assigns a number to elements, unless one of them has a number. Returns true if it was assigned.
fn claim(numbers: &mut [i64], elements: &[u32], number: i64) -> bool {
    let is_free = elements.iter().all(|&element| numbers[element as usize] == 0);
    if is_free {
        elements.iter().for_each(|&element| numbers[element as usize] = number);
    }
    is_free
}

fn element(text: &mut String, ids: &[u32], number: i64) {
    line(text, ids.iter().map(|id| i64::from(id + 1)).chain([number]));
}
