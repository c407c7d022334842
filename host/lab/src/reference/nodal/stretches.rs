//! Signed principal stretches of a 3 x 3 matrix.

use nalgebra::{Matrix3, Vector3};

/// Rounds of three rotations each; five are usual.
const ROUNDS_MAX: usize = 30;
/// A column below this share of the largest has no direction of its own.
const RANK: f64 = 1e-14;

/// F = left diag(values) right', left and right rotations.
///
/// The values fall, and the last one is negative where F turns a body inside out: no larger
/// |value| precedes it. The nearest rotation to F is left right'.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretches {
    pub left: Matrix3<f64>,
    pub values: [f64; 3],
    pub right: Matrix3<f64>,
}

impl Stretches {
    /// Jacobi's rotations of the columns until they are orthogonal (Hestenes 1958): accurate for
    /// small stretches too, which a decomposition of F'F is not.
    pub fn of(f: &Matrix3<f64>) -> Self {
        let (mut columns, mut right) = (*f, Matrix3::identity());
        for _ in 0..ROUNDS_MAX {
            let mut turned = false;
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                turned |= turn(&mut columns, &mut right, p, q);
            }
            if !turned {
                break;
            }
        }
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| columns.column(*b).norm().total_cmp(&columns.column(*a).norm()));
        let sorted = |of: &Matrix3<f64>| Matrix3::from_columns(&order.map(|k| of.column(k)));
        let (columns, mut right) = (sorted(&columns), sorted(&right));
        // A rotation, so that the sign of F's determinant is left to the last value.
        let last = right.column(0).cross(&right.column(1));
        let third = columns.column(2) * last.dot(&right.column(2)).signum();
        right.set_column(2, &last);
        let largest = columns.column(0).norm();
        let first = if largest > 0.0 { columns.column(0) / largest } else { Vector3::x() };
        let rest = columns.column(1) - first * first.dot(&columns.column(1));
        let second = if rest.norm() > RANK * largest {
            rest.normalize()
        } else {
            first.cross(&axis_across(&first)).normalize()
        };
        let across = first.cross(&second);
        Self {
            left: Matrix3::from_columns(&[first, second, across]),
            values: [largest, second.dot(&columns.column(1)), across.dot(&third)],
            right,
        }
    }

    /// left diag(values) right' with other values.
    #[inline]
    pub fn with(&self, values: [f64; 3]) -> Matrix3<f64> {
        self.left * Matrix3::from_diagonal(&Vector3::from(values)) * self.right.transpose()
    }
}

/// Makes two columns orthogonal; whether they were not.
fn turn(columns: &mut Matrix3<f64>, right: &mut Matrix3<f64>, p: usize, q: usize) -> bool {
    let (a, b) = (columns.column(p).norm_squared(), columns.column(q).norm_squared());
    let across = columns.column(p).dot(&columns.column(q));
    if across.abs() <= f64::EPSILON * (a * b).sqrt() {
        return false;
    }
    let zeta = (b - a) / (2.0 * across);
    let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = cosine * tangent;
    for of in [columns, right] {
        let (x, y) = (of.column(p).into_owned(), of.column(q).into_owned());
        of.set_column(p, &(x * cosine - y * sine));
        of.set_column(q, &(x * sine + y * cosine));
    }
    true
}

/// The axis to which a vector has the least part.
fn axis_across(v: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[v.iamin()] = 1.0;
    axis
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ordinary, inverted, flat, collapsed and equal stretches.
    #[test]
    fn the_parts_are_rotations_and_make_the_matrix() {
        let mut cases = vec![Matrix3::zeros(), Matrix3::identity(), -Matrix3::identity()];
        cases.push(Matrix3::from_diagonal(&Vector3::new(1e-9, 2.0, -0.5)));
        cases.push(Vector3::new(1.0, 2.0, 3.0) * Vector3::new(-1.0, 0.3, 0.2).transpose());
        cases.push(Matrix3::new(1.0, 0.2, 0.0, -0.3, 0.9, 0.1, 0.05, 0.4, -1.2));
        cases.push(Matrix3::new(1.0, 1e-9, 0.0, 0.0, 1.0, 1e-12, 1e-10, 0.0, 1.0));
        for f in cases {
            let found = Stretches::of(&f);
            let [a, b, c] = found.values;
            assert!((found.with(found.values) - f).norm() <= 1e-14 * (1.0 + f.norm()), "{f}");
            for rotation in [found.left, found.right] {
                assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < 1e-14);
                assert!((rotation.determinant() - 1.0).abs() < 1e-14, "{f}");
            }
            assert!(a >= b && b >= c.abs() - 1e-15, "{:?}", found.values);
        }
        assert_eq!(Stretches::of(&Matrix3::identity()).values, [1.0; 3]);
        assert_eq!(Stretches::of(&-Matrix3::identity()).values, [1.0, 1.0, -1.0]);
    }
}
