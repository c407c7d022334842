//! The numbers that a network computes with, chosen at compile time: one kernel source.
//!
//! | number | where | square root and division of a link |
//! |---|---|---|
//! | `f32` | default; targets with an FPU | correctly rounded |
//! | [`I8F24`](fixed::types::I8F24) | targets without | integer |
//! | `f64` | references and tests | correctly rounded |
//!
//! Cells, links and inner products are computed in the number; what a sweep has few of (the
//! certified level, the factors of a step, tool and force) stays in single precision everywhere.

mod double;
mod fixed_point;
mod single;

use core::fmt::Debug;

use crate::cell::single;
use crate::link::Pull;
use crate::model::Model;
use crate::two_float::TwoFloat;

pub(crate) use sealed::Loops;

/// A sum over the cells.
pub trait Sum<P>: Default {
    /// Adds a cell's term; `lane` is the cell's place in its slice.
    fn add(&mut self, lane: usize, term: P);
    /// The sum of all lanes.
    fn total(&self) -> TwoFloat;
}

/// A number type of the network: arithmetic that has the same bits on every target.
pub trait Number: Copy + PartialEq + PartialOrd + Debug + Loops {
    /// Name as in the command's `--number`.
    const NAME: &'static str;
    /// +0.
    const ZERO: Self;
    /// Whether the hats of a model are used; without, `track` goes by its own cells alone.
    const HATS: bool;
    /// What rounding leaves open of a length, whatever its size, in units of the `f32` epsilon
    /// [mean link lengths].
    const GRAIN: f32 = 0.0;
    /// 32-bit words of a number, low word first.
    type Words: IntoIterator<Item = u32>;
    /// A sum of three products.
    type Product: Copy + PartialOrd;
    /// Sum of products over the cells.
    type Sum: Sum<Self::Product>;
    /// Sum of energies over the cells, to more than single precision.
    type Energy: Sum<Self::Product>;
    /// Energies counted link by link, for numbers whose fourth lane cannot carry them.
    type Tally: Default + Copy;
    /// The band of a link in rest lengths, as the sweep needs it.
    type Band: Copy;

    /// The nearest number, at the end of the range where there is none.
    fn from_single(value: f32) -> Self;
    /// The nearest `f32`.
    fn single(self) -> f32;
    /// The same value.
    fn double(self) -> f64;
    /// The bits.
    fn words(self) -> Self::Words;
    /// `self + other`.
    fn plus(self, other: Self) -> Self;
    /// `self - other`.
    fn minus(self, other: Self) -> Self;
    /// `self * other`.
    fn times(self, other: Self) -> Self;
    /// `-self`.
    fn opposite(self) -> Self;
    /// |self|.
    fn magnitude(self) -> Self;
    /// Inner product.
    fn inner(a: [Self; 3], b: [Self; 3]) -> Self::Product;
    /// A product in single precision.
    fn product_single(product: Self::Product) -> f32;
    /// What the fourth lane of a residual says of w d^2.
    fn mark(wd2: Self::Product) -> Self;
    /// Counts the w d^2 of a link.
    fn count(tally: &mut Self::Tally, wd2: Self::Product);
    /// The sum of w d^2 over the cells, from the fourth lanes or from the tally.
    fn energy(lanes: &Self::Energy, tally: Self::Tally) -> TwoFloat;
    /// A cell's term of that sum.
    fn energy_term(lane: Self) -> Self::Product;
    /// The band `1 - alpha` to `1 + alpha` (Eq. 5).
    fn band(alpha: f32) -> Self::Band;
    /// The pull of a link of rest length `l0` and weight `w` from `pi` to `pj`; inside its band
    /// `None` or zero. `rest_difference` gives `P_j` - `P_i` of the rest shape; it is asked only
    /// where the ends coincide.
    fn pull(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Self::Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<Pull<Self>>;
    /// The same in single precision, also where it leaves the number's range: for the few links of
    /// the cells that the tool holds.
    fn pull_single(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Self::Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<Pull> {
        let pull = Self::pull(pi, pj, l0, w, band, rest_difference)?;
        Some(Pull { force: single(pull.force), wd2: Self::product_single(pull.wd2) })
    }
    /// Whether the number's range carries the model.
    ///
    /// # Errors
    /// The parameter that is too large.
    fn admits(model: &Model<'_>) -> Result<(), RangeError>;
}

/// A model whose numbers leave the range of the number type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RangeError {
    /// The saturation K.
    Saturation {
        /// Of the model [mean link lengths].
        k: f32,
        /// Largest that the type carries.
        max: f32,
    },
    /// The largest mean weight of two linked cells.
    Degree {
        /// Of the model.
        degree: f32,
        /// Largest that the type carries.
        max: f32,
    },
    /// The smallest weight of a link.
    Weight {
        /// Of the model.
        weight: f32,
        /// Smallest that the type carries.
        min: f32,
    },
}

impl RangeError {
    /// The limit that the model leaves.
    #[must_use]
    pub fn limit(&self) -> f32 {
        match *self {
            Self::Saturation { max, .. } | Self::Degree { max, .. } => max,
            Self::Weight { min, .. } => min,
        }
    }
}

impl core::fmt::Display for RangeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Saturation { k, max } => write!(
                f,
                "K of the model is {k} mean link lengths, the number type carries {max}: bake it \
                 with a smaller --k-m"
            ),
            Self::Degree { degree, max } => write!(
                f,
                "two linked cells have a mean weight of {degree}, the number type carries {max}: \
                 take f32"
            ),
            Self::Weight { weight, min } => write!(
                f,
                "the softest link has {weight} of the mean stiffness, the number type carries \
                 {min}: take f32"
            ),
        }
    }
}

