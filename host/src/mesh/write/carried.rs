//! The elements that carry a group in a file: their nodes together are those of the group.

use crate::mesh::Mesh;

/// Elements of a group.
pub(super) enum Elements {
    /// Positions of tetrahedra.
    Tetrahedra(Vec<u32>),
    /// Positions of triangles of the surface.
    Triangles(Vec<u32>),
    /// The nodes themselves.
    Points(Vec<u32>),
}

/// A group, and the elements that carry it.
pub(super) struct Carried<'a> {
    pub(super) name: &'a str,
    pub(super) elements: Elements,
}

/// Returns all groups: carried by tetrahedra if those inside the group have all of its nodes, else by
/// triangles of the surface, else by points.
pub(super) fn carried(mesh: &Mesh) -> Vec<Carried<'_>> {
    let groups = mesh.groups.iter().filter(|(_, nodes)| !nodes.is_empty());
    groups.map(|(name, nodes)| Carried { name, elements: elements(mesh, nodes) }).collect()
}

fn elements(mesh: &Mesh, nodes: &[u32]) -> Elements {
    let mut is_own = vec![false; mesh.nodes_m.len()];
    nodes.iter().for_each(|node| is_own[*node as usize] = true);
    if let Some(all) = cover(&mesh.tetrahedra, &is_own, nodes.len()) {
        return Elements::Tetrahedra(all);
    }
    match cover(&mesh.triangles, &is_own, nodes.len()) {
        Some(all) => Elements::Triangles(all),
        None => Elements::Points(nodes.to_vec()),
    }
}

/// Returns the elements inside the group, if they have all of its nodes.
fn cover<const N: usize>(all: &[[u32; N]], is_own: &[bool], nodes: usize) -> Option<Vec<u32>> {
    let is_inside = |ids: &[u32; N]| ids.iter().all(|id| is_own[*id as usize]);
    let inside: Vec<u32> =
        (0..).zip(all).filter(|(_, ids)| is_inside(ids)).map(|(place, _)| place).collect();
    let mut covered: Vec<u32> = inside.iter().flat_map(|place| all[*place as usize]).collect();
    covered.sort_unstable();
    covered.dedup();
    (covered.len() == nodes).then_some(inside)
}

/// Returns numbers for groups in formats without names: a name that is a number keeps it, the others get
/// the lowest free numbers.
pub(super) fn numbers(groups: &[Carried]) -> Vec<i64> {
    // 0 is no group; "07" and "7" are different groups.
    let is_own = |name: &str, number: i32| number != 0 && number.to_string() == name;
    let own = |group: &Carried| {
        let number = group.name.parse().ok().filter(|&number| is_own(group.name, number));
        number.map(i64::from)
    };
    let taken: Vec<i64> = groups.iter().filter_map(own).collect();
    let mut free = (1..).filter(|number| !taken.contains(number));
    groups.iter().map(|group| own(group).or_else(|| free.next()).unwrap_or(i64::MAX)).collect()
}

/// Returns the note on a group that has another name in the file.
pub(super) fn renamed(name: &str, there: &str) -> Option<String> {
    (name != there).then(|| format!("group '{name}' is '{there}' in this file"))
}
