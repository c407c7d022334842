//! A body that relaxes, as it is in a tick.

use super::memory::{Arrays, arrays};
use crate::energy::following::{Course, Parts, Sums};
use crate::energy::links::follow as links;
use crate::energy::nodal::follow::remember;
use crate::model::branches::BranchNumbers;
use crate::model::image::{BRANCHES_MAX, branch};
use crate::model::nodal::{Nodal, Remembered};
use crate::model::relaxing_links::RelaxingLinks;
use crate::model::terms::TermData;
use crate::model::{Model, others};
use crate::number::two_float::{LANES, TwoFloat};
use crate::number::words::{number, words};

/// Branches of this many ticks and more follow the strain every [`SLOW_PERIOD`] ticks.
const SLOW_TICKS: f32 = 10_000.0;
const SLOW_PERIOD: u32 = 16;
/// Most ticks whose part of the modulus is told apart.
const TICKS_MAX: u32 = 64;
/// Most times [`TICKS_MAX`] ticks that count: then the slowest branch has forgotten nearly all.
const LONG_MAX: u32 = 1 << 17;
/// Bound of the rounding of the sums over the cells, relative to their terms' magnitudes.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// The branches at the start of a tick; those beyond the body's have no share.
pub(crate) type Courses = [Course; BRANCHES_MAX];

/// A body that relaxes.
pub(crate) struct RelaxingBody<'a, 'm> {
    pub arrays: Arrays<'a>,
    pub model: &'a Model<'m>,
    branches: &'m [BranchNumbers],
}

/// Change of a body's memory at the start of a tick.
#[derive(Clone, Copy)]
pub(crate) struct Change {
    /// Change of the energy, rounded up, in internal units; 0 within its rounding.
    pub rise: f64,
    /// True if any bit of the memory or any weight has changed.
    pub any: bool,
}

impl<'a, 'm> RelaxingBody<'a, 'm> {
    /// The body with these words of the caller; `None` for an elastic one, and if they are too few.
    pub fn of(words: &'a mut [u32], model: &'a Model<'m>) -> Option<Self> {
        let arrays = arrays(words, model)?;
        Some(Self { arrays, model, branches: model.others.branches() })
    }

    /// Forgets all strain.
    pub fn reset(&mut self) {
        *self.arrays.since = [0; _];
        *self.arrays.taken = [0; _];
        *self.arrays.remembered = [[0; 2]; _];
        *self.arrays.relaxed = [0; 2];
        self.arrays.rows.fill([[0.0; LANES]; _]);
        self.arrays.numbers.fill([[0.0; LANES]; _]);
        self.arrays.link_rows.fill([0.0; LANES]);
        self.arrays.link_numbers.fill([[0.0; LANES]; _]);
    }

    /// Counts a tick. Places without a branch stay 0, so that a body at rest keeps its hash.
    pub fn count(&mut self) {
        for since in self.arrays.since.iter_mut().take(self.branches.len()) {
            *since = since.saturating_add(1);
        }
    }

    /// Number of branches.
    pub fn branches(&self) -> usize {
        self.branches.len()
    }

    /// The branches as they are between two ticks, all waiting.
    pub fn waiting(&self) -> Courses {
        let mut courses = [Course { share: 0.0, faded: 0.0, before: 0.0, weight: 0.0 }; _];
        let of_each = courses.iter_mut().zip(self.branches).zip(&*self.arrays.taken);
        for ((course, numbers), &taken) in of_each {
            let weight = weight(numbers, if taken == 0 { period(numbers) } else { taken });
            let share = numbers.get(branch::SHARE).copied().unwrap_or(0.0);
            *course = Course { share, faded: 0.0, before: weight, weight };
        }
        courses
    }

    /// The branches at the start of a tick with sweeps: those whose time has come follow.
    pub fn due(&mut self) -> Courses {
        let mut courses = self.waiting();
        let times = self.arrays.since.iter_mut().zip(&mut *self.arrays.taken);
        for ((course, numbers), (since, taken)) in courses.iter_mut().zip(self.branches).zip(times)
        {
            if *since >= period(numbers) {
                // The stress goes on from what it was: c (z - Y) falls to the part that is not forgotten.
                course.weight = weight(numbers, *since);
                let (faded, before) = (faded(numbers, *since), course.before / course.weight);
                let left = (1.0 - faded) * before;
                let changed = if left < 1.0 { 1.0 - left } else { 0.0 };
                course.faded = if course.before == course.weight { faded } else { changed };
                (*taken, *since) = (*since, 0);
            }
        }
        courses
    }

