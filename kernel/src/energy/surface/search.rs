//! Search for the triangles that tools may touch in a tick.

use core::array;

use super::friction::Anchor;
use super::proxy::{PARTS_MAX, Proxy, TOOLS_MAX, ToolState};
use super::solid::Solid;
use crate::backend::f32x8::F32x8;
use crate::backend::slices::Chunks;
use crate::backend::{VectorUnit, Work, run};
use crate::model::surface::ContactSurface;
use crate::number::Number;
use crate::number::cell::{Cell, add, dot, scale, sub};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

kept! {
    /// A triangle in reach of a part of a tool, or gripped by it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct NearTriangle {
        pub(crate) corners: [u16; 3],
        /// Subdivisions of an edge.
        pub(crate) parts: u16,
        /// Stiffness of all samples together [2 `k_ref`].
        pub(crate) weight: f32,
        /// Lower bound of the distance of its points from the part, negative inside; for a gripped triangle
        /// the least number.
        pub(crate) distance: f32,
        /// The triangle, in the model's order.
        pub(crate) index: u32,
        /// Range of its anchors in the list.
        pub(crate) first: u16,
        pub(crate) held: u16,
        /// Code of the part: its index plus [`PARTS_MAX`] times the tool.
        pub(crate) of: u8,
    }
}

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

/// States in `f32` and the unit that looks at eight triangles at a time.
#[derive(Clone, Copy)]
pub(crate) struct EightWide<'a> {
    unit: VectorUnit,
    state: &'a [Cell],
    saturation: f32,
}

impl<'a> EightWide<'a> {
    /// `None` without a unit, and for other numbers.
    #[inline(always)]
    pub fn of<N: Number>(
        unit: Option<VectorUnit>,
        state: &'a [Cell<N>],
        saturation: f32,
    ) -> Option<Self> {
        Some(Self { unit: unit?, state: N::singles(state)?, saturation })
    }
}

/// Finds the triangles that tools may touch while they move by at most `reach` times the smallest radius of
/// their parts, and those that they grip at any distance, in the order of the triangles. If there are more
/// than slots, gripped triangles and those deepest in the tools are kept. `anchors` are in the order of the
/// triangles, too.
///
/// Cost: one look at each triangle of the surface for each part of an engaged tool, and at each anchor; with
/// `eight` and without grips a look at eight triangles for each sphere; if slots are lacking, also at most
/// 2 log2(slots) moves for each further triangle and for each slot.
pub(crate) fn search(
    surface: &ContactSurface<'_>,
    at: &impl Fn(usize) -> [f32; 3],
    (tools, reach): (&[ToolState], f32),
    anchors: &[Anchor],
    slots: &mut [NearTriangle],
    eight: Option<EightWide<'_>>,
) -> Near {
    let near =
        Near { count: 0, full: false, distance: [f32::MAX; TOOLS_MAX], extent: [0.0; TOOLS_MAX] };
    let is_endless = |tool: &ToolState| tool.is_in && tool.proxy.is_endless();
    let endless: [bool; TOOLS_MAX] = array::from_fn(|tool| tools.get(tool).is_some_and(is_endless));
    let nearest = [f32::MAX; TOOLS_MAX];
    let mut seek =
        Search { surface, tools, reach, endless, anchors, slots, near, widest: 0.0, nearest };
    // Compare each triangle with each part of each engaged tool.
    let engaged = || tools.iter().filter(|tool| tool.is_in);
    let are_balls = engaged().all(|tool| tool.proxy.parts().iter().all(Solid::is_ball));
    let has_grips = anchors.iter().any(Anchor::is_grip);
    match eight.filter(|_| are_balls && !has_grips) {
        Some(EightWide { unit, state, saturation }) => {
            run(Some(unit), Sieve { seek: &mut seek, state, saturation, at });
        }
        None => {
            for (index, &corners) in surface.triangles.iter().enumerate() {
                seek.look(index, corners, at);
            }
        }
    }
    // Restore the order, and turn the squares into bounds.
    let Search { mut near, slots, widest, nearest, .. } = seek;
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

/// A search.
struct Search<'a> {
    surface: &'a ContactSurface<'a>,
    tools: &'a [ToolState],
    reach: f32,
    /// True for a tool with a half space.
    endless: [bool; TOOLS_MAX],
    /// Anchors of the triangles that are still to come.
    anchors: &'a [Anchor],
    slots: &'a mut [NearTriangle],
    near: Near,
    /// Radius of the largest triangle, squared.
    widest: f32,
    /// Distance of the nearest centre of a triangle from each tool, squared.
    nearest: [f32; TOOLS_MAX],
}

