//! The array element of the kernel: one cell's coordinates, aligned for one 16-byte load.

/// Four single-precision lanes: x, y, z and one more.
///
/// Positions carry 0 in the fourth lane; the residual carries the cell's sum of w d^2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C, align(16))]
pub struct Cell(pub [f32; 4]);

impl Cell {
    /// All lanes +0.0.
    pub const ZERO: Self = Self([0.0; 4]);

    /// A position; the fourth lane is 0.
    #[must_use]
    #[inline(always)]
    pub const fn at(position: [f32; 3]) -> Self {
        let [x, y, z] = position;
        Self([x, y, z, 0.0])
    }

    /// The first three lanes.
    #[must_use]
    #[inline(always)]
    pub const fn xyz(self) -> [f32; 3] {
        let [x, y, z, _] = self.0;
        [x, y, z]
    }

    /// Sum by lane, for one vector addition.
    #[must_use]
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a + e, b + f, c + g, d + h])
    }

    /// The fourth lane.
    #[must_use]
    #[inline(always)]
    pub const fn w(self) -> f32 {
        let [_, _, _, w] = self.0;
        w
    }
}

/// `a - b` by coordinate.
#[must_use]
#[inline(always)]
pub fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + b` by coordinate.
#[must_use]
#[inline(always)]
pub fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `s a` by coordinate.
#[must_use]
#[inline(always)]
pub fn scale(s: f32, a: [f32; 3]) -> [f32; 3] {
    [s * a[0], s * a[1], s * a[2]]
}

/// Inner product, added up in the order x, y, z: part of the bit-exact definition.
#[must_use]
#[inline(always)]
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The output of the network (Eq. 3): every coordinate clamped to `[-k, k]`.
///
/// Written as a clamp, which equals the state bit for bit inside the range; the paper's
/// `(|v + K| - |v - K|) / 2` does not in floating point.
#[must_use]
#[inline(always)]
pub fn output(v: [f32; 3], k: f32) -> [f32; 3] {
    let one = |v: f32| {
        if v > k {
            k
        } else if v < -k {
            -k
        } else {
            v
        }
    };
    [one(v[0]), one(v[1]), one(v[2])]
}

/// Largest absolute coordinate.
#[must_use]
#[inline(always)]
pub fn peak(a: [f32; 3]) -> f32 {
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    larger(larger(magnitude(a[0]), magnitude(a[1])), magnitude(a[2]))
}

#[inline(always)]
fn magnitude(a: f32) -> f32 {
    f32::from_bits(a.to_bits() & 0x7fff_ffff)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_is_the_state_inside_and_the_bound_outside() {
        assert_eq!(output([0.3, -7.0, 7.5], 7.0), [0.3, -7.0, 7.0]);
        assert_eq!(output([f32::MAX, f32::MIN, -7.1], 7.0), [7.0, -7.0, -7.0]);
    }

    #[test]
    fn peak_takes_the_largest_magnitude() {
        assert_eq!(peak([1.0, -3.0, 2.0]), 3.0);
    }
}
