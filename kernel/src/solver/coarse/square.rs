//! Square matrices of an elastic coarse level under tools, and their Cholesky factors.

use crate::number::sqrt::sqrt;

/// Most rows and columns.
pub(super) const COLUMNS: usize = 48;
/// Pivots below this share of the largest are taken as 0.
const LEAST: f32 = 1.0e-5;

pub(super) type Square = [[f32; COLUMNS]; COLUMNS];

/// An element of a square; 0 beyond it.
pub(super) fn at(square: &Square, row: usize, column: usize) -> f32 {
    square.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0.0)
}

pub(super) fn put(square: &mut Square, row: usize, column: usize, value: f32) {
    if let Some(slot) = square.get_mut(row).and_then(|row| row.get_mut(column)) {
        *slot = value;
    }
}

/// Replaces the lower triangle of a symmetric matrix by its Cholesky factor; a column whose pivot is lost in
/// rounding becomes 0.
pub(super) fn cholesky(matrix: &mut Square, count: usize) {
    let mut most = 0.0;
    for i in 0..count {
        let own = at(matrix, i, i);
        most = if own > most { own } else { most };
    }
    for column in 0..count {
        let first = matrix.get(column).copied().unwrap_or([0.0; COLUMNS]);
        for row in matrix.iter_mut().take(count).skip(column) {
            let (known, rest) = row.split_at_mut(column.min(COLUMNS));
            if let Some(slot) = rest.first_mut() {
                *slot = known.iter().zip(&first).fold(*slot, |sum, (a, b)| sum - a * b);
            }
        }
        let pivot = at(matrix, column, column);
        let root = if pivot > LEAST * most { 1.0 / sqrt(pivot) } else { 0.0 };
        for row in column..count {
            let value = at(matrix, row, column);
            put(matrix, row, column, value * root);
        }
    }
}

/// Adds numbers times a factor to sums.
#[inline(always)]
pub(super) fn add_scaled<'a>(pairs: impl Iterator<Item = (&'a mut f32, &'a f32)>, factor: f32) {
    for (sum, number) in pairs {
        *sum += factor * number;
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A symmetric positive matrix.
    pub fn matrix(count: usize) -> Square {
        let mut matrix = [[0.0; COLUMNS]; COLUMNS];
        for (a, row) in matrix.iter_mut().enumerate().take(count) {
            for (b, slot) in row.iter_mut().enumerate().take(count) {
                *slot = 1.0 / (1.0 + a.abs_diff(b) as f32) + if a == b { 2.0 } else { 0.0 };
            }
        }
        matrix
    }

    #[test]
    fn a_cholesky_factor_times_itself_is_the_matrix() {
        for count in [1, 2, 7, COLUMNS] {
            let (whole, mut factor) = (matrix(count), matrix(count));
            cholesky(&mut factor, count);
            for a in 0..count {
                for b in 0..=a {
                    let sum: f32 = (0..=b).map(|k| factor[a][k] * factor[b][k]).sum();
                    assert!((sum - whole[a][b]).abs() < 1e-5, "{count} {a} {b}");
                }
            }
        }
        // Of rank one: the remainder is zero.
        let mut same = [[0.0; COLUMNS]; COLUMNS];
        same.iter_mut().take(3).for_each(|row| row[..3].fill(4.0));
        cholesky(&mut same, 3);
        assert_eq!([same[0][0], same[2][0], same[1][1], same[2][2]], [2.0, 2.0, 0.0, 0.0]);
    }
}
