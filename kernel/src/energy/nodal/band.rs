//! The band of stretches: penalises a shape below the least allowed stretch.
//!
//! With R the carried rotation and S = sym(F R') - lo I, the shapes with S >= 0 are a convex set; for the
//! nearest R they are those whose signed principal stretches are all at least lo. The nearest of them to F is
//! F - S- R, with S- the negative part of S, so the energy band / 2 V |S-|^2 is half a squared distance.
//! Ordinary shapes have S >= 0, which three minors show without eigenvalues (Sylvester).

use super::jacobi::Eigen;
use super::matrix::{Matrix, both, dot, each, inner, three, times_transposed};
use crate::backend::lane::{Lane, Real};

/// Share of a squared distance from the rotation that leaves the minors their signs, whatever their rounding.
const SURE: f32 = 0.98;

/// Up to this squared distance from the rotation a shape is in the band: |S + (lo - 1) I| is at most |F - R|.
#[inline(always)]
pub(super) fn least_short<V: Real>(least: f32) -> Lane<V> {
    Lane::of(SURE * (1.0 - least) * (1.0 - least))
}

/// S- R and |S-|^2 of a shape with the rotation R, 0 for one in the band; `None` if all lanes are in the
/// band.
#[inline(always)]
pub(super) fn short<V: Eigen>(
    f: Matrix<V>,
    turn: Matrix<V>,
    least: f32,
) -> Option<(Matrix<V>, Lane<V>)> {
    // The elements of S, and its leading minors.
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = times_transposed(f, turn);
    let (half, least) = (Lane::of(0.5), Lane::of(least));
    let diagonal = [xx - least, yy - least, zz - least];
    let beside = [half * (xy + yx), half * (xz + zx), half * (yz + zy)];
    let ([a, b, c], [p, q, r]) = (diagonal, beside);
    let second = a * b - p * p;
    let third = c * second - (a * r * r - (p + p) * q * r + b * q * q);
    let zero = Lane::of(0.0);
    let lowest = lower(lower(a, second), third);
    let is_short = zero.above(lowest);
    if !V::any(is_short) {
        return None;
    }
    let negative = negative_part(diagonal, beside);
    // Lanes within the band stay 0, whatever the others need.
    let negative = each(negative, |x| Lane::select(is_short, x, zero));
    // S- times R.
    let [s, t, u] = negative;
    let [d, e, g] = turn;
    let row = |[x, y, z]: [Lane<V>; 3]| {
        let along = |at: [Lane<V>; 3]| dot([x, y, z], at);
        let ([d0, d1, d2], [e0, e1, e2], [g0, g1, g2]) = (d, e, g);
        [along([d0, e0, g0]), along([d1, e1, g1]), along([d2, e2, g2])]
    };
    Some(([row(s), row(t), row(u)], inner(negative, negative)))
}

#[inline(always)]
fn lower<V: Real>(a: Lane<V>, b: Lane<V>) -> Lane<V> {
    Lane::select(a.above(b), b, a)
}

/// The negative part of a symmetric matrix with these diagonal and off-diagonal elements: xy, xz and yz.
#[inline(always)]
fn negative_part<V: Eigen>(diagonal: [Lane<V>; 3], beside: [Lane<V>; 3]) -> Matrix<V> {
    let zero = Lane::of(0.0);
    let (values, [x, y, z]) = V::eigen(diagonal, beside);
    // Assemble the matrix from the negative eigenvalues.
    let below = |value: Lane<V>| Lane::select(zero.above(value), value, zero);
    let [a, b, c] = three(values, below);
    let outer = |value: Lane<V>, [x, y, z]: [Lane<V>; 3]| {
        let [u, v, w] = [value * x, value * y, value * z];
        [[u * x, u * y, u * z], [v * x, v * y, v * z], [w * x, w * y, w * z]]
    };
    let sum = both(outer(a, x), outer(b, y), |a, b| a + b);
    both(sum, outer(c, z), |a, b| a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lanes(of: [[f32; 3]; 3]) -> Matrix<f32> {
        each(of, Lane)
    }

    #[test]
    fn shapes_in_the_band_have_no_part_out_of_it() {
        for shape in [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[0.71, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 0.75]],
            [[1.2, 0.3, -0.1], [0.3, 0.95, 0.05], [-0.1, 0.05, 1.4]],
        ] {
            let unit = lanes([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            assert!(short(lanes(shape), unit, 0.7).is_none());
        }
    }

    /// Removing the result leads to the nearest shape in the band: its least stretch is the least allowed,
    /// and the removed part is orthogonal to the remaining excess.
    #[test]
    fn what_is_short_is_the_way_to_the_band() {
        let mut seed = 1_u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
        };
        let mut found = 0;
        for _ in 0..2000 {
            let (w, x, y, z) = (next(), next(), next(), next());
            let size = (w * w + x * x + y * y + z * z).sqrt();
            let turn = [w, x, y, z].map(|q| Lane(q / size));
            let turn = super::super::nearest::rotation(turn);
            let mut f = turn;
            for row in &mut f {
                for element in row {
                    element.0 += 0.8 * next();
                }
            }
            let Some((off, squared)) = short(f, turn, 0.7) else { continue };
            found += 1;
            // S of the remainder has no negative minor beyond rounding, and |S-|^2 agrees.
            let left = both(f, off, |f, off| f - off);
            let [[a, p, q], [p2, b, r], [q2, r2, c]] = times_transposed(left, turn);
            let s = [
                [a.0 - 0.7, 0.5 * (p.0 + p2.0), 0.5 * (q.0 + q2.0)],
                [0.5 * (p.0 + p2.0), b.0 - 0.7, 0.5 * (r.0 + r2.0)],
                [0.5 * (q.0 + q2.0), 0.5 * (r.0 + r2.0), c.0 - 0.7],
            ];
            let minors = [
                s[0][0],
                s[1][1],
                s[2][2],
                s[0][0] * s[1][1] - s[0][1] * s[0][1],
                s[0][0] * s[2][2] - s[0][2] * s[0][2],
                s[1][1] * s[2][2] - s[1][2] * s[1][2],
            ];
            assert!(minors.iter().all(|&minor| minor > -1e-4), "{minors:?}");
            let across = inner(lanes(s), times_transposed(off, turn));
            assert!(across.0.abs() < 1e-4, "{across:?}");
            assert!((inner(off, off).0 - squared.0).abs() < 1e-4 * (1.0 + squared.0));
        }
        assert!(found > 1000, "{found}");
    }
}
