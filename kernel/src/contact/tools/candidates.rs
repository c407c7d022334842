//! Triangles in reach of the tools, collected one at a time.

use crate::energy::surface::{Anchor, NearTriangle, PARTS_MAX, Proxy, Solid, TOOLS_MAX, ToolState};
use crate::model::surface::ContactSurface;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;

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

/// A search, triangle by triangle.
pub(super) struct Search<'a> {
    pub surface: &'a ContactSurface<'a>,
    pub tools: &'a [ToolState],
    pub reach: f32,
    /// True for a tool with a half space.
    pub endless: [bool; TOOLS_MAX],
    /// Anchors of the triangles that are still to come.
    pub anchors: &'a [Anchor],
    pub slots: &'a mut [NearTriangle],
    pub near: Near,
    /// Radius of the largest triangle, squared.
    pub widest: f32,
    /// Distance of the nearest centre of a triangle from each tool, squared.
    pub nearest: [f32; TOOLS_MAX],
}

impl Search<'_> {
    /// Compares a triangle with each part of each engaged tool.
    pub fn look(&mut self, index: usize, corners: [u16; 3], at: &impl Fn(usize) -> [f32; 3]) {
        let [a, b, c] = corners;
        let whole = Whole::of([at(a.into()), at(b.into()), at(c.into())]);
        self.widest = if whole.squared > self.widest { whole.squared } else { self.widest };
        // Collect the codes of the parts that grip it, by its name.
        let name = self.surface.name(index);
        let mut grips = 0_u64;
        while let Some((anchor, rest)) = self.anchors.split_first()
            && anchor.triangle <= name
        {
            self.anchors = rest;
            let code = if anchor.is_grip() { anchor.part.into() } else { u64::BITS };
            grips |= 1_u64.unbounded_shl(code);
        }
        // Measure the distance to each part of each tool, and keep what is in reach.
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
                let Some((_, sampling)) = self.surface.triangle(index) else { continue };
                // An opened face counts as far as it is bare.
                let share = self.surface.share(index, sampling.edge, at);
                if share <= 0.0 {
                    continue;
                }
                let (parts, weight) =
                    (sampling.parts(solid.sampled), share * sampling.weight(solid.sampled));
                let (index, of) = (name, code);
                #[rustfmt::skip]
                let found = NearTriangle { corners, parts, weight, distance, index, of, ..NearTriangle::NONE };
                self.near.take(found, self.slots);
            }
        }
    }
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
            let offset = sub(corner, middle);
            dot(offset, offset)
        };
        let corners = [a, b, c].map(squared);
        let squared = corners.into_iter().fold(0.0, |most, r| if r > most { r } else { most });
        Self { middle, squared }
    }

    /// Squared distance of the middle from a core; and a lower bound of the distance of the triangle's points
    /// from the part, if the core may be within `far` of them.
    #[inline(always)]
    fn within(&self, solid: &Solid, far: f32) -> (f32, Option<f32>) {
        let offset = solid.way_to(self.middle);
        let squared = dot(offset, offset);
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
        let offset = sub(middle, proxy.pivot);
        let squared = dot(offset, offset);
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
pub(super) fn sort(slots: &mut [NearTriangle]) {
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
