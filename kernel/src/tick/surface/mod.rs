//! Contact of tools in a tick on a model with a contact surface, see [`surface`](crate::energy::surface).
//!
//! **The tissue meets a proxy of each tool.** The proxy follows the tool, with three exceptions, each marked
//! by flag 1 ([`Flags::MOTION_CLAMPED`]) and made up for in later ticks:
//!
//! - **Never through.** It moves only so far that no sample comes nearer to a part's core than 0.6 of its
//!   radius; if the tissue itself comes nearer than half, the proxy gives way. A tool that goes deeper leaves
//!   its proxy at the surface, and the force stays. A blocked proxy may still rotate: a tool that rotates out
//!   of the tissue becomes free.
//! - It moves by at most half a radius per tick while the surface is near; far from it by at most the
//!   distance of the surface, so that it never jumps over it.
//! - It moves only so far as the model's largest energy allows. A motion that lowers the energy is never
//!   shortened.
//!
//! A tool that engages in contact or inside the body starts as [`begin`](crate::tick::begin) describes.
//!
//! **Energy.** The level changes by the term's energy change due to the moves at the present positions. The
//! hand feels less: the sweeps remove the rest from the body within the tick. The work charged to the device
//! is the mean of the forces before and after times the displacement, plus the same of the torques times the
//! rotation.
//!
//! **Late ticks** move nothing: the proxies move in the next tick with a sweep.
//!
//! Cost per tick while engaged: one look at each triangle of the surface for each part of a tool, up to
//! twelve looks at the samples of those in reach, and one per sweep; with friction or grips two more.
//!
//! - `going`: motion of a proxy.
//! - `inside`: tools inside the body.
//! - `bounds`: stability bounds of the cells under tools.

mod bounds;
mod going;
mod hold;
mod inside;

use super::order::Tick;
use super::pose::ToolPose;
use super::sample::Flags;
use super::touch_room::TouchArrays;
use crate::energy::held::approach;
use crate::energy::residual::Terms;
use crate::energy::surface::{
    Anchor, EightWide, Meeting, Near, PARTS_MAX, Proxies, TOOLS_MAX, ToolState, search,
};
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{Cell, add, dot, output, single, sub};
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;
use crate::solver::coarse::Under;
use going::{COMING, Go, HALF};
pub(super) use hold::{held_by, take_hold};

/// Largest coordinate of a tool [mean link lengths], so that its square stays finite.
const PLACE_MAX: f32 = 2.0e6;

/// Published cell positions in single precision.
pub(super) fn places<'a, N: Number>(
    model: &Model<'_>,
    state: &'a [Cell<N>],
) -> impl Fn(usize) -> [f32; 3] + use<'a, N> {
    let k = N::from_single(model.saturation());
    move |cell| state.get(cell).map_or([0.0; 3], |v| single(output(v.xyz(), k)))
}

/// Contact energy of all engaged tools, and of each.
fn energies_of(
    arrays: &TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
) -> (TwoFloat, [f32; TOOLS_MAX]) {
    let mut own = [0.0; TOOLS_MAX];
    let each = arrays.tools.iter().zip(&mut own).enumerate().filter(|(_, (tool, _))| tool.is_in);
    let all = each.fold(TwoFloat::ZERO, |sum, (number, (tool, own))| {
        let among = (arrays.near(), arrays.anchors());
        let energy = Meeting::of((&tool.proxy, number), among, at).energy;
        *own = energy.hi;
        sum.plus(energy)
    });
    (all, own)
}

/// Contact energy of all engaged tools.
fn energy_of(arrays: &TouchArrays<'_>, at: &impl Fn(usize) -> [f32; 3]) -> TwoFloat {
    energies_of(arrays, at).0
}

/// Converts a position in the mesh's frame \[m\] to mean link lengths from the body's centre.
fn internal(model: &Model<'_>, position_m: [f32; 3]) -> [f32; 3] {
    sub(position_m, model.centre_m()).map(|way| (way / model.unit_m()).clamp(-PLACE_MAX, PLACE_MAX))
}

/// Change of a tool's engagement in a tick.
#[derive(Clone, Copy, PartialEq)]
enum Edge {
    None,
    In,
    /// The tool is engaged and has waited inside the body.
    Waits,
    Out,
}

impl ToolState {
    /// Returns true if the tool is engaged and has no contact yet.
    pub(crate) fn waits(&self) -> bool {
        self.is_in && self.proxy.is_away()
    }

