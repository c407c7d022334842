//! Search for the triangles that tools may touch in a tick.

use core::array;

use super::friction::Anchor;
use super::proxy::{PARTS_MAX, Proxy, TOOLS_MAX, ToolState};
use super::solid::Solid;
use crate::model::surface::ContactSurface;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;

/// A triangle in reach of a part of a tool, or gripped by it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearTriangle {
    pub(crate) corners: [u16; 3],
    /// Subdivisions of an edge.
    pub(crate) parts: u16,
    /// Stiffness of all samples together [2 `k_ref`].
    pub(crate) weight: f32,
    /// Lower bound of the distance of its points from the part, negative inside; for a gripped triangle the
    /// least number.
    pub(crate) distance: f32,
    /// The triangle, in the model's order.
    pub(crate) index: u32,
    /// Range of its anchors in the list.
    pub(crate) first: u16,
    pub(crate) held: u16,
    /// Code of the part: its index plus [`PARTS_MAX`] times the tool.
    pub(crate) of: u8,
}

kept!(NearTriangle {
    corners: [u16; 3],
    parts: u16,
    weight: f32,
    distance: f32,
    index: u32,
    first: u16,
    held: u16,
    of: u8,
});

impl NearTriangle {
    /// An empty slot.
    pub const NONE: Self = Self {
        corners: [0; 3],
        parts: 0,
        weight: 0.0,
        distance: 0.0,
        index: 0,
        first: 0,
        held: 0,
        of: 0,
    };

    /// The tool.
    pub(crate) fn tool(&self) -> usize {
        usize::from(self.of) / PARTS_MAX
    }

    /// Index of its part.
    pub(crate) fn part(&self) -> usize {
        usize::from(self.of) % PARTS_MAX
    }

    /// Its anchors among all.
    #[inline(always)]
    pub(crate) fn anchors_of<'a>(&self, anchors: &'a [Anchor]) -> &'a [Anchor] {
        let first = usize::from(self.first);
        anchors.get(first..first + usize::from(self.held)).unwrap_or(&[])
    }

    /// Sort key of the list.
    pub(crate) fn key(&self) -> (u32, u8) {
        (self.index, self.of)
    }
}

/// Result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Near {
    /// Slots taken.
    pub count: usize,
    /// True if some triangle in reach found no slot.
    pub full: bool,
    /// Lower bound of the surface's distance from the cores of each tool.
    pub distance: [f32; TOOLS_MAX],
    /// Upper bound of the surface's distance from the pivot of each tool with a half space; 0 for the others.
    pub extent: [f32; TOOLS_MAX],
}

/// Finds the triangles that tools may touch while they move by at most `reach` times the smallest radius of
/// their parts, and those that they grip at any distance, in the order of the triangles. If there are more
/// than slots, gripped triangles and those deepest in the tools are kept. `anchors` are in the order of the
/// triangles, too.
///
/// Cost: one look at each triangle of the surface for each part of an engaged tool, and at each anchor; if
/// slots are lacking, also at most 2 log2(slots) moves for each further triangle and for each slot.
pub(crate) fn search(
    surface: &ContactSurface<'_>,
    at: &impl Fn(usize) -> [f32; 3],
    (tools, reach): (&[ToolState], f32),
    anchors: &[Anchor],
    slots: &mut [NearTriangle],
) -> Near {
    let mut near =
        Near { count: 0, full: false, distance: [f32::MAX; TOOLS_MAX], extent: [0.0; TOOLS_MAX] };
    let is_endless = |tool: &ToolState| tool.is_in && tool.proxy.is_endless();
    let endless: [bool; TOOLS_MAX] = array::from_fn(|tool| tools.get(tool).is_some_and(is_endless));
    // The radius of the largest triangle, and the distance of the nearest centre of one, both squared.
    let (mut widest, mut nearest) = (0.0, [f32::MAX; TOOLS_MAX]);
    let mut anchors = anchors.iter().filter(|anchor| anchor.is_grip()).peekable();
    // Compare each triangle with each part of each engaged tool.
    for (index, &corners) in surface.triangles.iter().enumerate() {
        let whole = Whole::of(corners.map(|cell| at(cell.into())));
        widest = if whole.squared > widest { whole.squared } else { widest };
        // Collect the codes of the parts that grip it.
        let mut grips = 0_u64;
        while let Some(anchor) = anchors.next_if(|anchor| anchor.triangle as usize <= index) {
            grips |= 1_u64.unbounded_shl(anchor.part.into());
        }
        for ((number, tool), nearest) in tools.iter().enumerate().zip(&mut nearest) {
            if !tool.is_in {
                continue;
            }
            if endless.get(number).is_some_and(|is| *is) {
                near.stretch(number, whole.middle, &tool.proxy);
            }
            let stride = reach * tool.proxy.radius_min();
            for (part, solid) in tool.proxy.parts().iter().enumerate() {
                let (squared, distance) = whole.within(solid, solid.whole + stride);
                *nearest = if squared < *nearest { squared } else { *nearest };
                let code = (number * PARTS_MAX + part) as u8;
                let is_gripped = grips != 0 && grips & 1_u64.unbounded_shl(code.into()) != 0;
                let distance = if is_gripped { Some(f32::MIN) } else { distance };
                let Some(distance) = distance else { continue };
                let Some((_, of)) = surface.triangle(index) else { continue };
                let (parts, weight) = (of.parts(solid.sampled), of.weight(solid.sampled));
                let (index, of) = (index as u32, code);
                #[rustfmt::skip]
                let found = NearTriangle { corners, parts, weight, distance, index, of, ..NearTriangle::NONE };
                near.take(found, slots);
            }
        }
    }
    // Restore the order, and turn the squares into bounds.
    if near.full {
        sort(slots);
    }
    let widest = sqrt(widest);
    for (distance, nearest) in near.distance.iter_mut().zip(nearest) {
        *distance = sqrt(nearest) - widest;
    }
    for extent in near.extent.iter_mut().filter(|extent| **extent > 0.0) {
        *extent = sqrt(*extent) + widest;
    }
    near
}

