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
//! It comes to rest as [`following`](crate::energy) says: the stress is then off by at most 2 mu 2^-20. For f that
//! distance is 2^-18 mu V.
//!
//! Cost: a gather and a scatter of the half-links and some 70 operations for each branch and cell. In two loops: the
//! force s of a cell needs the shapes of its neighbours.

use super::gather::{Ends, Offsets, displacements, own};
use super::law::{and_unit, slope};
use super::matrix::{Matrix, dot, each, pairs, times, times_transposed};
use super::nearest::rotation;
use super::state;
use super::sums::{Gathered, Own};
use crate::backend::Work;
use crate::backend::f32x8::{F32x8, Lanes8};
use crate::backend::lane::{Lane, Real};
use crate::energy::following::{Course, NEAR, Near, Parts, Sums, follow};
use crate::energy::state::States;
use crate::model::image::nodal::BETA;
use crate::model::nodal::{MemoryNumbers, Nodal};
use crate::number::two_float::LANES;

/// The memory of eight cells in a branch, by number and lane: Y in the order xx, yy, zz, xy, xz, yz, then f.
pub(crate) type BranchRows = [[f32; LANES]; 9];

/// The same for a force of the spread, as a share of mu V.
const NEAR_FORCE: f32 = 4.0 * NEAR;
/// The memory of a body follows the strain in some slices, whose displacements are stored and whose forces are 0.
pub(crate) struct Follow<'a, 's, S> {
    pub shapes: Nodal<'a>,
    pub states: States<'a>,
    pub slices: S,
    pub courses: &'s [Course],
    pub parts: Parts,
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
            V::apart(Strains { follow: &mut self, slice });
        }
        for slice in self.slices.clone() {
            V::apart(Forces { follow: &mut self, slice });
        }
    }
}

/// The first loop's work at a slice.
struct Strains<'f, F> {
    follow: &'f mut F,
    slice: usize,
}

impl<S> Work for Strains<'_, Follow<'_, '_, S>> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        self.follow.strains::<V>(self.slice);
    }
}

/// The second loop's work at a slice.
struct Forces<'f, F> {
    follow: &'f mut F,
    slice: usize,
}

impl<S> Work for Forces<'_, Follow<'_, '_, S>> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        self.follow.forces::<V>(self.slice);
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
        let (tension, pull) = spread_of(&sums, slope, &own);
        forces.pull_any(slice, tension, pull, groups);
        // The strain in the frame of R.
        let turn = self.states.all().slice(slice).and_then(|memory| state::load::<V>(memory));
        let Some((turn, _)) = turn else { return };
        let (strain, skew2) = in_frame(and_unit(slope), rotation(turn));
        // Follow it, branch by branch.
        let near = Near::of(Lane::of(NEAR), self.parts.lasting);
        let (zero, stiffness) = (Lane::of(0.0), own.volume * own.mu);
        let (mut rise, mut scale, mut has_moved) = (zero, zero, self.sums.moved);
        for (course, rows) in self.branches(slice) {
            let old = shape_of(rows);
            let distance = squared(strain, old) + skew2;
            let before = Lane::of(course.before) * distance;
            let stiffness = Lane::of(course.share) * stiffness;
            let mut after = Lane::of(course.weight) * distance;
            if course.faded > 0.0 {
                let next = followed(strain, old, course.faded, near);
                after = Lane::of(course.weight) * (squared(strain, next) + skew2);
                has_moved = has_moved || V::any(way(next, old).above(zero));
                store_shape(next, rows);
            }
            rise = rise + stiffness * (after - before);
            scale = scale + stiffness * (after + before);
        }
        self.sums.moved = has_moved;
        self.sums.rise.add(rise.0);
        self.sums.scale.add(scale.0);
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
        let near = Near::of(Lane::of(NEAR_FORCE) * (own.mu * own.volume), self.parts.lasting);
        // Follow them, branch by branch.
        let zero = Lane::of(0.0);
        let (courses, count) = (self.courses, self.courses.len());
        let rows = self.rows.get_mut(slice * count..(slice + 1) * count).unwrap_or_default();
        let (sums, mut scale) = (&mut *self.sums, size(here, force));
        for ((course, rows), works) in courses.iter().zip(&mut *rows).zip(&mut sums.remembered) {
            let old = force_of(rows);
            let (work, of_old) = (dot(here, old), size(here, old));
            let (mut next, mut next_work, mut of_next) = (old, work, of_old);
            if course.faded > 0.0 {
                let ([s, t, u], [a, b, c]) = (force, old);
                next = [
                    follow(s, a, course.faded, near),
                    follow(t, b, course.faded, near),
                    follow(u, c, course.faded, near),
                ];
                (next_work, of_next) = (dot(here, next), size(here, next));
                sums.moved = sums.moved || V::any(length(next, old).above(zero));
                store_force(next, rows);
            }
            let [before, after] = works;
            before.add(work.0);
            after.add(next_work.0);
            sums.pushes = sums.pushes || V::any(length(next, [zero; 3]).above(zero));
            scale = scale + of_old + of_next;
        }
        // Store the sums and the numbers.
        sums.spread.add((zero - dot(here, force)).0);
        sums.scale.add(scale.0);
        if let Some(numbers) = self.numbers.get_mut(slice) {
            derive(own.mu, self.parts, courses.iter().zip(&*rows), numbers);
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
    derive(own.mu, Parts::of(courses), courses.iter().zip(rows), numbers);
}

