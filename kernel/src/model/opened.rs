//! Faces that a cut has opened, as triangles that tools touch behind those of the image.
//!
//! **Names.** The place of such a triangle in the list changes when a further face opens before it. What lasts
//! from tick to tick, such as an anchor, therefore names it: by the number of triangles of the image, plus four
//! times its tetrahedron, plus the corner of that opposite to it. The list ascends by name, like the image's.
//!
//! **Bare faces.** The sides of a fresh cut lie on each other, and a tool above it must not press on them through
//! the tissue. So a tool touches a side with a share of its stiffness that follows from how far the other side
//! has moved from it: with h the mean edge of the triangle and d the way to the middle of the other side,
//!
//! ```text
//! share = the larger of (n . d / h - 0.1) / 0.3 and |d| / h - 1, from 0 to 1
//! ```
//!
//! n is the outward normal. The first is the gap; the second is for a piece that has moved elsewhere, where n . d
//! says nothing. Both follow from the positions at the search of a tick, so a share needs no memory.

use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::cross;

/// Gap, in mean edges, up to which a side is covered.
const COVERED: f32 = 0.1;
/// Further gap, in mean edges, until it is bare.
const UNCOVERS: f32 = 0.3;
/// Way, in mean edges, up to which the other side may have moved along it.
const ALONG: f32 = 1.0;

/// The place of a side that is gone.
pub(crate) const ALONE: u32 = u32::MAX;

/// The triangles of opened faces, in the order of their names.
#[derive(Clone, Copy)]
pub(crate) struct Opened<'a> {
    /// Name of each, and the place of the face's other side in this list; [`ALONE`] if that is gone.
    pub names: &'a [[u32; 2]],
    /// Contact numbers of each.
    pub numbers: &'a [[f32; 3]],
}

impl<'a> Opened<'a> {
    /// No face.
    pub const NONE: Self = Self { names: &[], numbers: &[] };

    /// Contact numbers of a triangle.
    #[inline(always)]
    pub fn numbers(&self, place: usize) -> Option<&'a [f32; 3]> {
        self.numbers.get(place)
    }

    /// Name of a triangle.
    #[inline(always)]
    pub fn name(&self, place: usize) -> Option<u32> {
        self.names.get(place).map(|[name, _]| *name)
    }

    /// Place of the triangle with this name.
    pub fn place(&self, name: u32) -> Option<usize> {
        self.names.binary_search_by_key(&name, |[name, _]| *name).ok()
    }

    /// Share of its stiffness with which tools touch a triangle; `triangles` are those of this list, `edge` is its
    /// mean edge at rest.
    pub fn share(
        &self,
        triangles: &[[u16; 3]],
        place: usize,
        edge: f32,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> f32 {
        let side = |place: usize| Some(triangles.get(place)?.map(|cell| at(cell.into())));
        let Some(own) = side(place) else { return 0.0 };
        let other = self.names.get(place).and_then(|[_, other]| side(*other as usize));
        other.map_or(1.0, |other| bare(own, other, edge))
    }
}

/// The share for both sides of a face, the own one outward.
fn bare([a, b, c]: [[f32; 3]; 3], [p, q, r]: [[f32; 3]; 3], edge: f32) -> f32 {
    let way = scale(1.0 / 3.0, sub(add(add(p, q), r), add(add(a, b), c)));
    let normal = cross(sub(b, a), sub(c, a));
    let (size, length) = (sqrt(dot(normal, normal)), sqrt(dot(way, way)));
    // A triangle without area has no normal, and no gap.
    let gap = if size > 0.0 { dot(normal, way) / size } else { 0.0 };
    let (of_gap, of_way) = ((gap / edge - COVERED) / UNCOVERS, length / edge - ALONG);
    let share = if of_gap > of_way { of_gap } else { of_way };
    if share > 0.0 { if share < 1.0 { share } else { 1.0 } } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

    fn share(way: [f32; 3]) -> f32 {
        let [a, b, c] = OWN.map(|corner| add(corner, way));
        bare(OWN, [a, c, b], 2.0)
    }

    #[test]
    fn a_side_is_bare_where_the_other_one_is_away() {
        assert_eq!(share([0.0; 3]), 0.0);
        // The gap opens.
        assert_eq!(share([0.0, 0.0, 0.19]), 0.0);
        assert!((share([0.0, 0.0, 0.5]) - 0.5).abs() < 1e-6);
        assert_eq!(share([0.0, 0.0, 0.9]), 1.0);
        // The sides overlap, or slide on each other.
        assert_eq!(share([0.0, 0.0, -1.9]), 0.0);
        assert_eq!(share([1.9, 0.0, 0.0]), 0.0);
        // The other piece is elsewhere.
        assert!((share([3.0, 0.0, 0.0]) - 0.5).abs() < 1e-6);
        assert_eq!(share([0.0, 0.0, -4.0]), 1.0);
    }

    #[test]
    fn a_triangle_without_area_has_no_gap() {
        assert_eq!(bare([[0.0; 3]; 3], [[0.0, 0.0, 1.0]; 3], 2.0), 0.0);
    }
}
