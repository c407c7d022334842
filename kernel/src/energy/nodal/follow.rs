//! The memory of a body that relaxes follows its strain, at the start of a tick.
//!
//! With b the part that a branch forgets until the next tick, at the published positions and rotations
//!
//! ```text
//! Y <- Y + b (z - Y)          z = sym(R' F) - I of each cell
//! f <- f + b (s - f)          s the force of the elastic spread on each cell
//! k <- a^2 k - 2 a b u . f + b^2 u . S u       one number of the body, a = 1 - b, u . S u = - u . s
//! ```
//!
//! This is the exact solution of q' + q / tau = g mu z' for a z that changes evenly in a tick, whatever the sweeps do.
//! The energy of a branch is half a squared distance to what it remembers, so it falls to the part a^2.
//!
//! **Rest.** Where a step changes no bit of Y though z differs, Y moves by a unit in the last place; within 2^-20 of z it
//! takes z. So memory comes to rest, bit by bit, after some 8 to 12 tau.
//!
//! Cost: a gather and a scatter of the half-links and some 70 operations for each branch and cell. In two loops: the
//! force s of a cell needs the shapes of its neighbours.

use super::gather::{Ends, Offsets, displacements, load, own};
use super::law::{and_unit, slope};
use super::matrix::{Matrix, dot, each, pairs, three, times};
use super::nearest::rotation;
use super::state;
use super::sums::{Gathered, Own};
use crate::backend::Work;
use crate::backend::f32x8::{F32x8, Lanes8};
use crate::backend::lane::{Lane, Real};
use crate::energy::state::States;
use crate::model::image::BRANCHES_MAX;
use crate::model::image::nodal::BETA;
use crate::model::nodal::{MemoryNumbers, Nodal};
use crate::number::two_float::{LANES, Lanes, Plain};

/// What a branch remembers of eight cells, by number and lane: Y in the order xx, yy, zz, xy, xz, yz, then f.
pub(crate) type BranchRows = [[f32; LANES]; 9];

/// Distance at which a memory takes the strain itself.
const NEAR: f32 = 1.0 / (1 << 20) as f32;
/// Three quarters of the spacing of `f32`: added to a number, it moves it by a unit in the last place.
const NUDGE: f32 = 0.75 * f32::EPSILON;

/// A branch at the start of a tick.
#[derive(Clone, Copy)]
pub(crate) struct Course {
    /// Share of the instantaneous shear modulus.
    pub share: f32,
    /// The part b that it forgets, 0 for one that waits.
    pub faded: f32,
    /// c until this tick, and from this tick on.
    pub before: f32,
    pub weight: f32,
}

/// Sums over the cells, in internal units.
#[derive(Clone, Copy)]
pub(crate) struct Sums {
    /// Change of the energy of the shapes.
    pub rise: Lanes,
    /// u . S u.
    pub spread: Lanes,
    /// u . f of each branch, before and after.
    pub remembered: [[Lanes; 2]; BRANCHES_MAX],
    /// Magnitudes of the sums' terms.
    pub scale: Plain,
    /// By how much the memory has moved.
    pub moved: Plain,
    /// Magnitudes of f.
    pub forces: Plain,
}

impl Sums {
    pub const NONE: Self = Self {
        rise: Lanes::ZERO,
        spread: Lanes::ZERO,
        remembered: [[Lanes::ZERO; 2]; BRANCHES_MAX],
        scale: Plain::ZERO,
        moved: Plain::ZERO,
        forces: Plain::ZERO,
    };
}

/// The memory of a body follows the strain in some slices, whose displacements are stored and whose forces are 0.
pub(crate) struct Follow<'a, 's, S> {
    pub shapes: Nodal<'a>,
    pub states: States<'a>,
    pub slices: S,
    pub courses: &'s [Course],
    /// By slice, a branch after the other.
    pub rows: &'s mut [BranchRows],
    /// The numbers for this tick, by slice.
    pub numbers: &'s mut [MemoryNumbers],
    pub sums: &'s mut Sums,
}

impl<S: Iterator<Item = usize> + Clone> Work for Follow<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(mut self) {
        for slice in self.slices.clone() {
            self.strains::<V>(slice);
        }
        for slice in self.slices.clone() {
            self.forces::<V>(slice);
        }
    }
}

