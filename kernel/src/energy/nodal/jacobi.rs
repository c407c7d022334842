//! Eigenvalues and eigenvectors of a symmetric 3 x 3 matrix by a fixed number of cyclic Jacobi rotations (Golub,
//! Van Loan, Matrix Computations, algorithm 8.4.1): four rounds leave an error below rounding.

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
use super::jacobi_vfp;
use super::matrix::Matrix;
use crate::backend::f32x8::F32x8;
use crate::backend::lane::{Lane, Real};

/// Rounds of three rotations.
const ROUNDS: usize = 4;

/// A number that matrices are diagonalised in.
pub(super) trait Eigen: Real {
    /// Eigenvalues and eigenvectors, by rows, of the matrix with these diagonal and off-diagonal elements: xy,
    /// xz and yz.
    fn eigen(diagonal: [Lane<Self>; 3], beside: [Lane<Self>; 3])
    -> ([Lane<Self>; 3], Matrix<Self>);
}

impl<V: F32x8> Eigen for V {
    #[inline(always)]
    fn eigen(diagonal: [Lane<V>; 3], beside: [Lane<V>; 3]) -> ([Lane<V>; 3], Matrix<V>) {
        rotated(diagonal, beside)
    }
}

/// Few shapes of one cell need it: not inlined, so that the others keep their registers.
impl Eigen for f32 {
    #[inline(never)]
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    fn eigen(
        [a, b, c]: [Lane<f32>; 3],
        [p, q, r]: [Lane<f32>; 3],
    ) -> ([Lane<f32>; 3], Matrix<f32>) {
        jacobi_vfp::rotated([a, b, c, p, q, r].map(|x| x.0), ROUNDS)
    }

    #[inline(never)]
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    fn eigen(diagonal: [Lane<f32>; 3], beside: [Lane<f32>; 3]) -> ([Lane<f32>; 3], Matrix<f32>) {
        rotated(diagonal, beside)
    }
}

/// A rotation that removes the element `off` between the diagonal elements `a` and `b`: returns its tangent
/// times the element, its cosine and its sine.
#[inline(always)]
fn rotation<V: Real>(a: Lane<V>, b: Lane<V>, off: Lane<V>) -> [Lane<V>; 3] {
    let (zero, one, two) = (Lane::of(0.0), Lane::of(1.0), Lane::of(2.0));
    let apart = b - a;
    let size = Lane::select(zero.above(apart), zero - apart, apart);
    let way = Lane::select(zero.above(apart), zero - two, two) * off;
    let length = size + (apart * apart + (off + off) * (off + off)).root();
    let tangent = way / (length + Lane::of(f32::MIN_POSITIVE));
    let cosine = one / (one + tangent * tangent).root();
    [tangent * off, cosine, tangent * cosine]
}

/// Rotates two columns of eigenvectors.
#[inline(always)]
fn turned<V: Real>(
    one: [Lane<V>; 3],
    other: [Lane<V>; 3],
    cosine: Lane<V>,
    sine: Lane<V>,
) -> [[Lane<V>; 3]; 2] {
    let ([a, b, c], [d, e, f]) = (one, other);
    [
        [cosine * a - sine * d, cosine * b - sine * e, cosine * c - sine * f],
        [sine * a + cosine * d, sine * b + cosine * e, sine * c + cosine * f],
    ]
}

/// Eigenvalues and eigenvectors.
#[inline(always)]
fn rotated<V: Real>(
    [mut a, mut b, mut c]: [Lane<V>; 3],
    [mut p, mut q, mut r]: [Lane<V>; 3],
) -> ([Lane<V>; 3], Matrix<V>) {
    let (zero, one) = (Lane::of(0.0), Lane::of(1.0));
    let [mut x, mut y, mut z] = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    for _ in 0..ROUNDS {
        let [moved, cosine, sine] = rotation(a, b, p);
        (a, b, p) = (a - moved, b + moved, zero);
        (q, r) = (cosine * q - sine * r, sine * q + cosine * r);
        [x, y] = turned(x, y, cosine, sine);
        let [moved, cosine, sine] = rotation(a, c, q);
        (a, c, q) = (a - moved, c + moved, zero);
        (p, r) = (cosine * p - sine * r, sine * p + cosine * r);
        [x, z] = turned(x, z, cosine, sine);
        let [moved, cosine, sine] = rotation(b, c, r);
        (b, c, r) = (b - moved, c + moved, zero);
        (p, q) = (cosine * p - sine * q, sine * p + cosine * q);
        [y, z] = turned(y, z, cosine, sine);
    }
    ([a, b, c], [x, y, z])
}
