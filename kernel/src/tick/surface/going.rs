//! How far a tool's proxy goes towards its tool in a tick.

use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::Turn;
use crate::terms::surface::{Meeting, NearTriangle, Proxy, ToolState};
use crate::tick::begin;

/// Where a sample comes nearer to a core than this share of the part's radius the tool gives way, and
/// it goes no farther in a tick near the surface.
pub(super) const HALF: f32 = 0.5;
/// The tool presses only so far that no sample comes nearer than this, and gives way up to here. Between
/// the two it stays: without room between them it would give way and come back in turn, farther each
/// time, until the tissue slips past its middle.
const FLOOR: f32 = 0.6;
/// How far the tissue may come towards the tool in a tick, in radii.
pub(super) const COMING: f32 = 0.25;
/// Looks for how far it may go.
const LOOKS: usize = 4;

/// A tool that goes.
pub(super) struct Go<'a> {
    pub tool: &'a ToolState,
    pub number: usize,
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
        if from.is_away() {
            return (*from, Meeting::NONE);
        }
        let here = self.met(from, at);
        let share = if from.share < 1.0 { self.grown(at) } else { 1.0 };
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
        let near = HALF * from.share * radius;
        let stride = if free > near { free } else { near };
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

    /// The share of its radii that a tool grows to: no sample comes nearer to a core than half of it.
    fn grown(&self, at: &impl Fn(usize) -> [f32; 3]) -> f32 {
        let from = &self.tool.proxy;
        let whole = self.met(&from.at(from.pivot, from.turn, 1.0), at);
        let (grown, widest) = (begin::grown(from.share), whole.nearest / HALF);
        let grown = if grown < widest { grown } else { widest };
        if grown > from.share { grown } else { from.share }
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
