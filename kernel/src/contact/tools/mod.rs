//! Contact of tools in a tick on a model with a contact surface, see [`surface`](crate::energy::surface).
//!
//! **The tissue meets a proxy of each tool.** The proxy follows the tool, with four exceptions, each marked
//! by flag 1 ([`MOTION_CLAMPED`](crate::Flags)) and made up for in later ticks:
//!
//! - **Never through.** It moves only so far that no sample comes nearer to a part's core than 0.6 of its
//!   radius; if the tissue itself comes nearer, the proxy gives way. A tool that goes deeper leaves its proxy
//!   at the surface, and the force stays. A blocked proxy may still rotate: a tool that rotates out of the
//!   tissue becomes free.
//! - **Never in again and again where it gave way.** Under a deep press the tissue slips around the tool, and
//!   comes back when the tool gives way: one that then goes in each time makes the force hum, by a third and
//!   more.
//! - It moves by at most half a radius per tick while the surface is near; far from it by at most the
//!   distance of the surface, so that it never jumps over it.
//! - It moves only so far as the model's largest energy allows. A motion that lowers the energy is never
//!   shortened.
//!
//! A tool that engages in contact or inside the body starts as `start` describes.
//!
//! **Energy.** The level changes by the term's energy change due to the moves at the present positions. The
//! hand feels less: the sweeps remove the rest from the body within the tick. The work charged to the device
//! is the mean of the published forces before and after times the displacement, plus the same of the torques
//! times the rotation, plus the same of an edge's force times the motion of the crossing of scissors.
//!
//! The sweeps remove all of that rest only where the body keeps up with the tool. Where it lags, as with one sweep a
//! tick under a fast tool, the tissue is pushed by the force before it gives way, and the hand feels the one after: the
//! energy may then exceed the work of the device. It never exceeds what the moves gave,
//! [`given_j`](crate::TissueMut::given_j).
//!
//! **Late ticks** move nothing: the proxies move in the next tick with a sweep.
//!
//! Cost per tick while engaged: one look at each triangle of the surface for each part of a tool, up to
//! thirteen looks at the samples of those in reach, and one per sweep; with friction or grips one more.
//!
//! - `engagement`: a tool engages, aims and releases; `start`: in contact or inside the body.
//! - `search`, `candidates`, `sieve`: the triangles in reach, one at a time or eight.
//! - `proxy_step`: motion of a proxy; `hold_back`: where it stays after it gave way several times.
//! - `energies`, `bounds`: contact energy of the tools, and stability bounds of the cells under them.
//! - `anchors`: friction and grips from tick to tick.
//! - `felt`: the contact whose force is published; `forces`: the contacts of each triangle.
//! - `pins`: pins from tick to tick.
//! - `choice`: tools are chosen.

mod anchors;
mod bounds;
mod candidates;
mod choice;
mod energies;
mod engagement;
mod felt;
mod forces;
mod hold_back;
mod pins;
mod proxy_step;
mod search;
mod sieve;
mod start;

use super::Acting;
use super::context::Context;
use super::memory::{TouchArrays, TouchRoom};
use super::output::ToolOutput;
use super::pose::ToolPose;
use crate::energy::residual::{Terms, places};
use crate::energy::surface::{PINS_ARE_BUILT, Proxies, TOOLS_MAX, ToolState};
use crate::model::Model;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::clamp::finite;
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;
use crate::solver::coarse::{Coarse, Under};
use candidates::Near;
pub(crate) use energies::rise;
use energies::{energies_of, energy_of};
use engagement::{Edge, internal};
use proxy_step::{COMING, HALF, ProxyStep};
use search::search;
use sieve::EightWide;

pub(crate) use anchors::{held_by, take_hold};
pub use choice::FRICTION_MAX;
pub(crate) use choice::{check, choose};
pub use forces::ContactForce;
pub(crate) use forces::forces;
pub(crate) use pins::{NewPin, pin_held};
#[cfg(feature = "cut")]
pub(crate) use pins::{drop_empty, energy_of_pins};

/// Tools on the surface.
pub(crate) struct Tools<'a> {
    pub memory: TouchRoom<'a>,
    /// Number of basis functions under the tools, whose resistance the coarse level takes into account.
    pub resisted: &'a mut Option<u16>,
}

