//! One step towards the rotation and towards the shape of unit volume nearest to a shape.
//!
//! Both are variables of the energy: with them fixed its curvature is bounded, and no step leads away from
//! the shape. So the energy falls in every sweep, however far the variables are from the nearest ones.

use super::matrix::{Matrix, both, cofactors, dot, each, inner, minus, times_transposed};
use crate::backend::lane::{Lane, Real};

/// A unit quaternion, real part first.
pub(crate) type Turn<V> = [Lane<V>; 4];

/// A quarter of the root of 3: the longest step that never rotates away from F.
const STEP: f32 = 0.433_012_7;
/// Range of determinants in which a step towards unit volume is accepted.
const DETERMINANT_MIN: f32 = 0.25;
const DETERMINANT_MAX: f32 = 2.5;
/// A distance that is never accepted.
const FAR: f32 = f32::MAX;

/// The rotation of a unit quaternion.
#[inline(always)]
pub(crate) fn rotation<V: Real>([w, x, y, z]: Turn<V>) -> Matrix<V> {
    let (one, two) = (Lane::of(1.0), Lane::of(2.0));
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (x * y, x * z, y * z);
    let (wx, wy, wz) = (w * x, w * y, w * z);
    [
        [one - two * (yy + zz), two * (xy - wz), two * (xz + wy)],
        [two * (xy + wz), one - two * (xx + zz), two * (yz - wx)],
        [two * (xz - wy), two * (yz + wx), one - two * (xx + yy)],
    ]
}

/// A step of the rotation R towards the one nearest to F: R : F does not fall.
///
/// With B = F R' and a = (`B_32` - `B_23`, `B_13` - `B_31`, `B_21` - `B_12`) the step is
/// q <- (1, h) q, normalised, h = (sqrt 3 / 4) a / |F|.
#[inline(always)]
pub(crate) fn turned<V: Real>(f: Matrix<V>, turn: Turn<V>) -> Turn<V> {
    let b = times_transposed(f, rotation(turn));
    let size = inner(f, f).root() + Lane::of(f32::MIN_POSITIVE);
    let step = Lane::of(STEP) / size;
    let [[_, b12, b13], [b21, _, b23], [b31, b32, _]] = b;
    let (x, y, z) = (step * (b32 - b23), step * (b13 - b31), step * (b21 - b12));
    let [p, q, r, s] = turn;
    let [a, b, c, d] = [
        p - (x * q + y * r + z * s),
        q + (x * p + y * s - z * r),
        r + (y * p + z * q - x * s),
        s + (z * p + x * r - y * q),
    ];
    let (scale, zero) = (Lane::of(1.0) / (a * a + b * b + c * c + d * d).root(), Lane::of(0.0));
    // -0.0 becomes +0.0.
    [a * scale + zero, b * scale + zero, c * scale + zero, d * scale + zero]
}

/// A step of Q, whose determinant is 1, towards the nearest such shape to F, and the resulting squared
/// distance from F. If the step does not reduce the distance, Q stays.
///
/// The nearest one is F + p cof Q with det (F + p cof Q) = 1: three Newton steps on
/// J - 1 + p A + p^2 B + p^3, A = cof F : cof Q, B = F : Q, then the rest of the determinant is
/// divided out.
#[inline(always)]
pub(crate) fn of_unit_volume<V: Real>(f: Matrix<V>, unit: Matrix<V>) -> (Matrix<V>, Lane<V>) {
    // Newton steps for p.
    let (c, cofactors_f) = (cofactors(unit), cofactors(f));
    let [first, ..] = f;
    let [own, ..] = cofactors_f;
    let (a, b) = (inner(cofactors_f, c), inner(f, unit));
    let off = dot(first, own) - Lane::of(1.0);
    let mut p = Lane::of(0.0);
    for _ in 0..3 {
        let value = off + p * (a + p * (b + p));
        let slope = a + p * (Lane::of(2.0) * b + Lane::of(3.0) * p);
        // The nearest shape has a slope above 0.
        let slope = Lane::select(slope.above(Lane::of(f32::MIN_POSITIVE)), slope, Lane::of(1.0));
        p = p - value / slope;
    }
    // Divide out the rest of the determinant.
    let next = both(f, c, |f, c| f + p * c);
    let [first, second, third] = next;
    let [own, ..] = cofactors([first, second, third]);
    let determinant = dot(first, own);
    let (low, high) = (Lane::of(DETERMINANT_MIN), Lane::of(DETERMINANT_MAX));
    let tame = Lane::select(determinant.above(low), determinant, Lane::of(1.0));
    let scale = inverse_cube_root(Lane::select(high.above(tame), tame, Lane::of(1.0)));
    // -0.0 becomes +0.0.
    let next = each(next, |x| x * scale + Lane::of(0.0));
    // Take the step only if it reduces the distance.
    let (old, new) = (minus(f, unit), minus(f, next));
    let (old, new) = (inner(old, old), inner(new, new));
    let new = Lane::select(determinant.above(low), new, Lane::of(FAR));
    let new = Lane::select(high.above(determinant), new, Lane::of(FAR));
    let nearer = old.above(new);
    let taken = both(next, unit, |next, unit| Lane::select(nearer, next, unit));
    (taken, Lane::select(nearer, new, old))
}

/// The inverse of the cube root of a number from 1/4 to 5/2, by six Newton steps; exact for 1.
#[inline(always)]
fn inverse_cube_root<V: Real>(x: Lane<V>) -> Lane<V> {
    let (four, third) = (Lane::of(4.0), Lane::of(1.0 / 3.0));
    let mut root = (four - x) * third;
    for _ in 0..6 {
        root = root * ((four - x * root * root * root) * third);
    }
    root
}