    /// Books what the memory has changed by, from the sums over all cells.
    pub fn book(&mut self, courses: &Courses, sums: &Sums) -> Change {
        let spread = f64::from(sums.spread.total());
        let (mut change, mut any) = (f64::from(sums.rise.total()), sums.moved);
        let remembered = self.arrays.remembered.iter_mut().zip(&sums.remembered);
        for (course, (square, [before, after])) in courses.iter().zip(remembered) {
            // k <- a^2 k - 2 a b u . f + b^2 u . S u.
            let (old, [before, after]) =
                (number(*square), [before, after].map(|sum| f64::from(sum.total())));
            let (a, b) = (1.0 - f64::from(course.faded), f64::from(course.faded));
            let new = a * a * old - 2.0 * a * b * before + b * b * spread;
            let new = if !sums.pushes || new < 0.0 { 0.0 } else { new };
            *square = words(new);
            // The energy share c / 2 (u . S u + 2 u . f + k).
            let energy = |weight: f32, work: f64, square: f64| {
                0.5 * f64::from(course.share * weight) * (spread + 2.0 * work + square)
            };
            change += energy(course.weight, after, new) - energy(course.before, before, old);
            any |= course.weight.to_bits() != course.before.to_bits();
        }
        *self.arrays.relaxed = words(number(*self.arrays.relaxed) - change);
        // A change within its rounding leaves the level as it is: it never rises by rounding.
        let rounding = ROUNDING * f64::from(sums.scale.total());
        let is_sure = change > rounding || change < -rounding;
        Change { rise: if is_sure { change + rounding } else { 0.0 }, any }
    }

    /// Energy that the branches have relaxed since the reset, in internal units.
    pub fn relaxed(&self) -> f64 {
        number(*self.arrays.relaxed)
    }

    /// Computes the numbers for a tick anew, of a restored body.
    pub fn derive(&mut self) {
        let (courses, count) = (self.waiting(), self.branches());
        let courses = courses.get(..count).unwrap_or(&[]);
        let shapes = others::shapes(&self.model.others);
        let slices = self.arrays.rows.chunks(count.max(1)).zip(&mut *self.arrays.numbers);
        for (slice, (rows, numbers)) in slices.enumerate() {
            remember(shapes, slice, courses, rows, numbers);
        }
        let of_links = RelaxingLinks(self.model);
        let groups = self.arrays.link_rows.chunks(count.max(1)).zip(&mut *self.arrays.link_numbers);
        for (group, (rows, numbers)) in groups.enumerate() {
            links::remember(of_links, group, courses, rows, numbers);
        }
    }

    /// The body as it is in this tick.
    pub fn into_model(self) -> Model<'a>
    where
        'm: 'a,
    {
        let courses = self.waiting();
        let part = Parts::of(&courses).acting;
        let energy =
            courses.iter().zip(*self.arrays.remembered).fold(0.0, |sum, (course, square)| {
                sum + 0.5 * f64::from(course.share * course.weight) * number(square)
            });
        let hi = energy as f32;
        let energy = TwoFloat { hi, lo: (energy - f64::from(hi)) as f32 };
        let (numbers, links) = (&*self.arrays.numbers, &*self.arrays.link_numbers);
        let memory = Remembered { numbers, links, part, energy };
        let shapes = Nodal { memory, ..others::shapes(&self.model.others) };
        Model { others: others::with_shapes(self.model.others, shapes), ..*self.model }
    }
}

/// Ticks between two times at which a branch follows.
fn period(numbers: &BranchNumbers) -> u32 {
    let time = numbers.get(branch::TIME_TICKS).copied().unwrap_or(0.0);
    if time >= SLOW_TICKS { SLOW_PERIOD } else { 1 }
}

/// b, the part that a branch forgets in some ticks.
fn faded(numbers: &BranchNumbers, ticks: u32) -> f32 {
    let parts = numbers.get(branch::FADED..).unwrap_or(&[]);
    let also = |first: f32, second: f32| first + second - first * second;
    let (long, rest) = (ticks / TICKS_MAX, ticks % TICKS_MAX);
    let mut faded = 0.0;
    for (power, &part) in parts.iter().enumerate() {
        if power < 6 && rest >> power & 1 == 1 {
            faded = also(faded, part);
        }
    }
    // Square after square of the longest one.
    let mut part = parts.last().copied().unwrap_or(0.0);
    let mut left = if long < LONG_MAX { long } else { LONG_MAX };
    while left > 0 {
        if left & 1 == 1 {
            faded = also(faded, part);
        }
        part = also(part, part);
        left >>= 1;
    }
    faded
}

/// c, the part of its modulus that a branch carries in a tick that counts for so many.
fn weight(numbers: &BranchNumbers, ticks: u32) -> f32 {
    let time = numbers.get(branch::TIME_TICKS).copied().unwrap_or(0.0);
    let ticks = ticks.clamp(1, TICKS_MAX);
    let weight = faded(numbers, ticks) * (time / ticks as f32);
    if weight < 1.0 { weight } else { 1.0 }
}
