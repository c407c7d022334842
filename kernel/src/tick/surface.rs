//! The tool's part of a tick where it is a sphere on a model with a contact surface, see
//! [`surface`](crate::terms::surface).
//!
//! **The tissue meets a proxy of the tool.** It goes to where the tool is, with three exceptions, each
//! marked by flag 1 ([`Flags::MOTION_CLAMPED`]) and made up for in later ticks:
//!
//! - **Never through.** It goes only so far that no sample lies deeper in it than half a radius, so
//!   none passes its middle. A tool that goes deeper leaves it behind, and the force stays.
//! - It goes by half a radius a tick at most while the surface is near; far from it by as much as
//!   the surface is away, so that it never jumps over it.
//! - It goes only so far as the model's largest energy allows. A move that lowers the energy is
//!   never shortened.
//!
//! A tool that is engaged inside the body starts with a smaller sphere, which grows by a tenth a tick
//! at most.
//!
//! **Energy.** The level changes by what the move does to the term's energy at the positions as they
//! are. What the hand feels is less: the sweeps take the rest out of the body within the tick. The
//! work that the device is charged for is the mean of the forces before and after, times the way.
//!
//! **Late ticks** move nothing: the proxy goes on in the next tick with a sweep.
//!
//! Cost a tick while engaged: one look at each triangle of the surface, up to eight looks at the
//! samples of those in reach, and one a sweep.

