//! A blade cuts: after the sweeps of a tick the fronts of its edge move on, and the faces that they pass open.
//!
//! With p the way from a front to its sample and q its part along the direction of cutting, a front whose force
//! is at its limit, k q > J w, moves on by q - J w / k in that direction, in the material as it is deformed. A
//! front that presses also follows its sample along the edge, and across the blade's plane by at most the
//! progress of the cut, at no force. The energy of the edge falls by what the hand paid: J w times the progress.
//! The swept area is the sum of w times the progress.
//!
//! J is the toughness at the front: that of the tetrahedron's cells by their weights there, so that it changes along a
//! way without a jump. The limit of a front follows it after each move. Where it rises the force rises from where it
//! was; where it falls the front moves on, and the energy that springs back is lost. Fronts are as stiff as
//! the toughest cell of the body asks for.
//!
//! Where tissue gapes, a front that passes from one side to the
//! other leaps: ahead, it has no more progress than its slip; back, it has less than none, as it moves on from there
//! once more. So no area counts for which nobody paid. A front that would fall back on its way aside goes straight on.
//!
//! A sample before which the tissue is open already has no limit but 0: neither force nor area; see `ahead`.
//!
//! A front is left behind, and its sample enters anew, where the blade is drawn back by more than [`BACK`] mean
//! link lengths, or moved aside by more than [`ASIDE`]. A blade that moves by more than [`BEHIND`] in a tick leaves
//! all fronts behind and cuts nothing: a pose that jumps does no harm.
//!
//! Cost: the tetrahedra that the edge passes, and that of `ahead`; while a sample is outside, also that of `entry`.

use super::body::CutBody;
use super::entry::BEHIND;
use super::place::{Point, weights};
use super::strip::Strip;
use crate::energy::surface::{EDGE_SAMPLES, Edge, EdgeSample};
use crate::number::cell::{add, dot, scale, sub};
use crate::number::turn::cross;
use crate::number::words::{number, words};

/// Steps in which a front moves on.
const STEPS: usize = 3;
/// Way back at which a front is left behind [mean link lengths].
const BACK: f32 = 4.0;
/// Way aside at which it is [mean link lengths].
const ASIDE: f32 = 1.0;
/// Most by which a front falls back in a step, for the rounding [mean link lengths].
const FALL_BACK: f32 = 1.0e-5;
/// Most by which a front begins farther behind its sample than the blade has moved [mean link lengths].
const NEARLY: f32 = 1.0e-3;
/// Stiffness of a sample over Young's modulus times its length.
const STIFFNESS: f32 = 8.0;
/// Most that a sample presses in before its front moves on [mean link lengths].
const PRESSED: f32 = 0.2;

/// Directions of an edge in the body's frame.
struct Axes {
    /// In which it cuts.
    forward: [f32; 3],
    /// Its own.
    along: [f32; 3],
    /// Across the blade's plane.
    across: [f32; 3],
}

impl Axes {
    fn of(edge: &Edge) -> Self {
        let (forward, along) = (edge.forward(), edge.along());
        Self { forward, along, across: cross(forward, along) }
    }
}

/// The front of a sample before a move and after it.
#[derive(Clone, Copy)]
struct Move {
    before: Point,
    after: Point,
}