impl core::error::Error for RangeError {}

pub(crate) mod sealed {
    use crate::awake::{Awake, SliceSet};
    use crate::cell::Cell;
    use crate::contact::Contact;
    use crate::hats::{Coarse, Eight};
    use crate::model::Model;
    use crate::pass::Links;
    use crate::scalar;
    use crate::slice::Moved;
    use crate::two_float::TwoFloat;

    use super::Number;

    /// The arrays of `track`.
    pub struct Points<'a, N> {
        /// The published point x.
        pub published: &'a mut [Cell<N>],
        /// The point y of this pass.
        pub at: &'a mut [Cell<N>],
        /// The point of the pass before.
        pub before: &'a mut [Cell<N>],
        /// The residual at y.
        pub residual: &'a mut [Cell<N>],
    }

    /// The loops over links and cells, in the shape that suits number and machine; sealed.
    #[allow(private_interfaces)]
    pub trait Loops: Sized {
        /// Residuals and energy terms of awake slices, link by link.
        fn accumulate(
            links: Links<'_, '_>,
            awake: &SliceSet,
            v: &[Cell<Self>],
            residual: &mut [Cell<Self>],
        ) -> Self::Tally
        where
            Self: Number,
        {
            links.accumulate(awake, v, residual, |v| v)
        }

        /// Sums again, after a pass at the outputs `y` of the states, the residuals whose partial
        /// sums may have left the number's range.
        fn mend(
            links: Links<'_, '_>,
            awake: &SliceSet,
            v: &[Cell<Self>],
            residual: &mut [Cell<Self>],
            y: impl Fn([Self; 3]) -> [Self; 3],
        ) where
            Self: Number,
        {
            let _ = (links, awake, v, residual, y);
        }

        /// One link pass at the states `v`: residuals of awake slices, held cells masked; gives the
        /// energy in internal units.
        fn pass(
            links: Links<'_, '_>,
            awake: &SliceSet,
            v: &[Cell<Self>],
            residual: &mut [Cell<Self>],
            held: &[Contact<Self>],
        ) -> TwoFloat
        where
            Self: Number,
        {
            scalar::pass::energy(links, awake, v, residual, held)
        }

        /// One link pass of `track` at y: energy, r . r / W, r . s and r . `z_last`.
        fn track_pass(
            links: Links<'_, '_>,
            awake: &SliceSet,
            points: &mut Points<'_, Self>,
            held: &[Contact<Self>],
        ) -> [TwoFloat; 4]
        where
            Self: Number,
        {
            scalar::track::pass(links, awake, points, held)
        }

        /// The update of `track` without hats.
        fn track_step(
            links: Links<'_, '_>,
            awake: &Awake,
            points: &mut Points<'_, Self>,
            factors: [f32; 2],
        ) -> Moved
        where
            Self: Number,
        {
            scalar::track::step(links.model, awake, points, factors)
        }

        /// The coarse part of the direction, into the room; gives its inner product with the
        /// residual.
        fn coarse(
            links: Links<'_, '_>,
            residual: &[Cell<Self>],
            room: &mut [Eight],
            coarse: Coarse,
        ) -> TwoFloat {
            let _ = (links, residual, room, coarse);
            TwoFloat::ZERO
        }

        /// The update of `track` with the coarse part that stands in the room; whether some
        /// coordinate is beyond K.
        fn coarse_step(
            links: Links<'_, '_>,
            room: &[Eight],
            points: &mut Points<'_, Self>,
            factors: [f32; 2],
        ) -> bool {
            let _ = (links, room, points, factors);
            false
        }

        /// v += step r of the free cells in awake slices.
        fn euler_step(
            links: Links<'_, '_>,
            awake: &Awake,
            state: &mut [Cell<Self>],
            residual: &[Cell<Self>],
            step: f32,
        ) -> Moved
        where
            Self: Number,
        {
            scalar::euler::step(links.model, awake, state, residual, step)
        }
    }

    /// The model has hats that the number uses.
    pub(crate) fn hats<'m, N: Number>(model: &Model<'m>) -> Option<crate::hats::Hats<'m>> {
        model.hats.filter(|_| N::HATS)
    }
}
