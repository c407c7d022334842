//! Cells that a tool holds or loads, and sums over the terms at them.

use crate::number::Number;
use crate::number::kept::kept;
use crate::number::two_float::TwoFloat;

kept! {
    /// A contact cell and where it was when the tool took hold of it [mean link lengths].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Contact<N = f32> {
        pub(crate) origin: [N; 3],
        id: u16,
    }
}

impl<N: Number> Contact<N> {
    /// An empty slot.
    pub const NONE: Self = Self { origin: [N::ZERO; 3], id: 0 };

    pub(crate) const fn new(id: u16) -> Self {
        Self { origin: [N::ZERO; 3], id }
    }

    /// The cell.
    #[must_use]
    #[inline]
    pub fn cell(&self) -> usize {
        usize::from(self.id)
    }
}

/// Energy of the terms at the held cells, and its rounding scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touched {
    /// Sum of w d^2, four times their energy.
    pub wd2: TwoFloat,
    /// Sum of w d (d + u): times eps, the rounding error of four times the energy.
    pub scale: f32,
}
