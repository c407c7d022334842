//! A symmetric matrix with its entries near the diagonal, and Cholesky's factors of it.

/// Lanes of an inner product, so that it takes vector instructions.
const LANES: usize = 8;

/// The lower half of a symmetric matrix with `width` entries beside the diagonal, row by row; what
/// lies left of the first column is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    width: usize,
    rows: Vec<f64>,
}

impl Band {
    /// A matrix of zeros of `size` rows.
    pub fn new(size: usize, width: usize) -> Self {
        Self { width, rows: vec![0.0; size * (width + 1)] }
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.rows.len() / (self.width + 1)
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.rows[row * (self.width + 1)..(row + 1) * (self.width + 1)]
    }

    /// The entry at `row` and `column`, not above the diagonal and at most `width` below it.
    pub fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.rows[row * (self.width + 1) + self.width + column - row]
    }

    /// Makes an unknown known: its row and column are those of the unit matrix.
    pub fn hold(&mut self, unknown: usize) {
        let (width, size) = (self.width, self.size());
        self.rows[unknown * (width + 1)..(unknown + 1) * (width + 1)].fill(0.0);
        for row in unknown + 1..(unknown + width + 1).min(size) {
            *self.at(row, unknown) = 0.0;
        }
        *self.at(unknown, unknown) = 1.0;
    }

    /// Adds `share` of every diagonal entry to it.
    pub fn stiffen(&mut self, share: f64) {
        for row in 0..self.size() {
            *self.at(row, row) *= 1.0 + share;
        }
    }

    /// Factors the matrix in place; `None` where it is not positive definite. Cost: size times the
    /// square of the width.
    pub fn factor(mut self) -> Option<Factor> {
        let width = self.width;
        for row in 0..self.size() {
            let (above, own) = self.rows.split_at_mut(row * (width + 1));
            let own = &mut own[..=width];
            for column in row.saturating_sub(width)..row {
                // Columns of the one row that the other has too.
                let shift = row - column;
                let other = &above[column * (width + 1)..(column + 1) * (width + 1)];
                let sum = inner(&own[..width - shift], &other[shift..width]);
                own[width - shift] = (own[width - shift] - sum) / other[width];
            }
            let square = own[width] - inner(&own[..width], &own[..width]);
            if square.is_nan() || square <= 1e-12 * own[width].abs() {
                return None;
            }
            own[width] = square.sqrt();
        }
        Some(Factor(self))
    }
}

/// Cholesky's lower factor.
pub struct Factor(Band);

impl Factor {
    /// Solves for a right-hand side, in its place.
    pub fn solve(&self, x: &mut [f64]) {
        let (width, size) = (self.0.width, self.0.size());
        for row in 0..size {
            let (own, first) = (self.0.row(row), row.saturating_sub(width));
            let sum = inner(&own[width - (row - first)..width], &x[first..row]);
            x[row] = (x[row] - sum) / own[width];
        }
        for row in (0..size).rev() {
            let (own, first) = (self.0.row(row), row.saturating_sub(width));
            x[row] /= own[width];
            let value = x[row];
            let left = &own[width - (row - first)..width];
            x[first..row].iter_mut().zip(left).for_each(|(x, entry)| *x -= entry * value);
        }
    }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (a_whole, b_whole) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a_whole.remainder().iter().zip(b_whole.remainder()).map(|(a, b)| a * b);
    let rest: f64 = rest.sum();
    for (a, b) in a_whole.zip(b_whole) {
        for lane in 0..LANES {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_gives_the_right_hand_side_back() {
        let (size, width) = (37, 11);
        let mut band = Band::new(size, width);
        let entry = |row: usize, column: usize| ((row * 7 + column * 13) % 11) as f64 / 11.0 - 0.4;
        for row in 0..size {
            for column in row.saturating_sub(width)..row {
                *band.at(row, column) = entry(row, column);
            }
            *band.at(row, row) = 12.0;
        }
        let full = |row: usize, column: usize| match row.abs_diff(column) {
            0 => 12.0,
            off if off <= width => entry(row.max(column), row.min(column)),
            _ => 0.0,
        };
        let x: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
        let times = |row: usize| (0..size).map(|column| full(row, column) * x[column]).sum();
        let mut found: Vec<f64> = (0..size).map(times).collect();
        band.clone().factor().unwrap().solve(&mut found);
        assert!(found.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-12));
        *band.at(20, 20) = -1.0;
        assert!(band.clone().factor().is_none());
        band.hold(20);
        let mut held = vec![1.0; size];
        band.factor().unwrap().solve(&mut held);
        assert!((held[20] - 1.0).abs() < 1e-15);
    }
}