    /// Starts a tick: the tool engages or releases. One that waits engages anew.
    fn engage(&mut self, pose: Option<&ToolPose>) -> Edge {
        (self.way, self.spin) = ([0.0; 3], [0.0; 3]);
        match pose.map(|pose| pose.engaged == 1) {
            Some(true) if !self.is_in || self.waits() => {
                let edge = if self.waits() { Edge::Waits } else { Edge::In };
                self.proxy = self.proxy.at(self.target, self.target_turn, 1.0);
                self.is_in = true;
                edge
            }
            Some(false) if self.is_in => {
                self.leave();
                Edge::Out
            }
            _ => Edge::None,
        }
    }

    /// Releases the tool.
    pub(crate) fn leave(&mut self) {
        self.is_in = false;
        self.met = Meeting::NONE;
        (self.way, self.spin, self.fade) = ([0.0; 3], [0.0; 3], 0.0);
    }

    /// Sets the target from a pose, within the step limit. Returns true if the limit shortened it.
    fn aim(&mut self, model: &Model<'_>, pose: &ToolPose, step: f32) -> bool {
        let wished = internal(model, pose.position_m.into());
        if let Some(turn) = pose.turn() {
            self.target_turn = turn;
        }
        if !self.is_in || self.waits() {
            self.target = wished;
            return false;
        }
        let (to, is_short) = approach(self.target, wished, step);
        self.target = to;
        is_short
    }
}

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Moves the tools towards their poses.
    pub(super) fn press(&mut self, poses: &[ToolPose]) {
        if self.go(poses) {
            self.prepare();
        }
    }

    /// Moves the tools. Returns true if the coarse level has to be prepared.
    fn go(&mut self, poses: &[ToolPose]) -> bool {
        // Note the energy before, and set targets and engagement.
        let model = self.network.model();
        let step = self.network.settings().max_tool_step_m / model.unit_m();
        let at = places(model, &*self.state);
        let sleeps = self.head.awake.set.is_empty(model.slice_count());
        let Some(mut arrays) = self.touch.arrays(self.state.len()) else { return false };
        let nothing = (TwoFloat::ZERO, [0.0; TOOLS_MAX]);
        let (before, own) = if self.is_late { nothing } else { energies_of(&arrays, &at) };
        let (mut edges, mut stays) = ([Edge::None; TOOLS_MAX], true);
        for (number, (tool, edge)) in arrays.tools.iter_mut().zip(&mut edges).enumerate() {
            let pose = poses.get(number);
            if pose.is_some_and(|pose| tool.aim(model, pose, step)) {
                self.flags.insert(Flags::MOTION_CLAMPED);
            }
            if !self.is_late {
                *edge = tool.engage(pose);
                stays &= *edge == Edge::None && (!tool.is_in || tool.is_there());
            }
        }
        // Note the displacement of the first tool.
        if let Some(tool) = arrays.tools.first() {
            let start = internal(model, self.head.tool_origin_m);
            self.head.applied = sub(tool.target, start);
        }
        if self.is_late || (stays && sleeps) {
            return false;
        }
        // Search the triangles in reach, and move the proxies.
        let Some(surface) = model.contact_surface() else { return false };
        let eight = EightWide::of(self.head.vectors, &*self.state, model.saturation());
        let anchors = arrays.state.first().map_or(&[][..], |state| state.present(arrays.anchors));
        let tools = (&*arrays.tools, HALF + COMING);
        let found = search(&surface, &at, tools, anchors, arrays.near, eight);
        if found.full {
            self.flags.insert(Flags::CONTACT_CAPACITY);
        }
        hold::regroup(&mut arrays, found.count);
        let room = model.energy_max() - (self.head.level.at_most(model.energy_max()) - before.hi);
        let (moved, going) = advance(model, &mut arrays, &found, (edges, room, own), &at);
        if arrays.tools.iter().any(|tool| tool.is_in && !tool.is_at_target()) {
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        // Update bounds and level by the change of the energy.
        bounds::enclose(model, &mut arrays, found.count);
        let after = hold::loaded(&mut arrays, room, &at);
        if before != TwoFloat::ZERO || after != TwoFloat::ZERO {
            if before != after {
                let rounding = f32::EPSILON * (before.hi + after.hi);
                self.head.level.shift(after.minus(before).plus(rounding.into()));
            }
            self.head.awake.wake_all(model);
            if moved || !stays {
                self.head.dynamics.pushed();
                self.head.dynamics.goes_on(going);
            }
        }
        true
    }

    /// Prepares the coarse level for the tools: an elastic one for their contacts; the one of links, on which
    /// the level's certificate relies, for all triangles in reach.
    fn prepare(&mut self) {
        let model = self.network.model();
        let terms = Terms::of(model, self.states);
        let at = places(model, &*self.state);
        let Some(mut arrays) = self.touch.arrays(self.state.len()) else { return };
        self.head.resisted = D::resist(model, self.room, bounds::of_corners(arrays.near()));
        let [coarse, ..] = core::mem::take(&mut arrays.coarse) else { return };
        let (near, anchors) = (arrays.near(), arrays.anchors());
        coarse.prepare(terms, Under { tools: Proxies(arrays.tools), near, anchors }, &at);
    }

    /// Releases all tools and removes their contact energy from the level.
    pub(super) fn leave_surface(&mut self) {
        let model = self.network.model();
        let at = places(model, &*self.state);
        let Some(mut arrays) = self.touch.arrays(self.state.len()) else { return };
        let energy = energy_of(&arrays, &at);
        arrays.tools.iter_mut().for_each(ToolState::leave);
        bounds::enclose(model, &mut arrays, 0);
        for state in &mut *arrays.state {
            state.anchors = 0;
        }
        if energy != TwoFloat::ZERO {
            let rounding = f32::EPSILON * energy.hi;
            self.head.level.shift(TwoFloat::ZERO.minus(energy).plus(rounding.into()));
            self.head.awake.wake_all(model);
            self.head.dynamics.pushed();
        }
    }

    /// Computes the contacts after the sweeps. Books the work of the tools' moves and returns the force on
    /// the first tool in internal units.
    pub(super) fn feel(&mut self) -> [f32; 3] {
        self.leave_inside();
        let model = self.network.model();
        let at = places(model, &*self.state);
        let Some(mut arrays) = self.touch.arrays(self.state.len()) else { return [0.0; 3] };
        // Renew the anchors.
        let (change, full) = hold::renew_all(&mut arrays, &at);
        if full {
            self.flags.insert(Flags::CONTACT_CAPACITY);
        }
        if change != TwoFloat::ZERO {
            self.head.level.shift(change);
        }
        // Book each tool's work and note its contact.
        let mut work = 0.0;
        for number in 0..arrays.tools.len() {
            let Some(tool) = arrays.tools.get(number).filter(|tool| tool.is_in) else { continue };
            let met = Meeting::of((&tool.proxy, number), (arrays.near(), arrays.anchors()), &at);
            let (force, torque) =
                (add(tool.met.force, met.force), add(tool.met.torque, met.torque));
            let own = -0.5 * (dot(force, tool.way) + dot(torque, tool.spin));
            work += own;
            if let Some(tool) = arrays.tools.get_mut(number) {
                (tool.met, tool.work) = (met, own);
            }
        }
        self.work = work.into();
        arrays.tools.first().map_or([0.0; 3], |tool| tool.met.force)
    }
}

