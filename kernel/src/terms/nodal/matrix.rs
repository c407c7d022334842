//! Matrices of three rows and three columns, for one cell or for eight side by side.

use crate::number::lane::{Lane, Real};

/// Rows of a matrix.
pub(crate) type Matrix<V> = [[Lane<V>; 3]; 3];

/// A matrix element by element.
#[inline(always)]
pub(super) fn matrix<V: Real>(of: impl Fn(usize, usize) -> Lane<V>) -> Matrix<V> {
    [[of(0, 0), of(0, 1), of(0, 2)], [of(1, 0), of(1, 1), of(1, 2)], [of(2, 0), of(2, 1), of(2, 2)]]
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
pub(super) fn minus<V: Real>([a, b, c]: Matrix<V>, [d, e, f]: Matrix<V>) -> Matrix<V> {
    let row = |[a, b, c]: [Lane<V>; 3], [d, e, f]: [Lane<V>; 3]| [a - d, b - e, c - f];
    [row(a, d), row(b, e), row(c, f)]
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

/// A matrix times a column.
#[inline(always)]
pub(super) fn times<V: Real>([a, b, c]: Matrix<V>, column: [Lane<V>; 3]) -> [Lane<V>; 3] {
    [dot(a, column), dot(b, column), dot(c, column)]
}
