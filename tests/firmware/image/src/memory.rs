//! The body's memory: the arrays of a `Tissue`, each a static of its own.
//!
//! A `Tissue` holds a few bytes that are not zero from the start, and as one static would lie in
//! flash with all its zeros; apart, only the head does.

use chaincell_kernel::cell::Cell;
use chaincell_kernel::contact::Contact;
use chaincell_kernel::dynamics::{CellArrays, NumberOf, Octets};
use chaincell_kernel::{Dynamics, Head, TissueMut};
use static_cell::ConstStaticCell;

use crate::scene::{CELLS, HELD, Scheme};

type Number = NumberOf<Scheme>;
type Residual = <Scheme as Dynamics>::Residual<CELLS>;
type Arrays = <Scheme as Dynamics>::Arrays<CELLS>;
type Room = <Scheme as Dynamics>::Room;

static HEAD: ConstStaticCell<Head<Scheme>> = ConstStaticCell::new(Head::NEW);
static STATE: ConstStaticCell<[Cell<Number>; CELLS]> = ConstStaticCell::new([Cell::ZERO; CELLS]);
static RESIDUAL: ConstStaticCell<Residual> =
    ConstStaticCell::new(<Residual as CellArrays<Number>>::ZERO);
static OWN: ConstStaticCell<Arrays> = ConstStaticCell::new(<Arrays as CellArrays<Number>>::ZERO);
static ROOM: ConstStaticCell<Room> = ConstStaticCell::new(<Room as Octets>::ZERO);
static CONTACTS: ConstStaticCell<[Contact<Number>; HELD.len()]> =
    ConstStaticCell::new([Contact::NONE; HELD.len()]);

/// The tissue; `None` the second time.
pub fn take() -> Option<TissueMut<'static, Scheme>> {
    Some(TissueMut {
        head: HEAD.try_take()?,
        state: STATE.try_take()?,
        residual: RESIDUAL.try_take()?.flat(),
        own: OWN.try_take()?.flat(),
        room: ROOM.try_take()?.flat(),
        contacts: CONTACTS.try_take()?,
    })
}
