//! Memory that follows what a body strains, in branches that forget: what shapes and links have in common.
//!
//! A branch remembers y of a strain z. At the start of a tick y <- y + b (z - y), with b the part that it forgets until
//! the next one; during the tick it carries the part c of its modulus. This is the exact solution of
//! q' + q / tau = g z' for a z that changes evenly in a tick.
//!
//! **Rest.** Where a step changes no bit of y though z differs, y moves by a unit in the last place. Within 2^-20 of
//! z it stays as it is, and if z is as small, 1 + G times that with the sum G of the branches over what lasts, it
//! becomes 0: memory comes to rest, bit by bit, after some 8 to 15 tau of a held body, 1 + G times that of one that
//! is let go, and a body in its rest shape has none.

use crate::backend::lane::{Lane, Real};
use crate::model::image::BRANCHES_MAX;
use crate::number::two_float::{Lanes, Plain};

/// Distance at which a memory of strain stays as it is.
pub(crate) const NEAR: f32 = 1.0 / (1 << 20) as f32;
/// Three quarters of the spacing of `f32`: added to a number, it moves it by a unit in the last place.
const NUDGE: f32 = 0.75 * f32::EPSILON;

/// A branch at the start of a tick.
#[derive(Clone, Copy)]
pub(crate) struct Course {
    /// Share of the instantaneous modulus.
    pub share: f32,
    /// The part b that it forgets, 0 for one that waits.
    pub faded: f32,
    /// c until this tick, and from this tick on.
    pub before: f32,
    pub weight: f32,
}

/// Parts of the instantaneous modulus: the one that acts in a tick, and the one that lasts.
#[derive(Clone, Copy)]
pub(crate) struct Parts {
    pub acting: f32,
    pub lasting: f32,
}

impl Parts {
    pub fn of(courses: &[Course]) -> Self {
        let lasting = courses.iter().fold(1.0, |rest, course| rest - course.share);
        let add = |sum, course: &Course| sum + course.share * course.weight;
        Self { acting: courses.iter().fold(lasting, add), lasting }
    }
}

/// Sums over the cells or the half-links, in internal units; those of the spread are 0 in a body of links.
#[derive(Clone, Copy)]
pub(crate) struct Sums {
    /// Change of the energy of shapes or links.
    pub rise: Lanes,
    /// u . S u.
    pub spread: Lanes,
    /// u . f of each branch, before and after.
    pub remembered: [[Lanes; 2]; BRANCHES_MAX],
    /// Magnitudes of the sums' terms.
    pub scale: Plain,
    /// True if any memory has moved.
    pub moved: bool,
    /// True if any f is not 0.
    pub pushes: bool,
}

impl Sums {
    pub const NONE: Self = Self {
        rise: Lanes::ZERO,
        spread: Lanes::ZERO,
        remembered: [[Lanes::ZERO; 2]; BRANCHES_MAX],
        scale: Plain::ZERO,
        moved: false,
        pushes: false,
    };
}

/// Distances at which a memory stays as it is: from its target, and of the target from rest.
#[derive(Clone, Copy)]
pub(crate) struct Near<V> {
    target: Lane<V>,
    rest: Lane<V>,
}

impl<V: Real> Near<V> {
    /// A body that is let go follows its memory: the target is then at up to `distance` over the part that lasts.
    #[inline(always)]
    pub fn of(distance: Lane<V>, lasting: f32) -> Self {
        Self { target: distance, rest: distance / Lane::of(lasting) }
    }
}

/// A memory one step nearer to what it follows; `faded` is above 0.
#[inline(always)]
pub(crate) fn follow<V: Real>(
    target: Lane<V>,
    memory: Lane<V>,
    faded: f32,
    near: Near<V>,
) -> Lane<V> {
    let (zero, way) = (Lane::of(0.0), target - memory);
    let next = memory + Lane::of(faded) * way;
    // At least a unit in the last place.
    let nudged = memory + (Lane::of(NUDGE) * memory).signed_as(way);
    let next = Lane::select(next.equals(memory), nudged, next);
    // Near its target it stays as it is, and near the rest shape it forgets all.
    let rest = Lane::select(target.magnitude().above(near.rest), memory, zero);
    // -0.0 becomes +0.0.
    Lane::select(way.magnitude().above(near.target), next, rest) + zero
}