/// Moves the proxies towards their tools. Returns whether a proxy changed, and this tick's motion along the
/// last one's, 0 to 1.
fn advance(
    model: &Model<'_>,
    arrays: &mut TouchArrays<'_>,
    found: &Near,
    (edges, room, own): ([Edge; TOOLS_MAX], f32, [f32; TOOLS_MAX]),
    at: &impl Fn(usize) -> [f32; 3],
) -> (bool, f32) {
    // Contact energy of the other tools: new for those already moved, old for the rest.
    let (mut moved, mut taken) = (false, own.iter().fold(0.0, |sum, own| sum + own));
    let (mut along, mut last) = (0.0, 0.0);
    let reach = found.distance.iter().zip(&found.extent);
    for (number, (&edge, (&distance, &extent))) in edges.iter().zip(reach).enumerate() {
        taken -= own.get(number).copied().unwrap_or(0.0);
        let Some(tool) = arrays.tools.get(number).filter(|tool| tool.is_in) else { continue };
        let near = arrays.near();
        let is_new = edge != Edge::None;
        let room = room - taken;
        // Start or move the proxy.
        let (proxy, met) = if is_new {
            inside::begun(model, (tool, number), (edge == Edge::Waits, room), near, at)
        } else {
            Go { tool, number, room, distance, extent, near }.go(at)
        };
        taken += met.energy.hi;
        let from = tool.proxy;
        // Note its motion, for the work and for the extrapolation.
        if let Some(tool) = arrays.tools.get_mut(number) {
            if !is_new {
                tool.way = sub(proxy.pivot, from.pivot);
                tool.spin = proxy.turn.after(from.turn.back()).small();
            }
            moved |= proxy != from || is_new;
            along += dot(tool.way, tool.way_before);
            last += dot(tool.way_before, tool.way_before);
            tool.way_before = tool.way;
            tool.proxy = proxy;
        }
    }
    let ratio = if along > 0.0 { along / last } else { 0.0 };
    (moved, if ratio < 1.0 { ratio } else { 1.0 })
}

/// Moves anchors with their tools.
fn follow(anchors: &mut [Anchor], tools: &[ToolState]) {
    for anchor in anchors {
        if let Some(tool) = tools.get(usize::from(anchor.part) / PARTS_MAX) {
            anchor.follow(&tool.proxy);
        }
    }
}