/// Bounding circle of a triangle.
struct Whole {
    middle: [f32; 3],
    /// Squared distance of the farthest corner from the middle.
    squared: f32,
}

impl Whole {
    #[inline(always)]
    fn of([a, b, c]: [[f32; 3]; 3]) -> Self {
        let middle = scale(1.0 / 3.0, add(add(a, b), c));
        let squared = |corner| {
            let way = sub(corner, middle);
            dot(way, way)
        };
        let corners = [a, b, c].map(squared);
        let squared = corners.into_iter().fold(0.0, |most, r| if r > most { r } else { most });
        Self { middle, squared }
    }

    /// Squared distance of the middle from a core; and a lower bound of the distance of the triangle's points
    /// from the part, if the core may be within `far` of them.
    #[inline(always)]
    fn within(&self, solid: &Solid, far: f32) -> (f32, Option<f32>) {
        let way = solid.way_to(self.middle);
        let squared = dot(way, way);
        // Twice the sum of two squares is at least the square of the sum: most triangles need no root.
        if squared > 2.0 * (far * far + self.squared) {
            return (squared, None);
        }
        let distance = sqrt(squared) - sqrt(self.squared);
        (squared, (distance <= far).then_some(distance - solid.radius))
    }
}

impl Near {
    /// Updates the largest squared distance of a triangle's middle from the tool's pivot.
    fn stretch(&mut self, tool: usize, middle: [f32; 3], proxy: &Proxy) {
        let way = sub(middle, proxy.pivot);
        let squared = dot(way, way);
        if let Some(extent) = self.extent.get_mut(tool).filter(|extent| **extent < squared) {
            *extent = squared;
        }
    }

    /// Stores a triangle in a free slot, or in place of the farthest one.
    fn take(&mut self, found: NearTriangle, slots: &mut [NearTriangle]) {
        if let Some(slot) = slots.get_mut(self.count) {
            *slot = found;
            self.count += 1;
            return;
        }
        let farther = |a: &NearTriangle, b: &NearTriangle| a.distance > b.distance;
        if !self.full {
            self.full = true;
            (0..slots.len() / 2).rev().for_each(|root| sift(slots, root, farther));
        }
        if let Some(farthest) = slots.first_mut().filter(|slot| slot.distance > found.distance) {
            *farthest = found;
            sift(slots, 0, farther);
        }
    }
}

/// Sorts the slots in the order of the triangles.
fn sort(slots: &mut [NearTriangle]) {
    let later = |a: &NearTriangle, b: &NearTriangle| a.key() > b.key();
    (0..slots.len() / 2).rev().for_each(|root| sift(slots, root, later));
    for end in (1..slots.len()).rev() {
        exchange(slots, 0, end);
        sift(slots.get_mut(..end).unwrap_or(&mut []), 0, later);
    }
}

/// Moves a slot down in a heap in which every slot is above its children.
fn sift(
    slots: &mut [NearTriangle],
    mut root: usize,
    above: impl Fn(&NearTriangle, &NearTriangle) -> bool,
) {
    loop {
        let (left, right) = (2 * root + 1, 2 * root + 2);
        let is_above = |a: usize, b: usize| match (slots.get(a), slots.get(b)) {
            (Some(a), Some(b)) => above(a, b),
            _ => false,
        };
        let child = if is_above(right, left) { right } else { left };
        if !is_above(child, root) {
            return;
        }
        exchange(slots, child, root);
        root = child;
    }
}

