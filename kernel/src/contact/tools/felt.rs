//! The contact of a tool whose force is published.
//!
//! A sweep publishes the points x, and finds those of the next pass, y': there the body is nearer to its
//! equilibrium under the tool. The force, the torque, the stiffness and the number of contacts are those at
//! y'; positions and energy are those at x. At rest the two are the same points.
//!
//! They are those at x if
//!
//! - the next pass starts at x: after a discarded pass, beyond K, and after a command that stops the body;
//! - friction or a grip holds a sample: its force is bounded by the pressure at x;
//! - the tool has no contact at x, or grows after it engaged in contact;
//! - a sample at y' is nearer to a core than half of the radius: it may be on its way past the tool;
//! - the body is one of links, which snap past small tools under deep presses;
//! - the energy of the contact at y' is above the level, so that the level bounds every published force: |F|^2
//!   is at most twice the stiffness times it.

use super::proxy_step::HALF;
use crate::contact::memory::TouchArrays;
use crate::energy::surface::{Meeting, ToolState};
use crate::model::Model;

/// Returns the contact of tool `number` after the sweeps of a tick with the certified level `level`, and true
/// if it is at the points `next` of the next pass, false if it is at the published points `at`.
#[inline(always)]
pub(super) fn felt(
    model: &Model<'_>,
    arrays: &TouchArrays<'_>,
    tool: &ToolState,
    number: usize,
    level: f32,
    at: &impl Fn(usize) -> [f32; 3],
    next: Option<&impl Fn(usize) -> [f32; 3]>,
) -> (Meeting, bool) {
    let may_be_ahead = model.is_nodal() && tool.proxy.share >= 1.0;
    let (tool, near, anchors) = ((&tool.proxy, number), arrays.near(), arrays.anchors());
    let met = Meeting::of(tool, (near, anchors), at);
    let Some(next) = next.filter(|_| may_be_ahead && anchors.is_empty() && met.touched > 0) else {
        return (met, false);
    };
    let ahead = Meeting::of(tool, (near, &[]), next);
    if ahead.energy.hi <= level && ahead.nearest >= HALF { (ahead, true) } else { (met, false) }
}
