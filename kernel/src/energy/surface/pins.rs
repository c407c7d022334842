//! Pins: samples of the surface on springs to places in the world.
//!
//! A pin holds samples of triangles, as a clip or a suture holds tissue. With q the position of a sample, p the
//! place where it is pinned and k its stiffness, the term is
//!
//! ```text
//! E_p = s^3 k |q - p|^2 / 2
//! ```
//!
//! p is where the sample was when it was pinned, so a pin starts without energy and without force. s is 1 until
//! the pin is released, and then falls to 0 within some ticks, which lowers the energy.
//!
//! **The theorem.** q is a mean of the triangle's corners with weights A between 0 and 1 whose sum is 1, so E_p
//! curves by k A' A, whose row sums are k A: the cells' bounds grow by k times their weight, whatever k is, and
//! every certificate of a scheme holds with that bound.

use super::edge::Pressed;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::kept::kept;

/// True if this kernel is built with pins.
pub const PINS_ARE_BUILT: bool = cfg!(feature = "pins");

kept! {
    /// A sample of the surface that a pin holds.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PinSample {
        /// Number of its pin.
        pub(crate) pin: u16,
        /// The corners of its triangle, and their weights at the sample.
        pub(crate) corners: [u16; 3],
        pub(crate) weights: [f32; 3],
        /// Name of the triangle, in the model's order.
        pub(crate) triangle: u32,
        /// The place where it is pinned [mean link lengths].
        pub(crate) place: [f32; 3],
        /// k [2 `k_ref`].
        pub(crate) full: f32,
        /// s.
        pub(crate) share: f32,
        /// Loss of s per tick; 0 while the pin holds.
        pub(crate) fade: f32,
    }
}

impl PinSample {
    /// An empty slot: all bits 0.
    pub const NONE: Self = Self {
        pin: 0,
        corners: [0; 3],
        weights: [0.0; 3],
        triangle: 0,
        place: [0.0; 3],
        full: 0.0,
        share: 0.0,
        fade: 0.0,
    };

    /// The same sample, pinned where it is.
    pub(crate) fn here(self, at: &impl Fn(usize) -> [f32; 3]) -> Self {
        Self { place: self.point(at), share: 1.0, fade: 0.0, ..self }
    }

    /// Its present position.
    pub(crate) fn point(&self, at: &impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let corners = self.corners.iter().zip(self.weights);
        corners.fold([0.0; 3], |sum, (&cell, weight)| add(sum, scale(weight, at(cell.into()))))
    }

    /// Its present stiffness.
    #[inline(always)]
    pub(crate) fn stiffness(&self) -> f32 {
        self.share * self.share * self.share * self.full
    }

    /// Its force on the tissue, and its energy.
    #[inline(always)]
    pub(crate) fn pull(&self, at: &impl Fn(usize) -> [f32; 3]) -> Pressed {
        let (way, k) = (sub(self.place, self.point(at)), self.stiffness());
        Pressed { force: scale(k, way), energy: 0.5 * k * dot(way, way) }
    }

    /// The corners with their part in the bound.
    pub(crate) fn bounds(&self) -> impl Iterator<Item = (usize, f32)> + use<> {
        let k = self.stiffness();
        self.corners.into_iter().zip(self.weights).map(move |(cell, w)| (cell.into(), w * k))
    }

    /// Returns true if both are of one triangle and one pin.
    pub(crate) fn is_with(&self, other: &Self) -> bool {
        (self.pin, self.triangle) == (other.pin, other.triangle)
    }

    /// Words of the state hash.
    pub(crate) fn words(&self) -> [u32; 16] {
        let [a, b, c] = self.weights.map(f32::to_bits);
        let [x, y, z] = self.place.map(f32::to_bits);
        let [k, s, fade] = [self.full, self.share, self.fade].map(f32::to_bits);
        let (pin, triangle) = (self.pin.into(), self.triangle);
        [pin, triangle, a, b, c, x, y, z, k, s, fade, 0, 0, 0, 0, 0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_the_slope_of_its_energy_and_starts_without_force() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.1], [0.0, 2.0, -0.2]];
        let sample = PinSample {
            corners: [0, 1, 2],
            weights: [0.2, 0.5, 0.3],
            full: 3.0,
            ..PinSample::NONE
        };
        let sample = sample.here(&|cell: usize| corners[cell]);
        let none = sample.pull(&|cell: usize| corners[cell]);
        assert_eq!((none.force, none.energy), ([0.0; 3], 0.0));
        for share in [1.0, 0.5_f32] {
            let sample = PinSample { share, ..sample };
            let moved = |x: f32| move |cell: usize| add(corners[cell], [x, 0.3, 0.0]);
            let step = 1.0e-2;
            let energy = |x: f32| sample.pull(&moved(x)).energy;
            let slope = (energy(0.5 + step) - energy(0.5 - step)) / (2.0 * step);
            let force = sample.pull(&moved(0.5)).force;
            assert!((slope + force[0]).abs() < 2e-3, "{slope} {force:?}");
            let whole: f32 = sample.bounds().map(|(_, part)| part).sum();
            assert!((force[0] + 0.5 * whole).abs() < 1e-5, "{force:?} {whole}");
        }
    }
}
