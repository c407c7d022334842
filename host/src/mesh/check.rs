//! Checks a body before it is baked; every refusal names the place and the remedy.

use super::geometry::distance;
use super::{Mesh, MeshOptions, RawMesh};
use crate::error::{Error, Result};
use crate::words::counted;

/// Shortest link, as a share of the mean link length.
const SHORTEST_LINK: f64 = 1e-6;

/// Most ids that a text lists.
const IDS_SHOWN: usize = 10;

/// Checks the body of `spec`; returns its nodes without a link, sorted.
pub(super) fn check(spec: &str, mesh: &Mesh, options: &MeshOptions) -> Result<Vec<u32>> {
    let refuse = |why: String| Error::input(format!("mesh {spec}: {why}"));
    if mesh.links.is_empty() {
        return Err(refuse(
            "the body has no links; it needs tetrahedra or a plane's squares".into(),
        ));
    }
    // Nodes without a link.
    let mut used = vec![false; mesh.nodes_m.len()];
    mesh.links.iter().flatten().for_each(|id| used[*id as usize] = true);
    let (cells, unused): (Vec<u32>, Vec<u32>) =
        (0..mesh.nodes_m.len() as u32).partition(|id| used[*id as usize]);
    if !unused.is_empty() && !options.drop_unused {
        return Err(refuse(format!(
            "{} without a link: {}; remove them or pass `drop_unused`, which keeps the numbers of \
             the others",
            counted(unused.len(), "node"),
            first(&unused)
        )));
    }
    // Size, parts, positions and lengths.
    if cells.len() > options.nodes_max {
        let nodes = format!("{}, more", counted(cells.len(), "node"));
        return Err(refuse(super::too_many(nodes, options.nodes_max, "mesh it coarser")));
    }
    let parts = parts(mesh.nodes_m.len(), cells.len(), &mesh.links);
    if parts > 1 && !options.allow_parts {
        return Err(refuse(format!(
            "{parts} unconnected parts; join them or pass `allow_parts` if that is meant"
        )));
    }
    places(mesh, &cells).map_err(refuse)?;
    lengths(mesh).map_err(refuse)?;
    Ok(unused)
}

/// Refuses invalid numbers of a program; the readers of files refuse them too.
pub(super) fn numbers(spec: &str, raw: &RawMesh) -> Result<()> {
    let refuse = |why: String| Err(Error::input(format!("mesh {spec}: {why}")));
    let nodes = raw.nodes_m.len();
    let is_node = |id: &u32| (*id as usize) < nodes;
    let is_place = |place: &[f64; 3]| place.iter().all(|x| (*x as f32).is_finite());
    if let Some(node) = raw.nodes_m.iter().position(|place| !is_place(place)) {
        return refuse(format!(
            "node {node} is at {:?}; every coordinate must be a finite number of metres",
            raw.nodes_m[node]
        ));
    }
    for (at, corners) in raw.tetrahedra.iter().enumerate() {
        if let Some(id) = corners.iter().find(|id| !is_node(id)) {
            return refuse(format!(
                "tetrahedron {at} has node {id}, and there are {}: ids count from 0",
                counted(nodes, "node")
            ));
        }
        if (0..3).any(|i| corners[i + 1..].contains(&corners[i])) {
            return refuse(format!("tetrahedron {at} has a node twice: {corners:?}; leave it out"));
        }
    }
    for (name, ids) in &raw.groups {
        if let Some(id) = ids.iter().find(|id| !is_node(id)) {
            return refuse(format!(
                "group {name} has node {id}, and there are {}: ids count from 0",
                counted(nodes, "node")
            ));
        }
    }
    Ok(())
}

fn first(ids: &[u32]) -> String {
    let shown: Vec<String> = ids.iter().take(IDS_SHOWN).map(u32::to_string).collect();
    let more = if ids.len() > IDS_SHOWN { ", .." } else { "" };
    shown.join(", ") + more
}

/// Refuses a body that is one point, and two cells at one place.
fn places(mesh: &Mesh, cells: &[u32]) -> std::result::Result<(), String> {
    // As the image stores them: positions that differ only in f64 would coincide there.
    let place = |id: u32| mesh.nodes_m[id as usize].map(|x| x as f32 + 0.0);
    let order = |a: &[f32; 3], b: &[f32; 3]| {
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
    };
    let mut sorted: Vec<([f32; 3], u32)> = cells.iter().map(|id| (place(*id), *id)).collect();
    sorted.sort_unstable_by(|a, b| order(&a.0, &b.0).then(a.1.cmp(&b.1)));
    if let (Some(low), Some(high)) = (sorted.first(), sorted.last())
        && low.0 == high.0
    {
        return Err(format!("all {} cells are at {:?} m; check `unit_m`", cells.len(), low.0));
    }
    match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => Err(format!(
            "nodes {} and {} are both at {:?} m; merge duplicate nodes (in Gmsh: Coherence Mesh; in \
             ParaView: Clean to Grid) or check `unit_m`",
            pair[0].1, pair[1].1, pair[0].0
        )),
        None => Ok(()),
    }
}

fn lengths(mesh: &Mesh) -> std::result::Result<(), String> {
    let length = |[i, j]: [u32; 2]| distance(mesh.nodes_m[i as usize], mesh.nodes_m[j as usize]);
    let mean = mesh.links.iter().map(|l| length(*l)).sum::<f64>() / mesh.links.len() as f64;
    match mesh.links.iter().find(|l| length(**l) < SHORTEST_LINK * mean) {
        Some(&[i, j]) => Err(format!(
            "linked nodes {i} and {j} are {:e} m apart, less than {SHORTEST_LINK:e} of the mean \
             link length of {mean:e} m; merge them and mesh again",
            length([i, j])
        )),
        None => Ok(()),
    }
}

