//! The element types of Gmsh: types that are read, types that are refused, and the reasons.

use super::content::Content;
use super::file::File;
use crate::error::Result;

/// Returns the dimension of the elements of `kind`, or the refusal.
pub(super) fn dimension(kind: u64, element: &dyn std::fmt::Display, at: &File) -> Result<u64> {
    let (name, remedy) = match kind {
        15 => return Ok(0),
        1 => return Ok(1),
        2 => return Ok(2),
        4 => return Ok(3),
        3 => ("4-node quadrangle", RECOMBINED),
        5 => ("8-node hexahedron", RECOMBINED),
        6 => ("6-node prism", RECOMBINED),
        7 => ("5-node pyramid", RECOMBINED),
        8 => ("3-node line", SECOND_ORDER),
        9 => ("6-node triangle", SECOND_ORDER),
        10 => ("9-node quadrangle", SECOND_ORDER),
        11 => ("10-node tetrahedron", SECOND_ORDER),
        12 => ("27-node hexahedron", SECOND_ORDER),
        13 => ("18-node prism", SECOND_ORDER),
        14 => ("14-node pyramid", SECOND_ORDER),
        16 => ("8-node quadrangle", SECOND_ORDER),
        17 => ("20-node hexahedron", SECOND_ORDER),
        18 => ("15-node prism", SECOND_ORDER),
        19 => ("13-node pyramid", SECOND_ORDER),
        _ => ("element of another kind", SECOND_ORDER),
    };
    Err(at.refuse(&format!("{element} is a {name} (type {kind}); {remedy}")))
}

const RECOMBINED: &str = "only tetrahedra are read: mesh it without recombination, extruded or \
                          transfinite layers (Mesh.RecombineAll = 0, Mesh.SubdivisionAlgorithm = 0)";
const SECOND_ORDER: &str = "only first-order meshes are read: save it with Mesh.ElementOrder = 1";

/// Takes the nodes of element `tag` and adds them to `number`, a group in 2.2 and
/// an entity in 4.1. `dimension` is that of the element.
pub(super) fn take(
    content: &mut Content,
    from: &mut File,
    dimension: u64,
    tag: u64,
    number: i64,
) -> Result<()> {
    match dimension {
        3 => {
            let ids = content.corners::<4>(tag, from)?;
            content.tetrahedron(tag, ids, from)?;
            content.member(3, number, &ids);
        }
        2 => other(content, content.corners::<3>(tag, from)?, 2, number),
        1 => other(content, content.corners::<2>(tag, from)?, 1, number),
        _ => other(content, content.corners::<1>(tag, from)?, 0, number),
    }
    Ok(())
}

fn other<const N: usize>(content: &mut Content, ids: [u32; N], dimension: u64, number: i64) {
    content.other();
    content.member(dimension, number, &ids);
}
