//! Neighbourhoods of r rings (the paper's Eq. 1): a link between any two nodes at most r edges
//! apart.

use super::Mesh;
use crate::error::{Error, Result};

/// Most links of a body with wider neighbourhoods.
const LINKS_MAX: usize = 4_000_000;

/// Links every pair of nodes that are at most `rings` of the mesh's edges apart; fixed nodes and
/// groups stay as they are. Cost: the edges within `rings` of each node.
///
/// # Errors
/// No ring, or more links than a model takes.
pub(super) fn widen(mesh: &mut Mesh, rings: u32) -> Result<()> {
    if rings == 0 {
        return Err(Error::input("`rings` 0: a cell has no neighbours then; give 1 or more"));
    }
    if rings == 1 {
        return Ok(());
    }
    let mut neighbours = vec![Vec::new(); mesh.nodes_m.len()];
    for &[i, j] in &mesh.links {
        neighbours[i as usize].push(j);
        neighbours[j as usize].push(i);
    }
    // The last start node that reached each node, and the nodes reached so far: the front is the tail.
    let (mut reached_by, mut reached) = (vec![u32::MAX; neighbours.len()], Vec::new());
    let mut links = Vec::new();
    for start in 0..neighbours.len() as u32 {
        reached.clear();
        reached.push(start);
        reached_by[start as usize] = start;
        let mut front = 0..1;
        for _ in 0..rings {
            for at in front.clone() {
                for &next in &neighbours[reached[at] as usize] {
                    if reached_by[next as usize] != start {
                        reached_by[next as usize] = start;
                        reached.push(next);
                    }
                }
            }
            front = front.end..reached.len();
        }
        links.extend(reached.iter().filter(|&&end| end > start).map(|&end| [start, end]));
        if links.len() > LINKS_MAX {
            return Err(Error::input(format!(
                "`rings` {rings}: more than {LINKS_MAX} links, the limit; fewer rings, or a \
                 coarser mesh"
            )));
        }
    }
    // Each pair was found once, from its lower node.
    links.sort_unstable();
    mesh.links = links;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{MeshOptions, load};

    fn links(spec: &str, rings: u32) -> Vec<[u32; 2]> {
        load(spec, &MeshOptions { rings, ..MeshOptions::default() }).unwrap().links
    }

    #[test]
    fn a_plane_is_linked_as_far_as_edges_lead() {
        let near = links("plane:5x5x0.01", 1);
        assert_eq!(near.len(), 40);
        // Two edges reach 2 along an axis (30 pairs) and 1 along both (32).
        assert_eq!(links("plane:5x5x0.01", 2).len(), 40 + 30 + 32);
        assert_eq!(links("plane:5x5x0.01", 8).len(), 25 * 24 / 2);
        assert_eq!(links("plane:5x5x0.01", 9), links("plane:5x5x0.01", 8));
        let apart = |&[i, j]: &[u32; 2]| (i / 5).abs_diff(j / 5) + (i % 5).abs_diff(j % 5);
        for rings in 1..=4 {
            assert!(links("plane:5x5x0.01", rings).iter().all(|link| apart(link) <= rings));
        }
    }

    #[test]
    fn too_few_and_too_many_are_refused() {
        let refused = |spec, rings| {
            load(spec, &MeshOptions { rings, ..MeshOptions::default() }).unwrap_err().to_string()
        };
        assert!(refused("plane:5x5x0.01", 0).contains("`rings` 0"));
        assert!(refused("plane:60x60x0.01", 200).contains("4000000 links"));
    }
}