impl<S> Follow<'_, '_, S> {
    /// The branches with their memories of a slice.
    #[inline(always)]
    fn branches(&mut self, slice: usize) -> impl Iterator<Item = (&Course, &mut BranchRows)> {
        let count = self.courses.len();
        let rows = self.rows.get_mut(slice * count..(slice + 1) * count).unwrap_or_default();
        self.courses.iter().zip(rows)
    }

    /// Y of a slice follows the strain; the forces of the spread are added to the cells' and their neighbours'.
    #[inline(always)]
    fn strains<V: F32x8>(&mut self, slice: usize) {
        // Gather the slice's shapes and push the spread's forces.
        let quads = self.states.all().quads();
        let ends = Ends::of(self.shapes, quads.displacements);
        let forces = Ends::of(self.shapes, quads.by_slice(slice));
        let (Some(numbers), Some((ends, forces))) =
            (self.shapes.cells.get(slice), ends.zip(forces))
        else {
            return;
        };
        let mut memory = Offsets::NONE;
        let groups = ends.groups(slice, &mut memory);
        let (Some(sums), own) = (Gathered::<V>::of_any_slice(ends, slice, groups), own(numbers))
        else {
            return;
        };
        let slope = slope(&sums, &own);
        let (stress, pull) = spread_of(&sums, slope, &own);
        forces.push_any(slice, stress, pull, groups);
        // The strain in the frame of R.
        let turn = self.states.all().slice(slice).and_then(|memory| state::load::<V>(memory));
        let Some((turn, _)) = turn else { return };
        let (strain, skew2) = in_frame(and_unit(slope), rotation(turn));
        // Follow it, branch by branch.
        let (mut rise, mut scale, mut moved) = (Lane::of(0.0), Lane::of(0.0), Lane::of(0.0));
        for (course, rows) in self.branches(slice) {
            let Some((rows, _)) = rows.split_first_chunk_mut::<6>() else { continue };
            let [a, b, c, d, e, f] = rows.each_ref().map(|row| Lane(V::load(row)));
            let [p, q, r, s, t, u] = strain;
            let near = Lane::of(NEAR);
            let step = |z, y| follow(z, y, course.faded, near);
            let next = [step(p, a), step(q, b), step(r, c), step(s, d), step(t, e), step(u, f)];
            let old = squared(strain, [a, b, c, d, e, f]) + skew2;
            let new = squared(strain, next) + skew2;
            let [g, h, i, j, k, l] = next;
            moved = moved
                + (away(g, a) + away(h, b) + away(i, c))
                + (away(j, d) + away(k, e) + away(l, f));
            for (row, next) in rows.iter_mut().zip(next) {
                next.0.store(row);
            }
            let stiffness = Lane::of(course.share) * (own.volume * own.mu);
            let (old, new) = (Lane::of(course.before) * old, Lane::of(course.weight) * new);
            rise = rise + stiffness * (new - old);
            scale = scale + stiffness * (new + old);
        }
        self.sums.rise.add(rise.0);
        self.sums.scale.add(scale.0);
        self.sums.moved.add(moved.0);
    }

    /// f of a slice follows the forces of the spread; the slice's numbers for this tick.
    #[inline(always)]
    fn forces<V: F32x8>(&mut self, slice: usize) {
        // Displacements and forces of the slice.
        let quads = self.states.all().quads();
        let here = Ends::of(self.shapes, quads.displacements).and_then(|ends| ends.own(slice));
        let (Some(numbers), Some(here), Some(forces)) =
            (self.shapes.cells.get(slice), here, quads.force(slice))
        else {
            return;
        };
        let here = displacements::<V>(here.each_ref());
        let [x, y, z, _] = V::transposed(&forces);
        let (own, force) = (own::<V>(numbers), [Lane(x), Lane(y), Lane(z)]);
        let near = Lane::of(NEAR) * (own.mu * own.volume);
        // Follow them, branch by branch.
        let zero = Lane::of(0.0);
        let mut mean = Mean::of(&own, self.courses);
        let (mut remembered, mut moved, mut sizes) = ([[zero; 2]; BRANCHES_MAX], zero, zero);
        let mut scale = size(here, force);
        for ((course, rows), works) in self.branches(slice).zip(&mut remembered) {
            let Some((shape, rows)) = rows.split_first_chunk_mut::<6>() else { continue };
            let Some(rows) = rows.first_chunk_mut::<3>() else { continue };
            let old = rows.each_ref().map(|row| Lane(V::load(row)));
            let next = pairs(force, old, |s, f| follow(s, f, course.faded, near));
            for (row, next) in rows.iter_mut().zip(next) {
                next.0.store(row);
            }
            *works = [dot(here, old), dot(here, next)];
            let [a, b, c] = pairs(next, old, away);
            let [d, e, f] = next.map(magnitude);
            (moved, sizes) = (moved + (a + b + c), sizes + (d + e + f));
            scale = scale + size(here, old) + size(here, next);
            mean.add(course, shape.each_ref().map(|row| Lane(V::load(row))), next);
        }
        // Store the sums and the numbers.
        let sums = &mut *self.sums;
        sums.spread.add((zero - dot(here, force)).0);
        for (sums, [before, after]) in sums.remembered.iter_mut().zip(remembered) {
            let [of_before, of_after] = sums;
            of_before.add(before.0);
            of_after.add(after.0);
        }
        sums.scale.add(scale.0);
        sums.moved.add(moved.0);
        sums.forces.add(sizes.0);
        let courses = self.courses;
        let count = courses.len();
        let rows = self.rows.get(slice * count..(slice + 1) * count).unwrap_or_default();
        if let Some(numbers) = self.numbers.get_mut(slice) {
            mean.store(courses.iter().zip(rows), numbers);
        }
    }
}

