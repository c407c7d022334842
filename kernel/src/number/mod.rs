//! Arithmetic that has the same bits on every target: numbers, cells of them, sums, roots.
//!
//! A network computes in one number type, chosen at compile time: one kernel source.
//!
//! | number | for | coordinates | schemes | loops |
//! |---|---|---|---|---|
//! | `f32` | default; targets with an FPU | K up to [`COORDINATE_MAX`](crate::COORDINATE_MAX) mean link lengths | all, with the coarse level | vector units, the Cortex-M's FPU, cell by cell |
//! | [`I8F24`](fixed::types::I8F24) | targets without an FPU: integer root and division | 8.24 bits: K up to 63 mean link lengths | `euler`, `track` without the coarse level | cell by cell |
//!
//! Fixed point accepts weights from 1/64, and mean weights of two linked cells up to 60. A reset refuses
//! other models and names the limit ([`RangeError`](crate::RangeError)).
//!
//! Cells, links and inner products are computed in the number. The few scalars of a sweep (the certified
//! level, the factors of a step, tool and force) are in single precision under every number type. Positions,
//! samples and forces at the interface are `f32` under every number type.
//!
//! **The same bits.** One number type gives the same bits on every target: one order of operations, roots and
//! divisions correctly rounded, no fused multiply-add, no approximate instruction, sums in a fixed tree. It
//! needs rounding to nearest and denormals, which a reset checks ([`float_env`]). Two number types give
//! different bits: the state hashes of `f32` and fixed point differ. On its way to the equilibrium `track` takes
//! other steps in fixed point, since its decisions depend on the last bits; `tests/tests/kernel/numbers.rs`
//! bounds the difference. `tests/MEASURED.md` lists instructions on microcontrollers.

pub mod cell;
pub(crate) mod clamp;
pub(crate) mod fixed_point;
pub mod float_env;
pub(crate) mod kept;
mod single;
#[allow(unsafe_code)]
pub mod sqrt;
pub mod turn;
pub mod two_float;
#[cfg(any(feature = "cut", feature = "relax"))]
pub(crate) mod words;

use core::fmt::Debug;

use crate::number::kept::Kept;
use two_float::TwoFloat;

/// A sum over the cells.
pub trait Sum<P>: Default {
    /// Adds a cell's term; `lane` is the cell's place in its slice.
    fn add(&mut self, lane: usize, term: P);
    /// The sum of all lanes.
    fn total(&self) -> TwoFloat;
}

/// A number type of the network: arithmetic that has the same bits on every target.
///
/// ```
/// use chaincell_kernel::{I8F24, Number};
///
/// let tenth = I8F24::from_single(0.1); // 8.24 bits
/// assert!((tenth.double() - 0.1).abs() <= 1.0 / f64::from(1 << 25));
/// assert_eq!(I8F24::from_single(500.0), I8F24::MAX); // the end of the range, nearly 128
/// assert_eq!((<f32 as Number>::NAME, I8F24::NAME), ("f32", "fixed"));
/// ```
pub trait Number: Kept + PartialEq + PartialOrd + Debug {
    /// Name as in the command's `--precision`.
    const NAME: &'static str;
    /// +0.
    const ZERO: Self;
    /// A sum of three products.
    type Product: Copy + PartialOrd;
    /// Sum of products over the cells.
    type Sum: Sum<Self::Product>;
    /// Sum of products over the cells, to more than single precision.
    type WideSum: Sum<Self::Product>;

    /// The nearest number; a value out of range saturates.
    fn from_single(value: f32) -> Self;
    /// The nearest `f32`.
    fn single(self) -> f32;
    /// The same value in double precision.
    fn double(self) -> f64;
    /// The bits.
    fn word(self) -> u32;
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
    /// The cells, if these numbers are `f32`.
    #[inline(always)]
    fn singles(_cells: &[cell::Cell<Self>]) -> Option<&[cell::Cell]> {
        None
    }
}