impl CutBody<'_, '_> {
    /// Moves the fronts of an edge on and opens the faces that they pass; in the last tick the blade has moved by
    /// `moved` mean link lengths, `ahead` of them not against the direction of cutting. Returns the energy with which
    /// fronts have begun, `None` if no front has moved, begun or ended.
    pub fn draw(
        &mut self,
        edge: &mut Edge,
        moved: f32,
        ahead: f32,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<f32> {
        if moved > BEHIND {
            let was_in = edge.fronts().next().is_some();
            edge.leave();
            return was_in.then_some(0.0);
        }
        let mut moves = [None; EDGE_SAMPLES];
        // Move the fronts on.
        let axes = Axes::of(edge);
        let (mut is_changed, mut area, mut work) = (false, 0.0, 0.0);
        for (sample, slot) in edge.samples_mut().iter_mut().zip(&mut moves) {
            if sample.is_in() {
                let before = Point::of(sample);
                let (after, progress) = self.advance(sample, &axes, at);
                area += if sample.limit > 0.0 { sample.length * progress } else { 0.0 };
                work += sample.limit * progress;
                is_changed |= before.rest != after.rest || !sample.is_in();
                *slot = Some(Move { before, after });
            }
        }
        self.add_area(area);
        self.add_work(work);
        // Open the faces between neighbouring samples.
        for (pair, moves) in edge.samples().windows(2).zip(moves.windows(2)) {
            if let ([a, b], [one, other]) = (pair, moves) {
                self.open_between([a.place, b.place], [one, other], at);
            }
        }
        // Let samples in.
        let before = edge.energy(at);
        if edge.samples().iter().any(|sample| !sample.is_in()) {
            is_changed |= self.enter(edge, ahead, at);
        }
        is_changed |= self.free(edge, at);
        let begun = edge.energy(at) - before;
        is_changed.then_some(if begun > 0.0 { begun } else { 0.0 })
    }

    /// Lets samples in that have entered the tissue. Returns true if one has.
    fn enter(&self, edge: &mut Edge, ahead: f32, at: &impl Fn(usize) -> [f32; 3]) -> bool {
        let (mut entries, forward, mut is_any) = ([None; EDGE_SAMPLES], edge.forward(), false);
        self.find_entries(edge, at, &mut entries);
        for (sample, entry) in edge.samples_mut().iter_mut().zip(entries) {
            if let Some(door) =
                entry.and_then(|entry| self.door(sample, forward, entry.within(ahead), at))
            {
                self.begin(sample, door);
                is_any |= self.follow(sample, ahead, forward, at);
            }
        }
        is_any
    }

    /// Moves a front that has begun on to its sample, where it is more than `most` behind it. Returns false if it does
    /// not come so near: the sample is outside then.
    fn follow(
        &self,
        sample: &mut EdgeSample,
        most: f32,
        forward: [f32; 3],
        at: &impl Fn(usize) -> [f32; 3],
    ) -> bool {
        let mut left = dot(forward, sub(sample.place, sample.front(at)));
        for _ in 0..STEPS {
            if left <= most + NEARLY {
                break;
            }
            let from = Point::of(sample);
            let step = self.way_at_rest(from.tetrahedron, scale(left - most, forward), at);
            let Some(step) = step else { break };
            let Some(next) = self.go(sample, add(from.rest, step), forward, at) else { break };
            left = next;
        }
        let is_near = left <= most + NEARLY && sample.is_in();
        if !is_near {
            sample.leave();
        }
        is_near
    }

    /// Gives a sample its first front.
    fn begin(&self, sample: &mut EdgeSample, front: Point) {
        let cell = self.cut.corners.get(front.tetrahedron).map_or(0, |corners| corners[0]);
        let young_pa = self.model.elasticity(cell.into()).map_or(1.0, |[young_pa, _]| young_pa);
        let (unit_m, unit_n) = (self.model.unit_m(), self.model.force_unit_n());
        // Both forces over the unit of force [N], lengths in links.
        let (soft, short) = (
            STIFFNESS * young_pa * unit_m * unit_m / unit_n * sample.length,
            self.limit_of(self.cut.toughness_j_per_m2, sample) / PRESSED,
        );
        sample.stiffness = if soft > short { soft } else { short };
        self.set_front(sample, front);
        sample.limit = self.limit(sample);
    }

    /// Largest force of a sample that cuts at its front.
    pub(super) fn limit(&self, sample: &EdgeSample) -> f32 {
        let corners = self.cut.corners.get(sample.tetrahedron as usize);
        let toughness = match corners.filter(|_| !self.cut.cell_toughness.is_empty()) {
            None => self.cut.toughness_j_per_m2,
            Some(cells) => cells.iter().zip(sample.weights).fold(0.0, |sum, (&cell, weight)| {
                sum + weight * self.cut.cell_toughness_j_per_m2(cell.into())
            }),
        };
        self.limit_of(toughness, sample)
    }

    /// Largest force of a sample in tissue of a toughness \[J/m^2\].
    fn limit_of(&self, toughness: f32, sample: &EdgeSample) -> f32 {
        let (unit_m, unit_n) = (self.model.unit_m(), self.model.force_unit_n());
        toughness * unit_m / unit_n * sample.length
    }

    /// Sets the front of a sample.
    fn set_front(&self, sample: &mut EdgeSample, front: Point) {
        let corners = self.corners_at_rest(front.tetrahedron);
        let (Some(corners), Some(&cells)) = (corners, self.arrays.corners.get(front.tetrahedron))
        else {
            return sample.leave();
        };
        // A point on a face may lie outside by rounding: its weights stay between 0 and 1.
        let weights = weights(corners, front.rest).map(|x| if x > 0.0 { x } else { 0.0 });
        let sum = weights.iter().fold(0.0, |sum, x| sum + x);
        sample.weights = weights.map(|x| x / sum);
        (sample.tetrahedron, sample.corners, sample.rest) =
            (front.tetrahedron as u32, cells, front.rest.map(|x| x + 0.0));
    }

    /// Moves a front on. Returns where it is then, beyond the body if it has cut through, and its progress along
    /// the direction of cutting, below 0 where it has fallen back.
    fn advance(
        &self,
        sample: &mut EdgeSample,
        axes: &Axes,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> (Point, f32) {
        let Axes { forward, along, across } = *axes;
        let most = sample.limit / sample.stiffness;
        let mut progress = 0.0;
        for _ in 0..STEPS {
            // Leave a front behind from which the blade has gone.
            let from = Point::of(sample);
            let way = sub(sample.place, sample.front(at));
            let [q, aside, off] = [forward, along, across].map(|axis| dot(axis, way));
            let is_gone = q < -BACK || (q <= 0.0 && aside.abs() > ASIDE);
            if is_gone || off.abs() > ASIDE {
                sample.leave();
                return (from, progress);
            }
            if q <= 0.0 {
                break;
            }
            // Move on as far as the force is above its limit, and follow at its side.
            let slip = if q > most { q - most } else { 0.0 };
            let off = if off > slip { slip } else { off };
            let off = if off < -slip { -slip } else { off };
            let beside = add(scale(aside, along), scale(off, across));
            let ahead = scale(slip, forward);
            let at_rest =
                |step| Some(add(from.rest, self.way_at_rest(from.tetrahedron, step, at)?));
            let Some(wished) = at_rest(add(ahead, beside)) else { break };
            let kept = *sample;
            let mut left = self.go(sample, wished, forward, at);
            // Straight on where the body ends beside, or the front would fall back there.
            if left.is_none_or(|left| left > q + FALL_BACK) {
                *sample = kept;
                left = at_rest(ahead).and_then(|wished| self.go(sample, wished, forward, at));
            }
            let Some(left) = left else {
                sample.leave();
                return (Point { rest: wished, ..from }, progress);
            };
            if slip <= 0.0 || !sample.is_in() {
                break;
            }
            // The hand has paid for the slip alone.
            let passed = q - left;
            progress += if passed < slip { passed } else { slip };
        }
        (Point::of(sample), progress)
    }

    /// Moves the front of a sample straight to a place at rest. Returns how far the sample is ahead of it then, `None`
    /// if the way leaves the body.
    fn go(
        &self,
        sample: &mut EdgeSample,
        wished: [f32; 3],
        forward: [f32; 3],
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<f32> {
        let front = self.walk(Point::of(sample), wished, |_| ())?;
        self.set_front(sample, front);
        Some(dot(forward, sub(sample.place, sample.front(at))))
    }

    /// Opens the faces between two neighbouring samples, at these places. Where one of them is outside the tissue,
    /// the edge goes straight on from the other.
    fn open_between(
        &mut self,
        [a, b]: [[f32; 3]; 2],
        moves: [&Option<Move>; 2],
        at: &impl Fn(usize) -> [f32; 3],
    ) {
        let (first, strip) = match moves {
            [Some(one), Some(other)] => {
                let (before, after) = ([one.before, other.before], [one.after, other.after]);
                let ends = |of: [Point; 2]| of.map(|point| point.rest);
                (one, Strip { before: ends(before), after: ends(after) })
            }
            [Some(inner), None] => (inner, self.beyond(inner, sub(b, a), at)),
            [None, Some(inner)] => (inner, self.beyond(inner, sub(a, b), at)),
            [None, None] => return,
        };
        if strip.before != strip.after {
            self.open_strip(&strip, [first.before.tetrahedron, first.after.tetrahedron]);
        }
    }

    /// The strip from a front straight on by a way.
    fn beyond(&self, inner: &Move, way: [f32; 3], at: &impl Fn(usize) -> [f32; 3]) -> Strip {
        let way = self.way_at_rest(inner.after.tetrahedron, way, at).unwrap_or([0.0; 3]);
        let [before, after] = [inner.before, inner.after].map(|point| point.rest);
        Strip { before: [before, add(before, way)], after: [after, add(after, way)] }
    }

    /// Adds to the swept area [mean link lengths^2].
    fn add_area(&mut self, more: f32) {
        let sum = self.area() + f64::from(more);
        let [.., low, high] = &mut *self.arrays.counts;
        [*low, *high] = words(sum);
    }

    /// Adds to the work of the blades, in internal units.
    fn add_work(&mut self, more: f32) {
        for sum in &mut *self.arrays.work {
            *sum = words(number(*sum) + f64::from(more));
        }
    }

    /// Work of the blades that has swept an area \[J\].
    pub fn work_j(&self, area_m2: f32) -> f32 {
        match self.arrays.work.first() {
            Some(&work) => (number(work) * f64::from(self.model.energy_unit_j())) as f32,
            None => area_m2 * self.cut.toughness_j_per_m2,
        }
    }

    /// The swept area [mean link lengths^2].
    pub fn area(&self) -> f64 {
        let [.., low, high] = *self.arrays.counts;
        number([low, high])
    }

    /// Names the cells of the fronts anew, after splits.
    pub fn rename_fronts(&self, edge: &mut Edge) {
        for sample in edge.samples_mut().iter_mut().filter(|sample| sample.is_in()) {
            if self.drops(sample.tetrahedron as usize) {
                sample.leave();
            } else if let Some(&cells) = self.arrays.corners.get(sample.tetrahedron as usize) {
                sample.corners = cells;
            }
        }
    }
}
