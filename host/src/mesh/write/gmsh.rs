//! Gmsh 4.1, ASCII: groups are physical groups of volumes, surfaces or points, by name.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::carried::{Elements, carried};
use super::{Written, digits, line};
use crate::mesh::Mesh;

/// Elements of one entity: dimension, type, nodes of each.
struct Block {
    dimension: usize,
    kind: usize,
    /// Physical groups.
    groups: Vec<usize>,
    nodes: Vec<Vec<u32>>,
}

pub(super) fn write(mesh: &Mesh) -> Result<Written, String> {
    let groups = carried(mesh);
    let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    let dimension = |elements: &Elements| match elements {
        Elements::Tetrahedra(_) => 3,
        Elements::Triangles(_) => 2,
        Elements::Points(_) => 0,
    };
    // Names of the groups.
    if !groups.is_empty() {
        let _ = writeln!(text, "$PhysicalNames\n{}", groups.len());
        for (number, group) in (1..).zip(&groups) {
            if group.name.contains(['"', '\n', '\r']) {
                return Err(format!("the group '{}' has a quotation mark in its name", group.name));
            }
            let _ = writeln!(text, "{} {number} \"{}\"", dimension(&group.elements), group.name);
        }
        text.push_str("$EndPhysicalNames\n");
    }
    // Tetrahedra with the same groups are one volume.
    let mut of_tetrahedron = vec![Vec::new(); mesh.tetrahedra.len()];
    let mut blocks = Vec::new();
    for (number, group) in (1..).zip(&groups) {
        let nodes = match &group.elements {
            Elements::Tetrahedra(all) => {
                all.iter().for_each(|&place| of_tetrahedron[place as usize].push(number));
                continue;
            }
            Elements::Triangles(all) => {
                all.iter().map(|&place| mesh.triangles[place as usize].to_vec()).collect()
            }
            Elements::Points(all) => all.iter().map(|&node| vec![node]).collect(),
        };
        let (dimension, kind) = if dimension(&group.elements) == 2 { (2, 2) } else { (0, 15) };
        blocks.push(Block { dimension, kind, groups: vec![number], nodes });
    }
    let mut volumes: BTreeMap<usize, usize> = BTreeMap::new();
    let mut sets: Vec<&Vec<usize>> = of_tetrahedron.iter().collect();
    sets.sort_unstable();
    sets.dedup();
    // Tetrahedra keep their order: a volume may have several blocks.
    let first = blocks.len();
    for (groups, ids) in of_tetrahedron.iter().zip(&mesh.tetrahedra) {
        let set = sets.partition_point(|set| *set < groups);
        let is_same = volumes.last_key_value().is_some_and(|(_, last)| *last == set);
        if !is_same {
            volumes.insert(blocks.len(), set);
            blocks.push(Block { dimension: 3, kind: 4, groups: groups.clone(), nodes: Vec::new() });
        }
        if let Some(block) = blocks.last_mut() {
            block.nodes.push(ids.to_vec());
        }
    }
    // Entities count from 1 in each dimension; those of triangles and points have one block each.
    let mut tags: Vec<usize> = Vec::new();
    for (at, block) in blocks.iter().enumerate() {
        let before = blocks.iter().take(at.min(first)).filter(|b| b.dimension == block.dimension);
        tags.push(1 + volumes.get(&at).copied().unwrap_or_else(|| before.count()));
    }
    // The remaining sections.
    entities(&mut text, mesh, &blocks, &tags);
    nodes(&mut text, mesh);
    let count: usize = blocks.iter().map(|block| block.nodes.len()).sum();
    let _ = writeln!(text, "$Elements\n{} {count} 1 {count}", blocks.len());
    let mut tag = 1;
    for (block, entity) in blocks.iter().zip(&tags) {
        line(&mut text, [block.dimension, *entity, block.kind, block.nodes.len()]);
        for ids in &block.nodes {
            line(&mut text, std::iter::once(tag).chain(ids.iter().map(|id| id + 1)));
            tag += 1;
        }
    }
    text.push_str("$EndElements\n");
    Ok(Written { text, notes: Vec::new() })
}

fn entities(text: &mut String, mesh: &Mesh, blocks: &[Block], tags: &[usize]) {
    let along = |axis: usize| mesh.nodes_m.iter().map(move |place| place[axis]);
    let low = [0, 1, 2].map(|axis| along(axis).fold(f64::INFINITY, f64::min));
    let high = [0, 1, 2].map(|axis| along(axis).fold(f64::NEG_INFINITY, f64::max));
    // An entity has one line, also if it has several blocks.
    let mut lines: BTreeMap<(usize, usize), String> = BTreeMap::new();
    for (block, tag) in blocks.iter().zip(tags) {
        let bounds = if block.dimension == 0 { low.to_vec() } else { [low, high].concat() };
        let mut words = vec![tag.to_string()];
        words.extend(bounds.into_iter().map(digits));
        words.push(block.groups.len().to_string());
        words.extend(block.groups.iter().map(usize::to_string));
        if block.dimension > 0 {
            words.push("0".into());
        }
        lines.insert((block.dimension, *tag), words.join(" "));
    }
    let count = |dimension| lines.keys().filter(|(own, _)| *own == dimension).count();
    text.push_str("$Entities\n");
    line(text, [0, 1, 2, 3].map(count));
    lines.values().for_each(|entity| line(text, [entity]));
    text.push_str("$EndEntities\n");
}

fn nodes(text: &mut String, mesh: &Mesh) {
    let count = mesh.nodes_m.len();
    let _ = writeln!(text, "$Nodes\n1 {count} 1 {count}\n3 1 0 {count}");
    (1..=count).for_each(|tag| line(text, [tag]));
    mesh.nodes_m.iter().for_each(|place| line(text, place.map(digits)));
    text.push_str("$EndNodes\n");
}