/// Stores A - I, twice the density of the rest of the energy, and B of eight cells.
#[inline(always)]
fn derive<'r, V: F32x8>(
    mu: Lane<V>,
    parts: Parts,
    branches: impl Iterator<Item = (&'r Course, &'r BranchRows)> + Clone,
    numbers: &mut MemoryNumbers,
) {
    let zero = Lane::of(0.0);
    let (mut sums, mut push) = ([zero; 6], [zero; 3]);
    for (course, rows) in branches.clone() {
        let weight = Lane::of(course.share * course.weight);
        let ([a, b, c, d, e, f], [g, h, i, j, k, l]) = (sums, shape_of(rows));
        sums = [
            a + weight * g,
            b + weight * h,
            c + weight * i,
            d + weight * j,
            e + weight * k,
            f + weight * l,
        ];
        let ([a, b, c], [g, h, i]) = (push, force_of(rows));
        push = [a + weight * g, b + weight * h, c + weight * i];
    }
    let share = Lane::of(1.0) / Lane::of(parts.acting);
    let [a, b, c, d, e, f] = sums;
    let stretch = [a * share, b * share, c * share, d * share, e * share, f * share];
    // The branches' distances from their mean, and that of a body without memory.
    let mut rest = Lane::of(parts.lasting) * squared(stretch, [zero; 6]);
    for (course, rows) in branches {
        let weight = Lane::of(course.share * course.weight);
        rest = rest + weight * squared(stretch, shape_of(rows));
    }
    let constant = (mu + mu) * rest;
    let ([a, b, c, d, e, f], [x, y, z]) = (stretch, push);
    let [p, q, r, s, t, u, v, k, l, m] = numbers;
    (a + zero).0.store(p);
    (b + zero).0.store(q);
    (c + zero).0.store(r);
    (d + zero).0.store(s);
    (e + zero).0.store(t);
    (f + zero).0.store(u);
    (constant + zero).0.store(v);
    (x + zero).0.store(k);
    (y + zero).0.store(l);
    (z + zero).0.store(m);
}

/// The elastic spread: minus its stress, and its force.
#[inline(always)]
fn spread_of<V: Real>(
    sums: &Gathered<V>,
    slope: Matrix<V>,
    own: &Own<'_, V>,
) -> (Matrix<V>, [Lane<V>; 4]) {
    let factor = Lane::of(2.0 * BETA) * own.mu;
    let tension = each(slope, |x| factor * x);
    let [x, y, z] = pairs(sums.pull, times(tension, own.area), |pull, own| pull + own);
    (tension, [x, y, z, Lane::of(0.0)])
}