use super::order::Tick;
use super::sample::{Flags, ToolSample};
use super::touch_room::{Sphere, TouchArrays};
use crate::backend::slices::cells_of;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{add, dot, output, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::{LANES, TwoFloat};
use crate::solver::Dynamics;
use crate::terms::surface::{Ball, Meeting, Near, NearTriangle, search};

/// Largest coordinate of a centre [mean link lengths], so that its square stays finite.
const CENTRE_MAX: f32 = 2.0e6;
/// No sample comes nearer to the centre than this share of the radius, and the sphere goes no
/// farther in a tick near the surface.
const HALF: f32 = 0.5;
/// How far the tissue may come towards the sphere in a tick, in radii.
const COMING: f32 = 0.25;
/// Growth of a sphere that was engaged inside the body.
const GROWTH: f32 = 1.1;
/// Looks for how far it may go.
const LOOKS: usize = 4;
/// Room for the rounding of the cells' bounds.
const ROUNDED_UP: f32 = 1.001;

impl<D: Dynamics> Tick<'_, '_, D> {
    /// The sphere follows the tool.
    pub(super) fn press<const LATE: bool>(&mut self, sample: &ToolSample, radius: f32) {
        let model = self.network.model();
        let target = {
            self.head.applied = self.step_towards(sample);
            let start = sub(self.head.tool_origin_m, model.centre_m())
                .map(|way| (way / model.unit_m()).clamp(-CENTRE_MAX, CENTRE_MAX));
            add(start, self.head.applied)
        };
        if LATE {
            return;
        }
        let Some(mut arrays) = self.touch.arrays(self.state.len()) else { return };
        let Some(mut sphere) = arrays.sphere.first().copied() else { return };
        let k = D::Number::from_single(model.saturation());
        let state = &*self.state;
        let at = |cell: usize| state.get(cell).map_or([0.0; 3], |v| single(output(v.xyz(), k)));
        let is_new = !sphere.is_in;
        if is_new {
            sphere = Sphere::AWAY;
            sphere.is_in = true;
            sphere.ball = Ball { centre: target, radius, whole: radius };
        }
        sphere.way = [0.0; 3];
        let stays = target == sphere.ball.centre && sphere.ball.radius == radius;
        let sleeps = self.head.awake.set.is_empty(model.slice_count());
        if stays && sleeps && !is_new {
            arrays.sphere.fill(sphere);
            return;
        }
        let before = Meeting::of(&sphere.ball, arrays.near.get(..sphere.count).unwrap_or(&[]), &at);
        let from = sphere.ball;
        let near = look(model, (from, (HALF + COMING) * radius), &mut arrays, &at);
        if near.full {
            self.flags.insert(Flags::CONTACT_CAPACITY);
        }
        let found = arrays.near.get(..near.count).unwrap_or(&[]);
        let most = self.head.level.at_most(model.energy_max());
        let room = model.energy_max() - (most - before.energy.hi);
        let (to, meeting) = go(Go { from, target, radius, is_new, room }, (&near, found), &at);
        if to.centre != target {
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        sphere.ball = to;
        sphere.way = if is_new { [0.0; 3] } else { sub(to.centre, from.centre) };
        enclose(model, &mut sphere, near.count, &mut arrays);
        arrays.sphere.fill(sphere);
        if before.energy != TwoFloat::ZERO || meeting.energy != TwoFloat::ZERO {
            let rounding = f32::EPSILON * (before.energy.hi + meeting.energy.hi);
            let change = meeting.energy.minus(before.energy).plus(rounding.into());
            self.head.level.shift(change);
            self.head.awake.wake_all(model);
            if sphere.way != [0.0; 3] || to.radius != from.radius {
                self.head.dynamics.pushed();
            }
        }
        self.prepare();
    }

    /// Prepares the coarse level for what the sphere meets.
    fn prepare(&mut self) {
        let (terms, model) = (self.terms(), self.network.model());
        let Some(arrays) = self.touch.arrays(self.state.len()) else { return };
        let Some(sphere) = arrays.sphere.first() else { return };
        let k = D::Number::from_single(model.saturation());
        let state = &*self.state;
        let at = |cell: usize| state.get(cell).map_or([0.0; 3], |v| single(output(v.xyz(), k)));
        let near = arrays.near.get(..sphere.count).unwrap_or(&[]);
        if let Some(coarse) = arrays.coarse.first_mut() {
            coarse.prepare(terms, (&sphere.ball, near), &at);
        }
    }

    /// The tool lets go: the term's energy at the samples is gone.
    pub(super) fn leave_surface(&mut self) {
        let model = self.network.model();
        let k = D::Number::from_single(model.saturation());
        let state = &*self.state;
        let at = |cell: usize| state.get(cell).map_or([0.0; 3], |v| single(output(v.xyz(), k)));
        let Some(arrays) = self.touch.arrays(self.state.len()) else { return };
        let Some(sphere) = arrays.sphere.first_mut().filter(|sphere| sphere.is_in) else { return };
        let near = arrays.near.get(..sphere.count).unwrap_or(&[]);
        let met = Meeting::of(&sphere.ball, near, &at);
        *sphere = Sphere::AWAY;
        if met.energy != TwoFloat::ZERO {
            let rounding = f32::EPSILON * met.energy.hi;
            self.head.level.shift(TwoFloat::ZERO.minus(met.energy).plus(rounding.into()));
            self.head.awake.wake_all(model);
            self.head.dynamics.pushed();
        }
    }

    /// What the sphere meets behind the sweeps: the force on it in internal units; the work of its
    /// move is booked.
    pub(super) fn feel(&mut self) -> [f32; 3] {
        let model = self.network.model();
        let k = D::Number::from_single(model.saturation());
        let state = &*self.state;
        let at = |cell: usize| state.get(cell).map_or([0.0; 3], |v| single(output(v.xyz(), k)));
        let Some(arrays) = self.touch.arrays(self.state.len()) else { return [0.0; 3] };
        let Some(sphere) = arrays.sphere.first_mut().filter(|sphere| sphere.is_in) else {
            return [0.0; 3];
        };
        let near = arrays.near.get(..sphere.count).unwrap_or(&[]);
        let met = Meeting::of(&sphere.ball, near, &at);
        self.work = (-0.5 * dot(add(sphere.met.force, met.force), sphere.way)).into();
        sphere.met = met;
        met.force
    }
}

/// The triangles in reach.
fn look(
    model: &Model<'_>,
    (ball, reach): (Ball, f32),
    arrays: &mut TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
) -> Near {
    let none = Near { count: 0, full: false, distance: f32::MAX };
    model.contact_surface().map_or(none, |surface| search(&surface, at, (ball, reach), arrays.near))
}

/// Where a sphere wants to go.
struct Go {
    from: Ball,
    target: [f32; 3],
    /// As it was chosen.
    radius: f32,
    is_new: bool,
    /// What the energy of contact may become.
    room: f32,
}

/// The sphere where it goes to, and what it meets there.
fn go(
    Go { from, target, radius, is_new, room }: Go,
    (near, found): (&Near, &[NearTriangle]),
    at: &impl Fn(usize) -> [f32; 3],
) -> (Ball, Meeting) {
    let here = Meeting::of(&from, found, at);
    let least = |radius: f32| HALF * radius;
    if is_new {
        let widest = 2.0 * here.nearest;
        let mut ball = Ball { radius: if widest < radius { widest } else { radius }, ..from };
        let mut meeting = Meeting::of(&ball, found, at);
        for _ in 0..LOOKS {
            if meeting.energy.hi <= room {
                return (ball, meeting);
            }
            ball.radius *= HALF;
            meeting = Meeting::of(&ball, found, at);
        }
        ball.radius = 0.0;
        return (ball, Meeting::NONE);
    }
    let grown = {
        let widest = 2.0 * here.nearest;
        let grown = GROWTH * from.radius + 0.01 * radius;
        let grown = if grown < widest { grown } else { widest };
        let grown = if grown > from.radius { grown } else { from.radius };
        if grown < radius { grown } else { radius }
    };
    let way = sub(target, from.centre);
    if let Some(found) = retreat(&from, &here, way, found, at) {
        return found;
    }
    let length = sqrt(dot(way, way));
    let stride = if near.distance > HALF * radius { near.distance } else { HALF * radius };
    let mut share = if length > stride { stride / length } else { 1.0 };
    let floor = if here.nearest < least(grown) { here.nearest } else { least(grown) };
    let ball = |share: f32, radius: f32| {
        let centre = if share < 1.0 { add(from.centre, scale(share, way)) } else { target };
        Ball { centre, radius, ..from }
    };
    for _ in 0..LOOKS {
        let next = ball(share, grown);
        let meeting = Meeting::of(&next, found, at);
        let is_deep = meeting.nearest < floor;
        let is_loaded = meeting.energy.hi > room && meeting.energy.hi > here.energy.hi;
        if !is_deep && !is_loaded {
            return (next, meeting);
        }
        // A secant between here and there, a little less than it says; half the way for the energy.
        let (to_floor, fall) = (here.nearest - floor, here.nearest - meeting.nearest);
        let secant = 0.98 * to_floor / fall;
        let is_sound = !is_loaded && secant > 0.0;
        share *= if is_sound { secant.min(0.9) } else { HALF };
        if is_deep && to_floor <= 0.0 {
            break;
        }
    }
    (from, here)
}

/// Where the tissue has come deeper into the sphere than half a radius: out along the force, unless
/// the tool goes farther out by itself. That lowers the energy of contact.
fn retreat(
    from: &Ball,
    here: &Meeting,
    way: [f32; 3],
    found: &[NearTriangle],
    at: &impl Fn(usize) -> [f32; 3],
) -> Option<(Ball, Meeting)> {
    let (lack, force) = (HALF * from.radius - here.nearest, sqrt(dot(here.force, here.force)));
    if !(lack > 0.0 && force > 0.0) {
        return None;
    }
    let out = scale(1.0 / force, here.force);
    if dot(out, way) > lack {
        return None;
    }
    let ball = Ball { centre: add(from.centre, scale(lack, out)), ..*from };
    let meeting = Meeting::of(&ball, found, at);
    (meeting.energy.hi < here.energy.hi).then_some((ball, meeting))
}

/// Puts the sphere's part into the bounds of the cells at its triangles.
fn enclose(model: &Model<'_>, sphere: &mut Sphere, count: usize, arrays: &mut TouchArrays<'_>) {
    let slices = model.slice_count();
    let cells = model.cells();
    if sphere.count == 0 && count > 0 {
        for (mobility, own) in arrays.mobility.iter_mut().zip(model.mobility) {
            *mobility = *own;
        }
        let elastic = model.coarse_basis.and_then(|basis| basis.elastic());
        let own = elastic.map_or(&[][..], |level| level.factors);
        for (factor, own) in arrays.factors.iter_mut().zip(own) {
            *factor = *own;
        }
    }
    restore(model, sphere, arrays);
    sphere.count = count;
    sphere.slices = crate::backend::slice_set::SliceSet::EMPTY;
    let near = arrays.near.get(..count).unwrap_or(&[]);
    for cell in near.iter().flat_map(|near| near.corners) {
        sphere.slices.insert(usize::from(cell) / LANES);
    }
    for cell in sphere.slices.iter(slices).flat_map(|slice| cells_of(slice, cells)) {
        if let Some(bound) = arrays.mobility.get_mut(cell) {
            *bound = 0.0;
        }
    }
    for near in near {
        for cell in near.corners {
            if let Some(bound) = arrays.mobility.get_mut(usize::from(cell)) {
                *bound += near.weight * (1.0 / 3.0);
            }
        }
    }
    for cell in sphere.slices.iter(slices).flat_map(|slice| cells_of(slice, cells)) {
        let (Some(slot), Some(&own)) = (arrays.mobility.get_mut(cell), model.mobility.get(cell))
        else {
            continue;
        };
        let more = ROUNDED_UP * *slot * own;
        *slot = own / (1.0 + more);
        if let Some(factor) = arrays.factors.get_mut(cell) {
            // The own part by itself, f / W, is softened by the sphere's bound as r / W is.
            *factor *= (1.0 + more) / (1.0 + *factor * more);
        }
    }
}

/// Gives the cells of the last tick's triangles their own bounds back.
fn restore(model: &Model<'_>, sphere: &Sphere, arrays: &mut TouchArrays<'_>) {
    let elastic = model.coarse_basis.and_then(|basis| basis.elastic());
    let factors = elastic.map_or(&[][..], |level| level.factors);
    let slices = sphere.slices.iter(model.slice_count());
    for cell in slices.flat_map(|slice| cells_of(slice, model.cells())) {
        if let (Some(slot), Some(&own)) = (arrays.mobility.get_mut(cell), model.mobility.get(cell))
        {
            *slot = own;
        }
        if let (Some(slot), Some(&own)) = (arrays.factors.get_mut(cell), factors.get(cell)) {
            *slot = own;
        }
    }
}