fn exchange(slots: &mut [NearTriangle], a: usize, b: usize) {
    if let Ok([a, b]) = slots.get_disjoint_mut([a, b]) {
        core::mem::swap(a, b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::surface::proxy::Proxy;

    fn tool(centre: [f32; 3], whole: f32) -> ToolState {
        let part = Solid { whole, sampled: whole, ..Solid::NONE };
        let proxy = Proxy::of([part].into_iter()).at(centre, crate::number::turn::Turn::NONE, 1.0);
        ToolState { proxy, is_in: true, ..ToolState::NONE }
    }

    /// A strip of triangles along x.
    const STRIP: [[u16; 3]; 40] = {
        let mut strip = [[0; 3]; 40];
        let mut at = 0;
        while at < 40 {
            strip[at] = [at as u16, at as u16 + 1, at as u16 + 2];
            at += 1;
        }
        strip
    };

    fn place(cell: usize) -> [f32; 3] {
        [0.5 * cell as f32, (cell % 2) as f32, 0.0]
    }

    fn found(tools: &[ToolState], room: usize) -> (Near, std::vec::Vec<(u32, u8)>) {
        found_with(tools, &[], room)
    }

    fn found_with(
        tools: &[ToolState],
        anchors: &[Anchor],
        room: usize,
    ) -> (Near, std::vec::Vec<(u32, u8)>) {
        let surface = ContactSurface::of(&STRIP, &[[1.0; 3]; 40]);
        let mut slots = std::vec![NearTriangle::NONE; room];
        let near = search(&surface, &place, (tools, 0.0), anchors, &mut slots);
        (near, slots[..near.count].iter().map(NearTriangle::key).collect())
    }

    #[test]
    fn triangles_in_reach_are_found_in_their_order() {
        let (near, all) = found(&[tool([5.0, 0.5, 1.0], 1.5)], 64);
        assert!(!near.full && all.len() > 4 && all.is_sorted(), "{all:?}");
        assert!(near.distance[0] > 0.0 && near.distance[0] <= 1.0, "{:?}", near.distance);
        // There is no second tool: it is far from everything.
        assert!(near.distance[1] > 1e9);
        let nothing = found(&[tool([5.0, 0.5, 100.0], 1.5)], 64);
        assert!(nothing.1.is_empty() && nothing.0.distance[0] > 90.0);
    }

    #[test]
    fn where_slots_are_lacking_the_nearest_are_kept() {
        let tools = [tool([5.0, 0.5, 0.2], 3.0)];
        let (_, all) = found(&tools, 64);
        let (near, kept) = found(&tools, 5);
        assert!(near.full && kept.len() == 5 && kept.is_sorted());
        // Around the triangle in the middle.
        let (first, last) = (kept[0].0, kept[4].0);
        assert!(last - first == 4 && first > all[0].0 && last < all[all.len() - 1].0, "{kept:?}");
    }

    #[test]
    fn each_part_of_each_engaged_tool_has_its_own() {
        let away = ToolState { is_in: false, ..tool([5.0, 0.5, 0.0], 1.0) };
        let tools = [away, tool([5.0, 0.5, 0.0], 1.0), tool([15.0, 0.5, 0.0], 1.0)];
        let (_, all) = found(&tools, 64);
        assert!(all.iter().all(|(_, of)| *of == 8 || *of == 16), "{all:?}");
        assert!([8, 16].iter().all(|of| all.iter().any(|(_, own)| own == of)));
    }
    // REQ-CON-08
    #[test]
    fn what_a_tool_grips_is_found_at_any_distance() {
        let anchor =
            |triangle, part| Anchor { triangle, part, limit: f32::INFINITY, ..Anchor::NONE };
        let tools = [tool([5.0, 0.5, 100.0], 1.0), tool([5.0, 0.5, 0.2], 3.0)];
        let friction = Anchor { limit: 1.0, ..anchor(20, 0) };
        let anchors = [anchor(3, 0), friction, anchor(30, 0), anchor(39, 8)];
        let (_, all) = found_with(&tools, &anchors, 64);
        let gripped = [(3, 0), (30, 0), (39, 8)];
        assert!(gripped.iter().all(|key| all.contains(key)) && !all.contains(&(20, 0)), "{all:?}");
        // Where slots are lacking it is kept, but not for a tool that is not engaged.
        let (near, kept) = found_with(&tools, &anchors, 5);
        assert!(near.full && gripped.iter().all(|key| kept.contains(key)), "{kept:?}");
        let away = [ToolState { is_in: false, ..tools[0] }];
        assert!(found_with(&away, &anchors, 64).1.is_empty());
    }
}