/// The numbers of a slice for a tick, from what its branches remember; of a restored body.
pub(crate) fn remember(
    shapes: Nodal<'_>,
    slice: usize,
    courses: &[Course],
    rows: &[BranchRows],
    numbers: &mut MemoryNumbers,
) {
    let Some(own) = shapes.cells.get(slice).map(own::<Lanes8>) else { return };
    let mut mean = Mean::of(&own, courses);
    for (course, rows) in courses.iter().zip(rows) {
        let row = |row: usize| load(rows, row);
        mean.add(
            course,
            [row(0), row(1), row(2), row(3), row(4), row(5)],
            [row(6), row(7), row(8)],
        );
    }
    mean.store(courses.iter().zip(rows), numbers);
}

/// Sums over the branches of a slice.
struct Mean<V> {
    mu: Lane<V>,
    /// The part of mu that acts, and the part that lasts.
    part: f32,
    lasting: f32,
    stretch: [Lane<V>; 6],
    push: [Lane<V>; 3],
}

impl<V: F32x8> Mean<V> {
    #[inline(always)]
    fn of(own: &Own<V>, courses: &[Course]) -> Self {
        let [part, lasting] = parts(courses);
        let zero = Lane::of(0.0);
        Self { mu: own.mu, part, lasting, stretch: [zero; 6], push: [zero; 3] }
    }

    #[inline(always)]
    fn add(&mut self, course: &Course, shape: [Lane<V>; 6], force: [Lane<V>; 3]) {
        let weight = Lane::of(course.share * course.weight);
        let ([a, b, c, d, e, f], [g, h, i, j, k, l]) = (self.stretch, shape);
        let add = |sum: Lane<V>, y: Lane<V>| sum + weight * y;
        self.stretch = [add(a, g), add(b, h), add(c, i), add(d, j), add(e, k), add(f, l)];
        self.push = pairs(self.push, force, add);
    }

    /// Stores A - I, twice the density of the rest of the energy, and B.
    #[inline(always)]
    fn store<'r>(
        self,
        branches: impl Iterator<Item = (&'r Course, &'r BranchRows)>,
        numbers: &mut MemoryNumbers,
    ) {
        let share = Lane::of(1.0) / Lane::of(self.part);
        let [a, b, c, d, e, f] = self.stretch;
        let stretch = [a * share, b * share, c * share, d * share, e * share, f * share];
        // The branches' distances from their mean, and that of a body without memory.
        let zero = Lane::of(0.0);
        let mut rest = Lane::of(self.lasting) * squared(stretch, [zero; 6]);
        for (course, rows) in branches {
            let row = |row: usize| load::<V>(rows, row);
            let shape = [row(0), row(1), row(2), row(3), row(4), row(5)];
            rest = rest + Lane::of(course.share * course.weight) * squared(shape, stretch);
        }
        let constant = (self.mu + self.mu) * rest;
        let ([a, b, c, d, e, f], [x, y, z]) = (stretch, self.push);
        for (row, lanes) in numbers.iter_mut().zip([a, b, c, d, e, f, constant, x, y, z]) {
            (lanes + zero).0.store(row);
        }
    }
}