impl Tools<'_> {
    /// Moves the tools towards their poses, or releases them.
    // Not inlined, as `book`: its frame is off the stack during the sweeps.
    #[inline(never)]
    pub fn advance<D: Dynamics>(&mut self, context: &mut Context<'_, '_, D>, poses: &[ToolPose]) {
        if context.is_engaged != context.was_engaged {
            if !context.is_engaged {
                self.leave(context);
            }
            *self.resisted = Some(0);
            self.memory.note_pins();
        }
        let is_held = self.hold(context);
        let is_moved = context.is_engaged && self.press(context, poses);
        if is_held
            && !is_moved
            && let Some(mut arrays) = self.memory.arrays(context.state.len())
        {
            let count = arrays.near().len();
            bounds::enclose(context.terms.model, &mut arrays, count);
        }
        if is_moved || is_held {
            self.prepare(context);
        }
    }

    /// Fades the released pins. Returns true if bounds and coarse level have to be found anew for the pins.
    fn hold<D: Dynamics>(&mut self, context: &mut Context<'_, '_, D>) -> bool {
        if !PINS_ARE_BUILT || context.is_late {
            return false;
        }
        let Some(mut arrays) = self.memory.arrays(context.state.len()) else { return false };
        let change = pins::fade(&mut arrays, &places(context.terms.model, context.state));
        let holds = !arrays.pins().is_empty();
        let Some(state) = arrays.state.first_mut() else { return false };
        let is_new = core::mem::take(&mut state.pins_changed) || (holds && !state.is_filled);
        if let Some(change) = change.filter(|change| *change != TwoFloat::ZERO) {
            context.disturb(change);
        }
        is_new || change.is_some()
    }

    pub fn acting<D: Dynamics>(&mut self, context: &Context<'_, '_, D>) -> Acting<'_, D::Number> {
        let coarse = self.resisted.map(Coarse::Resisted);
        let Some(arrays) = self.memory.arrays(context.state.len()) else {
            return Acting { coarse, ..Acting::NONE };
        };
        let (touch, coarse_touch) = arrays.touching(context.model());
        Acting { coarse, touch, coarse_touch, ..Acting::NONE }
    }

    /// Moves the tools. Returns true if the coarse level has to be prepared.
    fn press<D: Dynamics>(&mut self, context: &mut Context<'_, '_, D>, poses: &[ToolPose]) -> bool {
        // Note the energy before, and set targets and engagement.
        let model = context.terms.model;
        let at = places(model, context.state);
        let sleeps = context.awake.set.is_empty(model.slice_count());
        let Some(mut arrays) = self.memory.arrays(context.state.len()) else { return false };
        let nothing = (TwoFloat::ZERO, [0.0; TOOLS_MAX]);
        let (before, each) = if context.is_late { nothing } else { energies_of(&arrays, &at) };
        let (mut edges, mut stays) = ([Edge::None; TOOLS_MAX], true);
        for (number, (tool, edge)) in arrays.tools.iter_mut().zip(&mut edges).enumerate() {
            let pose = poses.get(number);
            let is_short = pose.is_some_and(|pose| tool.aim(model, pose, context.step_max));
            context.is_clamped |= is_short;
            if !context.is_late {
                *edge = tool.engage(pose);
                stays &= *edge == Edge::None && (!tool.is_in || tool.is_there());
            }
        }
        // Note the displacement of the first tool.
        if let Some(tool) = arrays.tools.first() {
            *context.applied = sub(tool.target, internal(model, context.origin_m));
        }
        if context.is_late || (stays && sleeps) {
            return false;
        }
        // Search the triangles in reach, and move the proxies.
        let Some(surface) = model.contact_surface() else { return false };
        let eight =
            EightWide::of(context.terms.vectors, context.state, model.cells(), model.saturation());
        let anchors = arrays.state.first().map_or(&[][..], |state| state.present(arrays.anchors));
        let reach = HALF + COMING;
        let found = search(&surface, &at, arrays.tools, reach, anchors, arrays.near, eight);
        context.is_full |= found.full;
        anchors::regroup(&mut arrays, found.count);
        let most = model.energy_max();
        let most = most - (context.level.at_most(most) - before.hi);
        let (moved, going) = move_proxies(model, &mut arrays, &found, &edges, most, &each, &at);
        context.is_clamped |= arrays.tools.iter().any(|tool| tool.is_in && !tool.is_at_target());
        // Update bounds and level by the change of the energy.
        bounds::enclose(model, &mut arrays, found.count);
        let after = anchors::loaded(&mut arrays, most, &at);
        if before != TwoFloat::ZERO || after != TwoFloat::ZERO {
            if before != after {
                let rise = rise(before, after);
                *context.given += rise.hi;
                context.level.shift(rise);
            }
            context.awake.wake_all(model);
            if moved || !stays {
                context.dynamics.pushed();
                context.dynamics.goes_on(going);
            }
        }
        true
    }

    /// Prepares the coarse level for the tools: an elastic one for their contacts; the one of links, on which
    /// the level's certificate relies, for all triangles in reach.
    fn prepare<D: Dynamics>(&mut self, context: &mut Context<'_, '_, D>) {
        let model = context.terms.model;
        let at = places(model, context.state);
        let Some(mut arrays) = self.memory.arrays(context.state.len()) else { return };
        let bounds = bounds::of_corners(arrays.near(), arrays.pins());
        *self.resisted = D::resist(model, context.coarse_memory, bounds);
        let [coarse, ..] = core::mem::take(&mut arrays.coarse) else { return };
        let (near, anchors, pins) = (arrays.near(), arrays.anchors(), arrays.pins());
        let terms = Terms::of(model, context.terms.states);
        let under = Under { tools: Proxies(arrays.tools), near, anchors, pins };
        coarse.prepare(terms, under, &at);
    }

    /// Releases all tools and removes their contact energy from the level.
    fn leave<D: Dynamics>(&mut self, context: &mut Context<'_, '_, D>) {
        let model = context.terms.model;
        let Some(mut arrays) = self.memory.arrays(context.state.len()) else { return };
        let energy = energy_of(&arrays, &places(model, context.state));
        arrays.tools.iter_mut().for_each(ToolState::leave);
        bounds::enclose(model, &mut arrays, 0);
        for state in &mut *arrays.state {
            state.anchors = 0;
        }
        if energy != TwoFloat::ZERO {
            context.disturb(rise(energy, TwoFloat::ZERO));
        }
    }

    /// Computes the contacts after the sweeps, and books the work of the tools' moves.
    #[inline(never)]
    pub fn book<D: Dynamics>(&mut self, context: &mut Context<'_, '_, D>) {
        let model = context.terms.model;
        let Some(mut arrays) = self.memory.arrays(context.state.len()) else { return };
        // Make tools wait that the sweeps have left inside the body.
        let change = start::closed_over(model, &mut arrays, &places(model, context.state));
        if let Some(change) = change {
            context.disturb(change);
        }
        // Renew the anchors.
        let at = places(model, context.state);
        let (change, full) = anchors::renew_all(&mut arrays, &at);
        context.is_full |= full;
        if change != TwoFloat::ZERO {
            context.level.shift(change);
        }
        // Book each tool's work and note its contact.
        let next = context.dynamics.next_points(context.scheme_arrays, model.cells());
        let (next, level) = (next.map(|next| places(model, next)), context.level.published());
        let mut work = 0.0;
        for number in 0..arrays.tools.len() {
            let Some(tool) = arrays.tools.get(number).filter(|tool| tool.is_in) else { continue };
            let (met, is_ahead) =
                felt::felt(model, &arrays, tool, number, level, &at, next.as_ref());
            let force = add(tool.met.force, met.force);
            let torque = add(tool.met.torque, met.torque);
            let mut of_tool = -0.5 * (dot(force, tool.way) + dot(torque, tool.spin));
            let crossing = tool.proxy.edge.crossing();
            let push = crossing.is_any().then(|| match next.as_ref().filter(|_| is_ahead) {
                Some(next) => tool.proxy.edge.push(next),
                None => tool.proxy.edge.push(&at),
            });
            if let Some(push) = push {
                of_tool -= 0.5 * (crossing.push + push) * crossing.slid;
            }
            work += of_tool;
            if let Some(tool) = arrays.tools.get_mut(number) {
                (tool.met, tool.is_ahead, tool.work) = (met, is_ahead, of_tool);
                if let Some((crossing, push)) = tool.proxy.edge.crossing_mut().zip(push) {
                    crossing.push = push;
                }
            }
        }
        context.work = work.into();
    }
}

