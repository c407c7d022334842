//! Cells that a tool holds or loads, and sums over the terms at them.

use crate::number::Number;
use crate::number::kept::kept;
use crate::number::two_float::TwoFloat;

kept! {
    /// A contact cell and where it was when the tool took hold of it [mean link lengths].
    ///
    /// ```
    /// use chaincell_kernel::Contact;
    ///
    /// let memory = [Contact::<f32>::NONE; 4]; // for up to four cells
    /// assert!(memory.iter().all(|contact| contact.cell() == 0));
    /// ```
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

/// Returns true if a cell is among these, which are in ascending order.
pub(crate) fn is_among<N: Number>(contacts: &[Contact<N>], cell: usize) -> bool {
    contacts.binary_search_by_key(&cell, Contact::cell).is_ok()
}

/// Energy of the terms at the held cells, its rounding scale, and forces that come with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touched {
    /// Sum of w d^2, four times their energy.
    pub wd2: TwoFloat,
    /// Sum of w d (d + u): times eps, the rounding error of four times the energy.
    pub scale: f32,
    /// Force on the cells of terms that compute it together with their energy.
    pub force: [f32; 3],
}

impl Touched {
    pub const NONE: Self = Self { wd2: TwoFloat::ZERO, scale: 0.0, force: [0.0; 3] };
}
