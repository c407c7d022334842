//! The body's memory: one static, all zeros, so that none of it takes up flash.

use chaincell_kernel::{Tissue, TissueMut};
use static_cell::ConstStaticCell;

use crate::scene::{CELLS, HELD, STATES, Scheme};

static TISSUE: ConstStaticCell<Tissue<CELLS, Scheme, { HELD.len() }, STATES>> =
    ConstStaticCell::new(Tissue::new());

/// The tissue; `None` the second time.
pub fn take() -> Option<TissueMut<'static, Scheme>> {
    Some(TISSUE.try_take()?.view())
}
