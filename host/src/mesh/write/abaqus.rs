//! Abaqus input file: every group is a set of nodes, and also of elements if tetrahedra carry it.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::carried::{Elements, carried};
use super::{Written, digits};
use crate::mesh::Mesh;

/// Numbers of a set on a line.
const A_LINE: usize = 16;

pub(super) fn write(mesh: &Mesh) -> Result<Written, String> {
    // Names must differ without regard to case.
    let mut known: BTreeMap<String, &str> = BTreeMap::new();
    for name in mesh.groups.keys() {
        if name.contains(['"', '\n', '\r']) {
            return Err(format!("the group '{name}' has a quotation mark in its name"));
        }
        if let Some(other) = known.insert(name.to_ascii_uppercase(), name) {
            return Err(format!(
                "the groups '{other}' and '{name}' are one set in an .inp file, whose names know no upper \
                 and lower case; write .msh"
            ));
        }
    }
    // Nodes, elements and sets.
    let mut text = String::from("*HEADING\nchaincell\n*NODE\n");
    for (number, place) in (1..).zip(&mesh.nodes_m) {
        let [x, y, z] = place.map(digits);
        let _ = writeln!(text, "{number}, {x}, {y}, {z}");
    }
    text.push_str("*ELEMENT, TYPE=C3D4\n");
    for (number, ids) in (1..).zip(&mesh.tetrahedra) {
        let [a, b, c, d] = ids.map(|id| id + 1);
        let _ = writeln!(text, "{number}, {a}, {b}, {c}, {d}");
    }
    for (name, nodes) in &mesh.groups {
        set(&mut text, "NSET", name, nodes);
    }
    for group in carried(mesh) {
        if let Elements::Tetrahedra(all) = &group.elements {
            set(&mut text, "ELSET", group.name, all);
        }
    }
    Ok(Written { text, notes: Vec::new() })
}

fn set(text: &mut String, keyword: &str, name: &str, members: &[u32]) {
    // Some programs read quotation marks as a part of the name.
    let is_plain = name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let mark = if is_plain { "" } else { "\"" };
    let _ = writeln!(text, "*{keyword}, {keyword}={mark}{name}{mark}");
    for members in members.chunks(A_LINE) {
        let numbers: Vec<String> = members.iter().map(|member| (member + 1).to_string()).collect();
        let _ = writeln!(text, "{}", numbers.join(", "));
    }
}
