//! The body's memory: one static, all zeros, so that none of it takes up flash.

#[cfg(feature = "words")]
use chaincell_kernel::CutRoom;
#[cfg(feature = "surface")]
use chaincell_kernel::TouchStore;
use chaincell_kernel::{Tissue, TissueMut};
use static_cell::ConstStaticCell;

#[cfg(feature = "words")]
use crate::scene::WORDS;
#[cfg(feature = "surface")]
use crate::scene::{ANCHORS, NEAR};
use crate::scene::{CELLS, HELD, STATES, Scheme};

static TISSUE: ConstStaticCell<Tissue<CELLS, Scheme, { HELD.len() }, STATES>> =
    ConstStaticCell::new(Tissue::new());

#[cfg(feature = "surface")]
static TOUCH: ConstStaticCell<TouchStore<CELLS, NEAR, ANCHORS>> =
    ConstStaticCell::new(TouchStore::new());

#[cfg(feature = "words")]
static MEMORY: ConstStaticCell<[u32; WORDS]> = ConstStaticCell::new([0; WORDS]);

/// The tissue; `None` the second time.
#[cfg(not(feature = "surface"))]
pub fn take() -> Option<TissueMut<'static, Scheme>> {
    Some(TISSUE.try_take()?.view())
}

/// The tissue with its memory for contact on the surface; `None` the second time.
#[cfg(all(feature = "surface", not(feature = "words")))]
pub fn take() -> Option<TissueMut<'static, Scheme>> {
    Some(TISSUE.try_take()?.touching(TOUCH.try_take()?.room()))
}

/// The tissue with its memory for contact on the surface and for cuts or strain; `None` the second time.
#[cfg(feature = "words")]
pub fn take() -> Option<TissueMut<'static, Scheme>> {
    let tissue = TISSUE.try_take()?.touching(TOUCH.try_take()?.room());
    Some(TissueMut { cut: CutRoom::new(MEMORY.try_take()?), ..tissue })
}
