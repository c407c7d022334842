//! 3 x 3 matrices, for one cell or for eight side by side.
//!
//! Element by element, without loops and array methods: those are not always inlined, and vector arithmetic
//! is slow outside the functions that are built for the unit.

use crate::backend::lane::{Lane, Real};

/// Rows of a matrix.
pub(crate) type Matrix<V> = [[Lane<V>; 3]; 3];

/// Maps three numbers.
#[inline(always)]
pub(super) fn three<A, B>([a, b, c]: [A; 3], of: impl Fn(A) -> B) -> [B; 3] {
    [of(a), of(b), of(c)]
}

/// Combines three pairs of numbers.
#[inline(always)]
pub(super) fn pairs<A, B, C>(
    [a, b, c]: [A; 3],
    [d, e, f]: [B; 3],
    of: impl Fn(A, B) -> C,
) -> [C; 3] {
    [of(a, d), of(b, e), of(c, f)]
}

/// Maps the elements of a matrix.
#[inline(always)]
pub(super) fn each<A, B>([a, b, c]: [[A; 3]; 3], of: impl Fn(A) -> B + Copy) -> [[B; 3]; 3] {
    [three(a, of), three(b, of), three(c, of)]
}

/// Combines two matrices element by element.
#[inline(always)]
pub(super) fn both<A, B, C>(
    [a, b, c]: [[A; 3]; 3],
    [d, e, f]: [[B; 3]; 3],
    of: impl Fn(A, B) -> C + Copy,
) -> [[C; 3]; 3] {
    [pairs(a, d, of), pairs(b, e, of), pairs(c, f, of)]
}

/// Sum of the products of the elements, row by row.
#[inline(always)]
pub(super) fn inner<V: Real>([a, b, c]: Matrix<V>, [d, e, f]: Matrix<V>) -> Lane<V> {
    dot(a, d) + dot(b, e) + dot(c, f)
}

#[inline(always)]
pub(super) fn dot<V: Real>([a, b, c]: [Lane<V>; 3], [d, e, f]: [Lane<V>; 3]) -> Lane<V> {
    a * d + b * e + c * f
}

#[inline(always)]
pub(super) fn minus<V: Real>(a: Matrix<V>, b: Matrix<V>) -> Matrix<V> {
    both(a, b, |a, b| a - b)
}

#[inline(always)]
fn cross<V: Real>([a, b, c]: [Lane<V>; 3], [d, e, f]: [Lane<V>; 3]) -> [Lane<V>; 3] {
    [b * f - c * e, c * d - a * f, a * e - b * d]
}

/// The cofactors: the derivative of the determinant.
#[inline(always)]
pub(super) fn cofactors<V: Real>([a, b, c]: Matrix<V>) -> Matrix<V> {
    [cross(b, c), cross(c, a), cross(a, b)]
}

/// A matrix times the transpose of another.
#[inline(always)]
pub(super) fn times_transposed<V: Real>([a, b, c]: Matrix<V>, other: Matrix<V>) -> Matrix<V> {
    [times(other, a), times(other, b), times(other, c)]
}

/// A matrix times a column.
#[inline(always)]
pub(super) fn times<V: Real>([a, b, c]: Matrix<V>, column: [Lane<V>; 3]) -> [Lane<V>; 3] {
    [dot(a, column), dot(b, column), dot(c, column)]
}