/// sym(R' F) - I in the order xx, yy, zz, xy, xz, yz, and the square of the rest of R' F.
#[inline(always)]
fn in_frame<V: Real>(f: Matrix<V>, turn: Matrix<V>) -> ([Lane<V>; 6], Lane<V>) {
    // R' F.
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] =
        times_transposed(transposed(turn), transposed(f));
    let (one, half) = (Lane::of(1.0), Lane::of(0.5));
    let (p, q, r) = (xy - yx, xz - zx, yz - zy);
    let skew2 = half * (p * p + q * q + r * r);
    let strain =
        [xx - one, yy - one, zz - one, half * (xy + yx), half * (xz + zx), half * (yz + zy)];
    (strain, skew2)
}

#[inline(always)]
fn transposed<V: Real>([[a, b, c], [d, e, f], [g, h, i]]: Matrix<V>) -> Matrix<V> {
    [[a, d, g], [b, e, h], [c, f, i]]
}

/// Y of eight cells.
#[inline(always)]
fn shape_of<V: F32x8>([a, b, c, d, e, f, ..]: &BranchRows) -> [Lane<V>; 6] {
    [
        Lane(V::load(a)),
        Lane(V::load(b)),
        Lane(V::load(c)),
        Lane(V::load(d)),
        Lane(V::load(e)),
        Lane(V::load(f)),
    ]
}

#[inline(always)]
fn store_shape<V: F32x8>([p, q, r, s, t, u]: [Lane<V>; 6], rows: &mut BranchRows) {
    let [a, b, c, d, e, f, ..] = rows;
    p.0.store(a);
    q.0.store(b);
    r.0.store(c);
    s.0.store(d);
    t.0.store(e);
    u.0.store(f);
}

/// f of eight cells.
#[inline(always)]
fn force_of<V: F32x8>([.., x, y, z]: &BranchRows) -> [Lane<V>; 3] {
    [Lane(V::load(x)), Lane(V::load(y)), Lane(V::load(z))]
}

#[inline(always)]
fn store_force<V: F32x8>([p, q, r]: [Lane<V>; 3], [.., x, y, z]: &mut BranchRows) {
    p.0.store(x);
    q.0.store(y);
    r.0.store(z);
}

/// Y one step nearer to the strain.
#[inline(always)]
fn followed<V: Real>(
    [p, q, r, s, t, u]: [Lane<V>; 6],
    [a, b, c, d, e, f]: [Lane<V>; 6],
    faded: f32,
    near: Near<V>,
) -> [Lane<V>; 6] {
    [
        follow(p, a, faded, near),
        follow(q, b, faded, near),
        follow(r, c, faded, near),
        follow(s, d, faded, near),
        follow(t, e, faded, near),
        follow(u, f, faded, near),
    ]
}

/// Sum of the distances of the elements.
#[inline(always)]
fn way<V: Real>([a, b, c, d, e, f]: [Lane<V>; 6], other: [Lane<V>; 6]) -> Lane<V> {
    let [g, h, i, j, k, l] = other;
    (away(a, g) + away(b, h) + away(c, i)) + (away(d, j) + away(e, k) + away(f, l))
}

/// The squared distance of two symmetric matrices.
#[inline(always)]
fn squared<V: Real>([a, b, c, d, e, f]: [Lane<V>; 6], other: [Lane<V>; 6]) -> Lane<V> {
    let [g, h, i, j, k, l] = other;
    let beside = square(d - j) + square(e - k) + square(f - l);
    square(a - g) + square(b - h) + square(c - i) + (beside + beside)
}

#[inline(always)]
fn square<V: Real>(x: Lane<V>) -> Lane<V> {
    x * x
}

#[inline(always)]
fn away<V: Real>(a: Lane<V>, b: Lane<V>) -> Lane<V> {
    (a - b).magnitude()
}

/// Sum of the distances of the coordinates.
#[inline(always)]
fn length<V: Real>([a, b, c]: [Lane<V>; 3], [d, e, f]: [Lane<V>; 3]) -> Lane<V> {
    away(a, d) + away(b, e) + away(c, f)
}

/// Sum of the magnitudes of products.
#[inline(always)]
fn size<V: Real>([a, b, c]: [Lane<V>; 3], [d, e, f]: [Lane<V>; 3]) -> Lane<V> {
    (a * d).magnitude() + (b * e).magnitude() + (c * f).magnitude()
}
