//! Anchors of friction and grips, from tick to tick.

use super::energies::{energy_of, rise};
use crate::contact::memory::TouchArrays;
use crate::energy::surface::{Anchor, NearTriangle, PARTS_MAX, Proxies, Sample, each_met};
use crate::number::two_float::TwoFloat;

/// Assigns anchors to the triangles in reach; both lists are in the order of the triangles.
pub(super) fn regroup(arrays: &mut TouchArrays<'_>, count: usize) {
    let Some(state) = arrays.state.first_mut() else { return };
    state.count = count;
    let anchors = state.present(arrays.anchors);
    let mut next = 0;
    for near in arrays.near.iter_mut().take(count) {
        let key = near.key();
        let order = |anchor: &Anchor| (anchor.triangle, anchor.part);
        while anchors.get(next).is_some_and(|anchor| order(anchor) < key) {
            next += 1;
        }
        let count = anchors.iter().skip(next).take_while(|anchor| order(anchor) == key).count();
        (near.first, near.held) = (next as u16, count as u16);
        next += count;
    }
}

/// Moves anchors with their tools and fades released grips. Returns the contact energy of all tools; if it
/// exceeds `energy_max`, all anchors are dropped.
pub(super) fn loaded(
    arrays: &mut TouchArrays<'_>,
    energy_max: f32,
    at: &impl Fn(usize) -> [f32; 3],
) -> TwoFloat {
    let Some(state) = arrays.state.first().copied() else { return TwoFloat::ZERO };
    let first = if state.is_second { arrays.anchors.len() / 2 } else { 0 };
    let anchors = arrays.anchors.get_mut(first..first + state.anchors).unwrap_or_default();
    // Fade the released grips, and move all.
    for anchor in anchors {
        let Some(tool) = arrays.tools.get(usize::from(anchor.part) / PARTS_MAX) else { continue };
        if anchor.is_grip() {
            let share = anchor.share - tool.fade;
            anchor.share = if share > 0.0 { share } else { 0.0 };
        }
        anchor.follow(&tool.proxy);
    }
    let energy = energy_of(arrays, at);
    if state.anchors == 0 || energy.hi <= energy_max {
        return energy;
    }
    // Drop all anchors.
    for near in arrays.near.iter_mut().take(state.count) {
        near.held = 0;
    }
    if let Some(state) = arrays.state.first_mut() {
        state.anchors = 0;
    }
    energy_of(arrays, at)
}

/// Gives every sample in contact its anchor for the next tick. Returns the change of the energy, rounded up,
/// and whether some sample found no slot.
pub(super) fn renew_all(
    arrays: &mut TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
) -> (TwoFloat, bool) {
    let nothing = (TwoFloat::ZERO, false);
    let Some(slot) = arrays.state.first_mut() else { return nothing };
    if slot.count == 0 || (slot.friction <= 0.0 && slot.anchors == 0) {
        // Nothing is in reach or held: no anchor stays for a later tick.
        slot.anchors = 0;
        arrays.tools.iter_mut().for_each(|tool| tool.fade = 0.0);
        return nothing;
    }
    let state = *slot;
    let before = energy_of(arrays, at);
    let full = exchange(arrays, at, |sample, near, held| match held {
        Some(held) if !held.is_grip() || held.share > 0.0 => held.after(sample, state.friction),
        _ => Anchor::new(sample, near.index, near.of, state.friction),
    });
    // A tool that holds nothing has finished its release.
    for tool in 0..arrays.tools.len() {
        let holds = held_by(arrays, tool) > 0;
        if let Some(tool) = arrays.tools.get_mut(tool).filter(|_| !holds) {
            tool.fade = 0.0;
        }
    }
    (rise(before, energy_of(arrays, at)), full)
}

/// A tool grips its samples in contact where they are. Returns the number of samples and the change of the
/// energy.
pub(crate) fn take_hold(
    arrays: &mut TouchArrays<'_>,
    tool: usize,
    at: &impl Fn(usize) -> [f32; 3],
) -> (usize, TwoFloat) {
    let before = energy_of(arrays, at);
    let mut held = 0;
    exchange(arrays, at, |sample, near, anchor| {
        if near.tool() != tool || sample.depth <= 0.0 {
            return anchor.copied();
        }
        held += 1;
        Some(Anchor::grip(sample, near.index, near.of))
    });
    if let Some(tool) = arrays.tools.get_mut(tool) {
        tool.fade = 0.0;
    }
    (held, rise(before, energy_of(arrays, at)))
}

/// Writes the anchors after a tick's sweeps into the other half of the list, in triangle order, and switches to
/// it: `make` returns a sample's new anchor for its old one. Returns true if some found no slot.
fn exchange(
    arrays: &mut TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
    mut make: impl FnMut(&Sample, &NearTriangle, Option<&Anchor>) -> Option<Anchor>,
) -> bool {
    // Take the anchors of this tick, and the slots for the next ones.
    let Some(state) = arrays.state.first_mut() else { return false };
    let half = arrays.anchors.len() / 2;
    let Some((one, other)) = arrays.anchors.split_at_mut_checked(half) else { return false };
    let (from, to) = if state.is_second { (other, one) } else { (one, other) };
    let from = from.get(..state.anchors).unwrap_or(&[]);
    let slots = to.get_mut(..half).unwrap_or_default();
    // Visit every sample in contact or held.
    let (tools, mut count, mut full) = (Proxies(arrays.tools), 0, false);
    for near in arrays.near.get(..state.count).unwrap_or(&[]) {
        let (Some(solid), Some(tool)) = (tools.part(near.of), tools.0.get(near.tool())) else {
            continue;
        };
        let anchors = near.anchors_of(from);
        each_met(solid, near, from, near.corners.map(|cell| at(cell.into())), |sample| {
            let before = anchors.iter().find(|anchor| anchor.sample == sample.index);
            let Some(anchor) = make(sample, near, before) else { return };
            match slots.get_mut(count) {
                Some(slot) => {
                    *slot = anchor.fastened(&tool.proxy);
                    count += 1;
                }
                None => full = true,
            }
        });
    }
    // Switch, and assign the anchors to the triangles.
    (state.anchors, state.is_second) = (count, !state.is_second);
    let count = state.count;
    regroup(arrays, count);
    full
}

/// Number of samples that a tool grips.
pub(crate) fn held_by(arrays: &TouchArrays<'_>, tool: usize) -> usize {
    let is_of_tool = |anchor: &&Anchor| usize::from(anchor.part) / PARTS_MAX == tool;
    arrays.anchors().iter().filter(is_of_tool).filter(|anchor| anchor.is_grip()).count()
}
