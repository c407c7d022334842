//! Search for the triangles that tools may touch in a tick.

use core::array;

use super::candidates::{Near, Search, sort};
use super::sieve::{EightWide, Sieve};
use crate::backend::run;
use crate::energy::surface::{Anchor, NearTriangle, Solid, TOOLS_MAX, ToolState};
use crate::model::surface::ContactSurface;
use crate::number::sqrt::sqrt;

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
    tools: &[ToolState],
    reach: f32,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::VectorUnit;
    use crate::energy::surface::Proxy;
    use crate::number::cell::Cell;

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
    fn found(tools: &[ToolState], capacity: usize) -> (Near, std::vec::Vec<(u32, u8)>) {
        found_with(tools, &[], capacity)
    }

    fn found_with(
        tools: &[ToolState],
        anchors: &[Anchor],
        capacity: usize,
    ) -> (Near, std::vec::Vec<(u32, u8)>) {
        let state: std::vec::Vec<Cell> = (0..42).map(|cell| Cell::at(far_place(cell))).collect();
        let eight = EightWide::of(VectorUnit::find(), &state, state.len(), SATURATION);
        // A strip that fills its last eight, and one that does not.
        let [whole, part] = [40, 37].map(|count| {
            let (strip, numbers) = (&STRIP[..count], &[[1.0; 3]; 40][..count]);
            let surface = ContactSurface::of(strip, numbers);
            let [one, wide] = [None, eight].map(|eight| {
                let mut slots = std::vec![NearTriangle::NONE; capacity];
                let near = search(&surface, &place, tools, 0.0, anchors, &mut slots, eight);
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
