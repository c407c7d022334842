//! Anchors of friction and grips, from tick to tick.

use super::{energy_of, follow};
use crate::energy::surface::{
    Anchor, NearTriangle, PARTS_MAX, Proxies, Sample, ToolState, grip, renew,
};
use crate::number::two_float::TwoFloat;
use crate::tick::touch_room::TouchArrays;

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
        let own = anchors.iter().skip(next).take_while(|anchor| order(anchor) == key).count();
        (near.first, near.held) = (next as u16, own as u16);
        next += own;
    }
}

/// Moves anchors with their tools and fades released grips. Returns the contact energy of all tools; if it
/// exceeds `room`, all anchors are dropped.
pub(super) fn loaded(
    arrays: &mut TouchArrays<'_>,
    room: f32,
    at: &impl Fn(usize) -> [f32; 3],
) -> TwoFloat {
    let Some(state) = arrays.state.first().copied() else { return TwoFloat::ZERO };
    let first = if state.is_second { arrays.anchors.len() / 2 } else { 0 };
    let anchors = arrays.anchors.get_mut(first..first + state.anchors).unwrap_or_default();
    // Fade the released grips.
    for anchor in &mut *anchors {
        let tool = arrays.tools.get(usize::from(anchor.part) / PARTS_MAX);
        if anchor.is_grip()
            && let Some(tool) = tool
        {
            let share = anchor.share - tool.fade;
            anchor.share = if share > 0.0 { share } else { 0.0 };
        }
    }
    follow(anchors, arrays.tools);
    let energy = energy_of(arrays, at);
    if state.anchors == 0 || energy.hi <= room {
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
        _ => Anchor::new(sample, (near.index, near.of), state.friction),
    });
    // A tool that holds nothing has finished its release.
    for tool in 0..arrays.tools.len() {
        let holds = held_by(arrays, tool) > 0;
        if let Some(tool) = arrays.tools.get_mut(tool).filter(|_| !holds) {
            tool.fade = 0.0;
        }
    }
    let after = energy_of(arrays, at);
    let rounding = f32::EPSILON * (before.hi + after.hi);
    (after.minus(before).plus(rounding.into()), full)
}

/// A tool grips its samples in contact where they are. Returns the number of samples, the change of the
/// energy, and whether some sample found no slot.
pub(in crate::tick) fn take_hold(
    arrays: &mut TouchArrays<'_>,
    tool: usize,
    at: &impl Fn(usize) -> [f32; 3],
) -> (usize, TwoFloat, bool) {
    let before = energy_of(arrays, at);
    let mut held = 0;
    let full = exchange(arrays, at, |sample, near, anchor| {
        if near.tool() != tool || sample.depth <= 0.0 {
            return anchor.copied();
        }
        held += 1;
        Some(grip(sample, (near.index, near.of)))
    });
    if let Some(tool) = arrays.tools.get_mut(tool) {
        tool.fade = 0.0;
    }
    let after = energy_of(arrays, at);
    let rounding = f32::EPSILON * (before.hi + after.hi);
    (held, after.minus(before).plus(rounding.into()), full)
}

/// Writes the anchors into the other half of the list and switches to it.
fn exchange(
    arrays: &mut TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
    make: impl FnMut(&Sample, &NearTriangle, Option<&Anchor>) -> Option<Anchor>,
) -> bool {
    let Some(state) = arrays.state.first_mut() else { return false };
    let half = arrays.anchors.len() / 2;
    let Some((one, other)) = arrays.anchors.split_at_mut_checked(half) else { return false };
    let (from, to) = if state.is_second { (other, one) } else { (one, other) };
    let from = from.get(..state.anchors).unwrap_or(&[]);
    let near = arrays.near.get(..state.count).unwrap_or(&[]);
    let to = to.get_mut(..half).unwrap_or_default();
    let (count, full) = renew(Proxies(arrays.tools), near, (from, to), at, make);
    (state.anchors, state.is_second) = (count, !state.is_second);
    let count = state.count;
    regroup(arrays, count);
    full
}

/// Number of samples that a tool grips.
pub(in crate::tick) fn held_by(arrays: &TouchArrays<'_>, tool: usize) -> usize {
    let of = |anchor: &&Anchor| usize::from(anchor.part) / PARTS_MAX == tool;
    arrays.anchors().iter().filter(of).filter(|anchor| anchor.is_grip()).count()
}

impl ToolState {
    /// Returns true if the proxy is at the tool's pose.
    pub(super) fn is_at_target(&self) -> bool {
        self.proxy.pivot == self.target && self.proxy.turn == self.target_turn
    }

    /// Returns true if it also has its full size.
    pub(super) fn is_there(&self) -> bool {
        self.is_at_target() && self.proxy.share >= 1.0 && self.fade <= 0.0
    }
}
