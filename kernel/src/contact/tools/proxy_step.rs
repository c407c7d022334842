//! Motion of a tool's proxy towards its tool in a tick.

use super::start;
use crate::energy::surface::{Meeting, NearTriangle, Proxy, ToolState};
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::Turn;

/// Near the surface the proxy moves at most this share of the smallest radius per tick. A motion that lowers
/// the contact energy may bring samples as near to a core.
pub(super) const HALF: f32 = 0.5;
/// The tool presses only so far that no sample comes nearer to a core than this share of the part's radius,
/// and gives way up to here: soon, since tissue that has slipped farther past the tool comes back with a jump.
const FLOOR: f32 = 0.6;
/// If a sample comes nearer than this, the tool gives way: below [`FLOOR`] by more than the body trembles while
/// it settles.
const GIVES_WAY: f32 = 0.598;
/// Largest motion of the tissue towards the tool per tick, in radii.
pub(super) const COMING: f32 = 0.25;
/// Trials per tick to find the largest admissible motion.
const LOOKS: usize = 4;

/// A pose that a proxy moves to.
#[derive(Clone, Copy)]
struct Goal {
    pivot: [f32; 3],
    turn: Turn,
}

/// One tool's motion in a tick.
pub(super) struct ProxyStep<'a> {
    pub tool: &'a ToolState,
    pub number: usize,
    /// Bound of its contact energy.
    pub energy_max: f32,
    /// Lower bound of the surface's distance from its cores.
    pub distance: f32,
    /// Upper bound of the surface's distance from its pivot, for a tool with a half space.
    pub extent: f32,
    pub near: &'a [NearTriangle],
}

impl ProxyStep<'_> {
    fn met(&self, proxy: &Proxy, at: &impl Fn(usize) -> [f32; 3]) -> Meeting {
        Meeting::of((proxy, self.number), (self.near, &[]), at)
    }

    /// Returns the proxy's new position, and its contact there.
    pub fn go(&self, at: &impl Fn(usize) -> [f32; 3]) -> (Proxy, Meeting) {
        let from = &self.tool.proxy;
        if from.is_away() {
            return (*from, Meeting::NONE);
        }
        // Contact and size at the present position.
        let here = self.met(from, at);
        let share = if from.share < 1.0 { self.grown(at) } else { 1.0 };
        if let Some(found) = self.retreat(&here, at) {
            return found;
        }
        let turn = self.tool.target_turn;
        // If the tissue blocks the translation, the rotation alone may be free.
        for pivot in [self.tool.free_target(), from.pivot] {
            if let Some(found) = self.towards(Goal { pivot, turn }, share, &here, at) {
                return found;
            }
            if turn == from.turn && from.edge.crossing().is_there() {
                break;
            }
        }
        (*from, here)
    }

    /// Moves the proxy as far towards a pivot and a rotation as it may go from its contact `here`, with a
    /// share of its radii. Returns `None` if even the last trial is too far.
    fn towards(
        &self,
        to: Goal,
        share: f32,
        here: &Meeting,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<(Proxy, Meeting)> {
        let from = &self.tool.proxy;
        // Bound the step by the distance to the surface.
        let length = self.length(to);
        let radius = from.radius_min();
        let free = self.distance - from.radius_max();
        let near = HALF * from.share * radius;
        let stride = if free > near { free } else { near };
        let mut part = if length > stride { stride / length } else { 1.0 };
        // Shorten the step until it is neither too deep nor too much energy.
        for _ in 0..LOOKS {
            let next = self.between(to, part, share);
            let meeting = self.met(&next, at);
            let is_pressed = meeting.energy.hi > here.energy.hi;
            let least = share * if is_pressed { FLOOR } else { HALF };
            let floor = if here.nearest < least { here.nearest } else { least };
            let is_deep = meeting.nearest < floor;
            let is_loaded = is_pressed && meeting.energy.hi > self.energy_max;
            if !is_deep && !is_loaded {
                return Some((next, meeting));
            }
            // Try slightly less than the secant's root; half the step if the energy is too high.
            let (to_floor, fall) = (here.nearest - floor, here.nearest - meeting.nearest);
            let secant = 0.98 * to_floor / fall;
            let is_sound = !is_loaded && secant > 0.0;
            part *= if is_sound && secant < 0.9 {
                secant
            } else if is_sound {
                0.9
            } else {
                HALF
            };
            if is_deep && to_floor <= 0.0 {
                break;
            }
        }
        None
    }

    /// Upper bound of the motion of a core's point; for a half space, of the points near the surface.
    fn length(&self, to: Goal) -> f32 {
        let from = &self.tool.proxy;
        let step = sub(to.pivot, from.pivot);
        let spin = to.turn.after(from.turn.back()).small();
        let arm = from.arm();
        let arm = if self.extent > arm { self.extent } else { arm };
        sqrt(dot(step, step)) + arm * sqrt(dot(spin, spin))
    }

    /// The tool at a part of its motion, with a share of its radii.
    fn between(&self, to: Goal, part: f32, share: f32) -> Proxy {
        let from = &self.tool.proxy;
        let closed;
        let from = if from.edge.crossing().is_there() {
            from
        } else {
            closed = from.closed(part);
            &closed
        };
        if part >= 1.0 {
            return from.at(to.pivot, to.turn, share);
        }
        let pivot = add(from.pivot, scale(part, sub(to.pivot, from.pivot)));
        from.at(pivot, from.turn.towards(to.turn, part), share)
    }

    /// The share of its radii to which a tool grows: it need not give way then.
    fn grown(&self, at: &impl Fn(usize) -> [f32; 3]) -> f32 {
        let from = &self.tool.proxy;
        let whole = self.met(&from.at(from.pivot, from.turn, 1.0), at);
        let (grown, widest) = (start::grown(from.share), whole.nearest / FLOOR);
        let grown = if grown < widest { grown } else { widest };
        if grown > from.share { grown } else { from.share }
    }

    /// If the tissue has come too near to a core, moves the proxy out along the force, unless the tool itself
    /// moves farther out. That lowers the contact energy.
    fn retreat(&self, here: &Meeting, at: &impl Fn(usize) -> [f32; 3]) -> Option<(Proxy, Meeting)> {
        let from = &self.tool.proxy;
        let step = sub(self.tool.target, from.pivot);
        let lack = (FLOOR * from.share - here.nearest) * from.radius_min();
        let force = sqrt(dot(here.force, here.force));
        if !(here.nearest < GIVES_WAY * from.share && force > 0.0) {
            return None;
        }
        let out = scale(1.0 / force, here.force);
        if dot(out, step) > lack {
            return None;
        }
        let back = from.at(add(from.pivot, scale(lack, out)), from.turn, from.share);
        let meeting = self.met(&back, at);
        (meeting.energy.hi < here.energy.hi).then_some((back, meeting))
    }
}
