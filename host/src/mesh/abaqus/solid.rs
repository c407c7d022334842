//! The element types of Abaqus: types that are read, types that are refused, and the reasons.

use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};

/// Use of an element.
pub(super) enum Kind {
    Tetrahedron,
    /// Without volume: it counts only for its sets.
    Flat,
}

/// Names of solid elements, without the number of nodes that follows.
const SOLIDS: [&str; 8] = ["DCC3D", "DC3D", "AC3D", "CIN3D", "COH3D", "CSS", "C3D", "SC"];

const RECOMBINED: &str =
    "only tetrahedra (C3D4) are read: mesh it with tetrahedra, or split it into them";
const SECOND_ORDER: &str = "only first-order meshes are read, since each node is a cell and the nodes \
                            between corners would have no links of their own: save it with C3D4";

/// Returns the kind of a type's name, or the refusal.
pub(super) fn kind(name: &str, bytes: &Bytes) -> Result<Kind> {
    let upper = name.to_ascii_uppercase();
    let Some(rest) = SOLIDS.iter().find_map(|front| upper.strip_prefix(front)) else {
        return Ok(Kind::Flat);
    };
    let digits = rest.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(rest.len());
    let remedy = match rest.get(..digits).unwrap_or_default() {
        "4" => return Ok(Kind::Tetrahedron),
        "10" | "13" | "14" | "15" | "20" | "27" => SECOND_ORDER,
        _ => RECOMBINED,
    };
    Err(bytes.error(format!("elements of type {}; {remedy}", shown(name))))
}
