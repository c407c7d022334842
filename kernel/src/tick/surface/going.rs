//! How far a tool's proxy goes towards its tool in a tick.

use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::Turn;
use crate::terms::surface::{Meeting, NearTriangle, Proxy, ToolState};

/// Where a sample comes nearer to a core than this share of the part's radius the tool gives way, and
/// it goes no farther in a tick near the surface.
pub(super) const HALF: f32 = 0.5;
/// The tool presses only so far that no sample comes nearer than this, and gives way up to here. Between
/// the two it stays: without room between them it would give way and come back in turn, farther each
/// time, until the tissue slips past its middle.
const FLOOR: f32 = 0.6;
/// How far the tissue may come towards the tool in a tick, in radii.
pub(super) const COMING: f32 = 0.25;
/// Growth of a tool that was engaged inside the body.
const GROWTH: f32 = 1.1;
/// Looks for how far it may go.
const LOOKS: usize = 4;

/// A tool that goes.
pub(super) struct Go<'a> {
    pub tool: &'a ToolState,
    pub number: usize,
    pub is_new: bool,
    /// What its energy of contact may become.
    pub room: f32,
    /// At most the distance of the surface from its cores.
    pub distance: f32,
    /// At least the distance of the surface from its pivot, where it has a half space.
    pub extent: f32,
    pub near: &'a [NearTriangle],
}

impl Go<'_> {
    fn met(&self, proxy: &Proxy, at: &impl Fn(usize) -> [f32; 3]) -> Meeting {
        Meeting::of((proxy, self.number), (self.near, &[]), at)
    }

    /// The proxy where it goes to, and the contact that it meets there.
    pub fn go(&self, at: &impl Fn(usize) -> [f32; 3]) -> (Proxy, Meeting) {
        let from = &self.tool.proxy;
        let here = self.met(from, at);
        if self.is_new {
            return self.begin(&here, at);
        }
        let share = grown(from.share, here.nearest);
        let way = sub(self.tool.target, from.pivot);
        if let Some(found) = self.retreat(&here, way, at) {
            return found;
        }
        let turn = self.tool.target_turn;
        // What is in the way of going may not be in that of turning out of it.
        for pivot in [self.tool.target, from.pivot] {
            if let Some(found) = self.towards((pivot, turn), (share, &here), at) {
                return found;
            }
            if turn == from.turn {
                break;
            }
        }
        (*from, here)
    }

    /// The proxy as far on its way to a place and a turn as it may go from where it meets `here`, with a
    /// share of its radii; none where a first step is too far.
    fn towards(
        &self,
        to: ([f32; 3], Turn),
        (share, here): (f32, &Meeting),
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<(Proxy, Meeting)> {
        let from = &self.tool.proxy;
        let length = self.length(to);
        let radius = from.radius_min();
        let free = self.distance - from.radius_max();
        let stride = if free > HALF * radius { free } else { HALF * radius };
        let mut part = if length > stride { stride / length } else { 1.0 };
        for _ in 0..LOOKS {
            let next = self.between(to, part, share);
            let meeting = self.met(&next, at);
            let is_pressed = meeting.energy.hi > here.energy.hi;
            let least = share * if is_pressed { FLOOR } else { HALF };
            let floor = if here.nearest < least { here.nearest } else { least };
            let is_deep = meeting.nearest < floor;
            let is_loaded = is_pressed && meeting.energy.hi > self.room;
            if !is_deep && !is_loaded {
                return Some((next, meeting));
            }
            // A secant between here and there, a little less than it says; half the way for the
            // energy.
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

    /// At most the way of a point of its cores; of a half space, of those that the surface may be at.
    fn length(&self, (target, turn): ([f32; 3], Turn)) -> f32 {
        let from = &self.tool.proxy;
        let way = sub(target, from.pivot);
        let spin = turn.after(from.turn.back()).small();
        let arm = from.arm();
        let arm = if self.extent > arm { self.extent } else { arm };
        sqrt(dot(way, way)) + arm * sqrt(dot(spin, spin))
    }

    /// The tool at a part of a way, with a share of its radii.
    fn between(&self, (target, turn): ([f32; 3], Turn), part: f32, share: f32) -> Proxy {
        let from = &self.tool.proxy;
        if part >= 1.0 {
            return from.at(target, turn, share);
        }
        let pivot = add(from.pivot, scale(part, sub(target, from.pivot)));
        from.at(pivot, from.turn.towards(turn, part), share)
    }

    /// A tool that was engaged: as large as it has room for.
    fn begin(&self, here: &Meeting, at: &impl Fn(usize) -> [f32; 3]) -> (Proxy, Meeting) {
        let (from, widest) = (&self.tool.proxy, 2.0 * here.nearest);
        let with = |share| from.at(from.pivot, from.turn, share);
        let mut share = if widest < 1.0 { widest } else { 1.0 };
        for _ in 0..LOOKS {
            let meeting = self.met(&with(share), at);
            if meeting.energy.hi <= self.room {
                return (with(share), meeting);
            }
            share *= HALF;
        }
        (with(0.0), Meeting::NONE)
    }

    /// Where the tissue has come nearer to a core than half a radius: out along the force, unless the tool
    /// goes farther out by itself. That lowers the energy of contact.
    fn retreat(
        &self,
        here: &Meeting,
        way: [f32; 3],
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<(Proxy, Meeting)> {
        let from = &self.tool.proxy;
        let lack = (FLOOR * from.share - here.nearest) * from.radius_min();
        let force = sqrt(dot(here.force, here.force));
        if !(here.nearest < HALF * from.share && force > 0.0) {
            return None;
        }
        let out = scale(1.0 / force, here.force);
        if dot(out, way) > lack {
            return None;
        }
        let back = from.at(add(from.pivot, scale(lack, out)), from.turn, from.share);
        let meeting = self.met(&back, at);
        (meeting.energy.hi < here.energy.hi).then_some((back, meeting))
    }
}

/// The share of its radii that a tool grows to.
fn grown(share: f32, nearest: f32) -> f32 {
    let widest = 2.0 * nearest;
    let grown = GROWTH * share + 0.01;
    let grown = if grown < widest { grown } else { widest };
    let grown = if grown > share { grown } else { share };
    if grown < 1.0 { grown } else { 1.0 }
}