impl Search<'_> {
    /// Compares a triangle with each part of each engaged tool.
    fn look(&mut self, index: usize, corners: [u16; 3], at: &impl Fn(usize) -> [f32; 3]) {
        let [a, b, c] = corners;
        let whole = Whole::of([at(a.into()), at(b.into()), at(c.into())]);
        self.widest = if whole.squared > self.widest { whole.squared } else { self.widest };
        // Collect the codes of the parts that grip it.
        let mut grips = 0_u64;
        while let Some((anchor, rest)) = self.anchors.split_first()
            && anchor.triangle as usize <= index
        {
            self.anchors = rest;
            let code = if anchor.is_grip() { anchor.part.into() } else { u64::BITS };
            grips |= 1_u64.unbounded_shl(code);
        }
        for ((number, tool), nearest) in self.tools.iter().enumerate().zip(&mut self.nearest) {
            if !tool.is_in {
                continue;
            }
            if self.endless.get(number).is_some_and(|is| *is) {
                self.near.stretch(number, whole.middle, &tool.proxy);
            }
            let stride = self.reach * tool.proxy.radius_min();
            for (part, solid) in tool.proxy.parts().iter().enumerate() {
                let (squared, distance) = whole.within(solid, solid.whole + stride);
                *nearest = if squared < *nearest { squared } else { *nearest };
                let code = (number * PARTS_MAX + part) as u8;
                let is_gripped = grips != 0 && grips & 1_u64.unbounded_shl(code.into()) != 0;
                let distance = if is_gripped { Some(f32::MIN) } else { distance };
                let Some(distance) = distance else { continue };
                let Some((_, of)) = self.surface.triangle(index) else { continue };
                let (parts, weight) = (of.parts(solid.sampled), of.weight(solid.sampled));
                let (index, of) = (index as u32, code);
                #[rustfmt::skip]
                let found = NearTriangle { corners, parts, weight, distance, index, of, ..NearTriangle::NONE };
                self.near.take(found, self.slots);
            }
        }
    }

    /// Compares eight triangles with each sphere, as [`Whole::within`]: above 0 in lanes that may be in reach.
    #[inline(always)]
    fn may_reach<V: F32x8>(&mut self, middle: [V; 3], size: V) -> V {
        let (mut may_reach, two) = (V::splat(0.0), V::splat(2.0));
        for (tool, nearest) in self.tools.iter().zip(&mut self.nearest) {
            if !tool.is_in {
                continue;
            }
            let stride = self.reach * tool.proxy.radius_min();
            for solid in tool.proxy.parts() {
                let [x, y, z] = solid.centre;
                let way = squared(middle, [V::splat(x), V::splat(y), V::splat(z)]);
                let far = solid.whole + stride;
                let beyond = way.above(two.times(V::splat(far * far).plus(size)));
                may_reach = V::select(beyond, may_reach, two);
                if V::any(way.below(V::splat(*nearest))) {
                    let mut lanes = [0.0; LANES];
                    way.store(&mut lanes);
                    for squared in lanes {
                        *nearest = if squared < *nearest { squared } else { *nearest };
                    }
                }
            }
        }
        may_reach
    }
}

/// A search of spheres over eight triangles at a time: those that may be in reach are looked at one by one.
struct Sieve<'a, 'b, A> {
    seek: &'a mut Search<'b>,
    state: &'a [Cell],
    saturation: f32,
    at: &'a A,
}