impl TouchRoom<'_> {
    /// Returns true if an engaged tool waits inside the tissue without contact.
    pub(crate) fn waits(&self) -> bool {
        self.tools().iter().any(ToolState::waits)
    }

    /// Output of a tool in the last tick with a sweep; zero while it is not engaged.
    pub(crate) fn output(&self, model: &Model<'_>, tool: usize) -> ToolOutput {
        let Some(tool) = self.tool(tool) else { return ToolOutput::NONE };
        let torque_n_m = scale(model.force_unit_n() * model.unit_m(), tool.met.torque).map(finite);
        ToolOutput {
            force_n: scale(model.force_unit_n(), tool.met.force).into(),
            torque_n_m: torque_n_m.into(),
            work_j: finite(tool.work * model.energy_unit_j()),
            // The term's energy is in units of 2 k_ref.
            stiffness_n_per_m: finite(2.0 * model.stiffness_n_per_m() * tool.met.stiffness),
            contacts: tool.met.touched,
        }
    }

    /// Stiffness against the rotation of a tool within its last tick with a sweep \[N m\].
    pub(crate) fn turning_n_m(&self, model: &Model<'_>, tool: usize) -> f32 {
        let unit_m = model.unit_m();
        let turning = self.tool(tool).map_or(0.0, |tool| tool.met.turning);
        finite(2.0 * model.stiffness_n_per_m() * turning * (unit_m * unit_m))
    }

    /// Way of a tool since its last tick with a sweep \[m\], and the angle by which it has turned.
    pub(crate) fn since(&self, model: &Model<'_>, tool: usize) -> [f32; 2] {
        let Some(tool) = self.tool(tool).filter(|tool| !tool.is_at_target()) else {
            return [0.0; 2];
        };
        let way = sub(tool.target, tool.proxy.pivot);
        let turn = tool.target_turn.after(tool.proxy.turn.back()).small();
        [model.unit_m() * sqrt(dot(way, way)), sqrt(dot(turn, turn))]
    }
}

