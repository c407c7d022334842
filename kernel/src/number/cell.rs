//! The array element of the kernel: one cell's coordinates, aligned for one 16-byte load.

use crate::number::Number;
use crate::number::kept::kept;

kept! {
    /// Four numbers: x, y, z and one more.
    ///
    /// Positions have 0 in the fourth lane; the residual has the cell's sum of w d^2, or with fixed-point numbers
    /// a mark that is 0 only if that sum is 0.
    ///
    /// ```
    /// use chaincell_kernel::Cell;
    ///
    /// let place = Cell::at([1.0, 2.0, 3.0]); // mean link lengths from the body's centre
    /// assert_eq!((place.xyz(), place.w()), ([1.0, 2.0, 3.0], 0.0));
    /// assert_eq!(align_of_val(&place), 16);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    #[repr(C, align(16))]
    pub struct Cell<N = f32>(pub [N; 4]);
}

impl<N: Number> Cell<N> {
    /// All lanes +0.0.
    pub const ZERO: Self = Self([N::ZERO; 4]);

    /// A position; the fourth lane is 0.
    #[must_use]
    #[inline(always)]
    pub const fn at(position: [N; 3]) -> Self {
        let [x, y, z] = position;
        Self([x, y, z, N::ZERO])
    }

    /// The first three lanes.
    #[must_use]
    #[inline(always)]
    pub const fn xyz(self) -> [N; 3] {
        let [x, y, z, _] = self.0;
        [x, y, z]
    }

    /// Sum by lane, for one vector addition.
    #[must_use]
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a.plus(e), b.plus(f), c.plus(g), d.plus(h)])
    }

    /// The fourth lane.
    #[must_use]
    #[inline(always)]
    pub const fn w(self) -> N {
        let [_, _, _, w] = self.0;
        w
    }
}

impl<N: Number> Default for Cell<N> {
    fn default() -> Self {
        Self::ZERO
    }
}

/// `a - b` by coordinate.
#[must_use]
#[inline(always)]
pub fn sub<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0].minus(b[0]), a[1].minus(b[1]), a[2].minus(b[2])]
}

/// `a + b` by coordinate.
#[must_use]
#[inline(always)]
pub fn add<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0].plus(b[0]), a[1].plus(b[1]), a[2].plus(b[2])]
}

/// `s a` by coordinate.
#[must_use]
#[inline(always)]
pub fn scale<N: Number>(s: N, a: [N; 3]) -> [N; 3] {
    [s.times(a[0]), s.times(a[1]), s.times(a[2])]
}

/// Inner product in single precision, added up in the order x, y, z: part of the bit-exact
/// definition.
#[must_use]
#[inline(always)]
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The output of the network (Eq. 3): every coordinate clamped to `[-k, k]`.
///
/// It is written as a clamp, which equals the state bit for bit inside the range; the paper's
/// `(|v + K| - |v - K|) / 2` does not in floating point.
#[must_use]
#[inline(always)]
pub fn output<N: Number>(v: [N; 3], k: N) -> [N; 3] {
    let low = k.opposite();
    // Two selections one after the other are two instructions where the target has such.
    let one = |v: N| {
        let v = if v < low { low } else { v };
        if v > k { k } else { v }
    };
    [one(v[0]), one(v[1]), one(v[2])]
}

/// Largest absolute coordinate.
#[must_use]
#[inline(always)]
pub fn peak<N: Number>(a: [N; 3]) -> N {
    let larger = |a: N, b: N| if a > b { a } else { b };
    larger(larger(a[0].magnitude(), a[1].magnitude()), a[2].magnitude())
}

/// Coordinates in single precision.
#[must_use]
#[inline(always)]
pub fn single<N: Number>(a: [N; 3]) -> [f32; 3] {
    [a[0].single(), a[1].single(), a[2].single()]
}

/// Coordinates from single precision.
#[must_use]
#[inline(always)]
pub fn from_single<N: Number>(a: [f32; 3]) -> [N; 3] {
    [N::from_single(a[0]), N::from_single(a[1]), N::from_single(a[2])]
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-ENE-08
    #[test]
    fn output_is_the_state_inside_and_the_bound_outside() {
        assert_eq!(output([0.3_f32, -7.0, 7.5], 7.0), [0.3, -7.0, 7.0]);
        assert_eq!(output([f32::MAX, f32::MIN, -7.1], 7.0), [7.0, -7.0, -7.0]);
    }

    #[test]
    fn peak_takes_the_largest_magnitude() {
        assert_eq!(peak([1.0_f32, -3.0, 2.0]), 3.0);
    }
}
