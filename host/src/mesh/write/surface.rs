//! STL and OBJ, ASCII: only the surface.

use std::fmt::Write as _;

use super::{Written, digits, line};
use crate::mesh::Mesh;
use crate::mesh::geometry::{cross, dot, minus};

pub(super) fn stl(mesh: &Mesh) -> Result<Written, String> {
    let mut text = String::from("solid chaincell\n");
    for triangle in &mesh.triangles {
        let corners = triangle.map(|id| mesh.nodes_m[id as usize]);
        let [a, b, c] = corners;
        let area = cross(minus(b, a), minus(c, a));
        let length = dot(area, area).sqrt().max(f64::MIN_POSITIVE);
        let [x, y, z] = area.map(|x| x / length);
        let _ = writeln!(text, "facet normal {x:e} {y:e} {z:e}\nouter loop");
        for place in corners {
            text.push_str("vertex ");
            line(&mut text, place.map(digits));
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid chaincell\n");
    Ok(surface(text, mesh))
}

pub(super) fn obj(mesh: &Mesh) -> Result<Written, String> {
    let mut used: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut text = String::new();
    for id in &used {
        text.push_str("v ");
        line(&mut text, mesh.nodes_m[*id as usize].map(digits));
    }
    for triangle in &mesh.triangles {
        text.push_str("f ");
        line(&mut text, triangle.map(|id| used.partition_point(|known| *known < id) + 1));
    }
    Ok(surface(text, mesh))
}

fn surface(text: String, mesh: &Mesh) -> Written {
    let lost = (!mesh.groups.is_empty()).then(|| "groups are left out: a surface has none".into());
    Written { text, notes: lost.into_iter().collect() }
}
