//! Random numbers for the tests of splits.

/// Numbers between -1 and 1.
pub(super) struct Random(pub u32);

impl Random {
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// An index below a number.
    pub fn below(&mut self, count: usize) -> usize {
        ((0.5 * (self.next() + 1.0) * count as f32) as usize).min(count - 1)
    }
}