impl<A: Fn(usize) -> [f32; 3]> Work for Sieve<'_, '_, A> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Self { seek, state, saturation, at } = self;
        let (mut widest, zero, third) = (V::splat(0.0), V::splat(0.0), V::splat(1.0 / 3.0));
        let triangles = seek.surface.triangles;
        let (slices, padding) = (triangles.len().div_ceil(LANES), triangles.last().copied());
        let chunks = Chunks::new(triangles, padding.unwrap_or_default());
        for slice in 0..slices {
            let chunk = chunks.at(slice);
            let [
                [a, i, q],
                [b, j, r],
                [c, k, s],
                [d, l, t],
                [e, m, u],
                [f, n, v],
                [g, o, w],
                [h, p, x],
            ] = *chunk;
            let [a, b, c] = [
                outputs::<V>(state, [a, b, c, d, e, f, g, h], saturation),
                outputs::<V>(state, [i, j, k, l, m, n, o, p], saturation),
                outputs::<V>(state, [q, r, s, t, u, v, w, x], saturation),
            ];
            // Middle and size, as `Whole::of`.
            let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (a, b, c);
            let middle = [
                third.times(ax.plus(bx).plus(cx)),
                third.times(ay.plus(by).plus(cy)),
                third.times(az.plus(bz).plus(cz)),
            ];
            let sizes = [squared(a, middle), squared(b, middle), squared(c, middle)];
            let size = larger(larger(larger(zero, sizes[0]), sizes[1]), sizes[2]);
            widest = larger(widest, size);
            // Look at those that may be in reach one by one.
            let may_reach = seek.may_reach(middle, size);
            if V::any(may_reach.above(zero)) {
                let mut lanes = [0.0; LANES];
                may_reach.store(&mut lanes);
                for (lane, (&corners, may)) in chunk.iter().zip(lanes).enumerate() {
                    let index = slice * LANES + lane;
                    if may > 0.0 && index < triangles.len() {
                        seek.look(index, corners, at);
                    }
                }
            }
        }
        let mut lanes = [0.0; LANES];
        widest.store(&mut lanes);
        for size in lanes {
            seek.widest = if size > seek.widest { size } else { seek.widest };
        }
    }
}

/// Outputs of eight cells.
#[inline(always)]
fn outputs<V: F32x8>(state: &[Cell], cells: [u16; LANES], saturation: f32) -> [V; 3] {
    let [a, b, c, d, e, f, g, h] = cells;
    let at = |cell: u16| *state.get(usize::from(cell)).unwrap_or(&Cell::ZERO);
    let (low, high) = (V::splat(-saturation), V::splat(saturation));
    let [x, y, z, _] = V::transposed(&[at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h)]);
    [clamped(x, low, high), clamped(y, low, high), clamped(z, low, high)]
}

#[inline(always)]
fn clamped<V: F32x8>(x: V, low: V, high: V) -> V {
    V::select(x.above(high), high, V::select(x.below(low), low, x))
}

/// Squared distance.
#[inline(always)]
fn squared<V: F32x8>([x, y, z]: [V; 3], [a, b, c]: [V; 3]) -> V {
    let (x, y, z) = (x.minus(a), y.minus(b), z.minus(c));
    x.times(x).plus(y.times(y)).plus(z.times(z))
}

#[inline(always)]
fn larger<V: F32x8>(most: V, x: V) -> V {
    V::select(x.above(most), x, most)
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
    use crate::energy::surface::proxy::Proxy;

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

    /// The states' bound: the last cells are beyond it.
    const SATURATION: f32 = 20.0;

    fn far_place(cell: usize) -> [f32; 3] {
        [0.5 * cell as f32, (cell % 2) as f32, 0.0]
    }

    fn place(cell: usize) -> [f32; 3] {
        crate::number::cell::output(far_place(cell), SATURATION)
    }

    /// The result, one triangle after the other and, if this machine can, eight at a time: the same.
    fn found(tools: &[ToolState], room: usize) -> (Near, std::vec::Vec<(u32, u8)>) {
        found_with(tools, &[], room)
    }

    fn found_with(
        tools: &[ToolState],
        anchors: &[Anchor],
        room: usize,
    ) -> (Near, std::vec::Vec<(u32, u8)>) {
        let state: std::vec::Vec<Cell> = (0..42).map(|cell| Cell::at(far_place(cell))).collect();
        let eight = EightWide::of(VectorUnit::find(), &state, SATURATION);
        // A strip that fills its last eight, and one that does not.
        let [whole, part] = [40, 37].map(|count| {
            let (strip, numbers) = (&STRIP[..count], &[[1.0; 3]; 40][..count]);
            let surface = ContactSurface::of(strip, numbers);
            let [one, wide] = [None, eight].map(|eight| {
                let mut slots = std::vec![NearTriangle::NONE; room];
                let near = search(&surface, &place, (tools, 0.0), anchors, &mut slots, eight);
                (near, slots)
            });
            assert_eq!(one, wide);
            one
        });
        assert!(part.0.count <= whole.0.count);
        let (near, slots) = whole;
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