/// Returns the number of connected parts among the `linked` nodes, those that have links.
pub(super) fn parts(nodes: usize, linked: usize, links: &[[u32; 2]]) -> usize {
    let mut parent: Vec<u32> = (0..nodes as u32).collect();
    let mut count = linked;
    for &[i, j] in links {
        let (a, b) = (root(&mut parent, i), root(&mut parent, j));
        if a != b {
            parent[a.max(b) as usize] = a.min(b);
            count -= 1;
        }
    }
    count
}

fn root(parent: &mut [u32], mut id: u32) -> u32 {
    while parent[id as usize] != id {
        // Halving the path keeps later walks short.
        parent[id as usize] = parent[parent[id as usize] as usize];
        id = parent[id as usize];
    }
    id
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CELLS_MAX;

    fn chain(places: &[f64], links: &[[u32; 2]]) -> Mesh {
        Mesh {
            nodes_m: places.iter().map(|x| [*x, 1.0, 2.0]).collect(),
            links: links.to_vec(),
            ..Mesh::default()
        }
    }

    fn refusal(mesh: &Mesh) -> String {
        check("a.msh", mesh, &MeshOptions::default()).unwrap_err().to_string()
    }

    #[test]
    fn sound_body_passes() {
        let mesh = chain(&[0.0, 1.0, 2.0], &[[0, 1], [1, 2]]);
        assert_eq!(check("a.msh", &mesh, &MeshOptions::default()), Ok(vec![]));
    }

    #[test]
    fn unused_nodes() {
        let mesh = chain(&[0.0, 5.0, 2.0, 0.0], &[[0, 2]]);
        let text = refusal(&mesh);
        assert!(
            text.contains("2 nodes") && text.contains("1, 3;") && text.contains("`drop_unused`")
        );
        let options = MeshOptions { drop_unused: true, ..MeshOptions::default() };
        assert_eq!(check("a.msh", &mesh, &options), Ok(vec![1, 3]));
    }

    #[test]
    fn parts_are_counted() {
        let mesh = chain(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], &[[0, 3], [1, 4], [2, 5]]);
        let text = refusal(&mesh);
        assert!(text.contains("3 unconnected parts") && text.contains("`allow_parts`"));
        let options = MeshOptions { allow_parts: true, ..MeshOptions::default() };
        assert_eq!(check("a.msh", &mesh, &options), Ok(vec![]));
    }

    #[test]
    fn too_many_cells() {
        let places: Vec<f64> = (0..=CELLS_MAX).map(|i| i as f64).collect();
        let links: Vec<_> = (0..CELLS_MAX as u32).map(|i| [i, i + 1]).collect();
        assert!(refusal(&chain(&places, &links)).contains("65536 nodes, more than 65535 cells"));
        let fits = chain(&places[1..], &links[..CELLS_MAX - 1]);
        assert_eq!(check("a.msh", &fits, &MeshOptions::default()), Ok(vec![]));
    }

    #[test]
    fn numbers_that_are_no_mesh_are_refused_by_their_place() {
        let nodes_m = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let sound = RawMesh { nodes_m, tetrahedra: vec![[0, 1, 2, 3]], ..RawMesh::default() };
        assert_eq!(numbers("arrays", &sound), Ok(()));
        let refusal = |change: &dyn Fn(&mut RawMesh)| {
            let mut raw = sound.clone();
            change(&mut raw);
            numbers("arrays", &raw).unwrap_err().to_string()
        };
        let text = refusal(&|raw| raw.nodes_m[2][1] = f64::NAN);
        assert!(text.contains("node 2 is at [0.0, NaN, 0.0]"), "{text}");
        assert!(refusal(&|raw| raw.nodes_m[2][1] = 1e39).contains("node 2"));
        let text = refusal(&|raw| raw.tetrahedra.push([0, 1, 2, 4]));
        assert!(text.contains("tetrahedron 1 has node 4, and there are 4 nodes"), "{text}");
        let text = refusal(&|raw| raw.tetrahedra.push([0, 1, 2, 1]));
        assert!(text.contains("tetrahedron 1 has a node twice"), "{text}");
        let text = refusal(&|raw| _ = raw.groups.insert("top".into(), vec![3, 9]));
        assert!(text.contains("group top has node 9"), "{text}");
    }

    #[test]
    fn places_and_lengths() {
        assert!(refusal(&chain(&[0.0, 1.0], &[])).contains("no links"));
        assert!(refusal(&chain(&[3.0, 3.0], &[[0, 1]])).contains("all 2 cells are at"));
        let text = refusal(&chain(&[0.0, 1.0, -0.0], &[[0, 1], [1, 2]]));
        assert!(text.contains("nodes 0 and 2 are both at"), "{text}");
        let same_in_f32 = chain(&[1.0, 1.0 + 1e-12, 2.0], &[[0, 2], [1, 2]]);
        assert!(refusal(&same_in_f32).contains("nodes 0 and 1"));
        let near = chain(&[0.0, 1e-7, 1.0], &[[0, 1], [1, 2]]);
        assert!(refusal(&near).contains("linked nodes 0 and 1 are 1e-7 m apart"));
    }
}