/// Moves the proxies towards their tools, within an energy of all contacts. Returns whether a proxy changed,
/// and this tick's motion along the last one's, 0 to 1.
fn move_proxies(
    model: &Model<'_>,
    arrays: &mut TouchArrays<'_>,
    found: &Near,
    edges: &[Edge; TOOLS_MAX],
    energy_max: f32,
    each: &[f32; TOOLS_MAX],
    at: &impl Fn(usize) -> [f32; 3],
) -> (bool, f32) {
    // Contact energy of the other tools: new for those already moved, old for the rest.
    let (mut moved, mut taken) = (false, each.iter().fold(0.0, |sum, energy| sum + energy));
    let (mut along, mut last) = (0.0, 0.0);
    let reach = found.distance.iter().zip(&found.extent);
    for (number, (&edge, (&distance, &extent))) in edges.iter().zip(reach).enumerate() {
        taken -= each.get(number).copied().unwrap_or(0.0);
        let Some(tool) = arrays.tools.get(number).filter(|tool| tool.is_in) else { continue };
        let near = arrays.near();
        let is_new = edge != Edge::None;
        let energy_max = energy_max - taken;
        // Start or move the proxy.
        let (proxy, met) = if is_new {
            start::begun(model, tool, number, edge == Edge::Waits, energy_max, near, at)
        } else {
            ProxyStep { tool, number, energy_max, distance, extent, near }.go(at)
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
            tool.proxy = proxy;
            let mut way = tool.way;
            if let Some(crossing) = tool.proxy.edge.crossing_mut().filter(|_| !is_new) {
                crossing.slid = crossing.at - from.edge.crossing().at;
                way = add(way, tool.proxy.edge.slid());
            }
            along += dot(way, tool.way_before);
            last += dot(tool.way_before, tool.way_before);
            tool.way_before = way;
            if !is_new {
                tool.hold_back(from.pivot, &met);
            }
        }
    }
    let ratio = if along > 0.0 { along / last } else { 0.0 };
    (moved, if ratio < 1.0 { ratio } else { 1.0 })
}