/// The part of the instantaneous shear modulus that acts in a tick, and the part that lasts.
#[inline(always)]
pub(crate) fn parts(courses: &[Course]) -> [f32; 2] {
    let lasting = courses.iter().fold(1.0, |rest, course| rest - course.share);
    [courses.iter().fold(lasting, |sum, course| sum + course.share * course.weight), lasting]
}

/// Stress and force of the elastic spread.
#[inline(always)]
fn spread_of<V: Real>(
    sums: &Gathered<V>,
    slope: Matrix<V>,
    own: &Own<V>,
) -> (Matrix<V>, [Lane<V>; 4]) {
    let (zero, factor) = (Lane::of(0.0), Lane::of(2.0 * BETA) * own.mu);
    let stress = each(slope, |x| zero - factor * x);
    let [x, y, z] = pairs(sums.pull, times(stress, own.area), |pull, own| pull - own);
    (stress, [x, y, z, zero])
}

/// sym(R' F) - I in the order xx, yy, zz, xy, xz, yz, and the square of the rest of R' F.
#[inline(always)]
fn in_frame<V: Real>(f: Matrix<V>, turn: Matrix<V>) -> ([Lane<V>; 6], Lane<V>) {
    let ([a, b, c], [d, e, g]) = (f, turn);
    // Row i of R' F is the sum of R's rows' elements i times F's rows.
    let row = |[p, q, r]: [Lane<V>; 3]| {
        let sum = |[x, y, z]: [Lane<V>; 3]| p * x + q * y + r * z;
        let ([a0, a1, a2], [b0, b1, b2], [c0, c1, c2]) = (a, b, c);
        [sum([a0, b0, c0]), sum([a1, b1, c1]), sum([a2, b2, c2])]
    };
    let ([d0, d1, d2], [e0, e1, e2], [g0, g1, g2]) = (d, e, g);
    let ([xx, xy, xz], [yx, yy, yz], [zx, zy, zz]) =
        (row([d0, e0, g0]), row([d1, e1, g1]), row([d2, e2, g2]));
    let (one, half) = (Lane::of(1.0), Lane::of(0.5));
    let (p, q, r) = (xy - yx, xz - zx, yz - zy);
    let skew2 = half * (p * p + q * q + r * r);
    let strain =
        [xx - one, yy - one, zz - one, half * (xy + yx), half * (xz + zx), half * (yz + zy)];
    (strain, skew2)
}

/// The squared distance of two symmetric matrices.
#[inline(always)]
fn squared<V: Real>([a, b, c, d, e, f]: [Lane<V>; 6], other: [Lane<V>; 6]) -> Lane<V> {
    let [g, h, i, j, k, l] = other;
    let square = |a: Lane<V>, b: Lane<V>| (a - b) * (a - b);
    let beside = square(d, j) + square(e, k) + square(f, l);
    square(a, g) + square(b, h) + square(c, i) + (beside + beside)
}

/// A memory one step nearer to what it follows.
#[inline(always)]
fn follow<V: Real>(target: Lane<V>, memory: Lane<V>, faded: f32, near: Lane<V>) -> Lane<V> {
    // A branch that waits.
    if faded <= 0.0 {
        return memory;
    }
    let (zero, way) = (Lane::of(0.0), target - memory);
    let next = memory + Lane::of(faded) * way;
    // At least a unit in the last place.
    let nudge = Lane::of(NUDGE) * magnitude(memory);
    let nudged = Lane::select(way.above(zero), memory + nudge, memory - nudge);
    let next = Lane::select(away(next, memory).above(zero), next, nudged);
    // -0.0 becomes +0.0.
    Lane::select(magnitude(way).above(near), next, target) + zero
}

#[inline(always)]
fn magnitude<V: Real>(x: Lane<V>) -> Lane<V> {
    let zero = Lane::of(0.0);
    Lane::select(zero.above(x), zero - x, x)
}

#[inline(always)]
fn away<V: Real>(a: Lane<V>, b: Lane<V>) -> Lane<V> {
    magnitude(a - b)
}

/// Sum of the magnitudes of products.
#[inline(always)]
fn size<V: Real>(a: [Lane<V>; 3], b: [Lane<V>; 3]) -> Lane<V> {
    let [x, y, z] = three(pairs(a, b, |a, b| a * b), magnitude);
    x + y + z
}
