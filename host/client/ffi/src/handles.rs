//! Handles: numbers, so that one that was closed, or never was, is told from one that is open.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use chaincell_client::Client;
use chaincell_client::contacts::Contact;
use chaincell_client::payload::NodePosition;
use chaincell_client::viewed::View;

use crate::code::{self, Code};

/// Most clients of a process.
const CLIENTS_MAX: usize = 64;

/// A client and what its caller holds of shared memory.
pub(crate) struct Open {
    pub state: Option<View<NodePosition>>,
    pub contacts: Option<View<Contact>>,
    // Behind what it lent.
    pub client: Client,
}

struct Slot {
    /// How often it was opened.
    generation: u64,
    open: Option<Arc<Mutex<Open>>>,
}

static SLOTS: [Mutex<Slot>; CLIENTS_MAX] =
    [const { Mutex::new(Slot { generation: 0, open: None }) }; CLIENTS_MAX];

/// Nothing panics while it holds a slot.
fn lock(slot: &Mutex<Slot>) -> MutexGuard<'_, Slot> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The slot that a handle names, and the generation that it must have.
fn slot_of(handle: u64) -> Option<(&'static Mutex<Slot>, u64)> {
    let slot = SLOTS.get(usize::try_from(handle % CLIENTS_MAX as u64).ok()?)?;
    Some((slot, handle / CLIENTS_MAX as u64)).filter(|(_, generation)| *generation != 0)
}

/// A handle for a client.
pub(crate) fn insert(client: Client) -> Result<u64, Code> {
    let open = Open { state: None, contacts: None, client };
    for (at, slot) in (0_u64..).zip(&SLOTS) {
        let mut slot = lock(slot);
        if slot.open.is_none() {
            slot.generation += 1;
            slot.open = Some(Arc::new(Mutex::new(open)));
            return Ok(slot.generation * CLIENTS_MAX as u64 + at);
        }
    }
    Err(Code::TooMany)
}

/// Does something with the client of a handle. Another thread's turn is not waited for.
pub(crate) fn with(
    handle: u64,
    work: impl FnOnce(&mut Open) -> Result<Code, Code>,
) -> Result<Code, Code> {
    let (slot, generation) = slot_of(handle).ok_or(Code::Closed)?;
    let open = {
        let slot = lock(slot);
        slot.open.clone().filter(|_| slot.generation == generation).ok_or(Code::Closed)?
    };
    let mut open = open.try_lock().map_err(|why| match why {
        TryLockError::WouldBlock => Code::Busy,
        TryLockError::Poisoned(_) => Code::Fault,
    })?;
    work(&mut open)
}

/// Forgets a handle; the client goes with its last call.
pub(crate) fn remove(handle: u64) -> Result<Code, Code> {
    let (slot, generation) = slot_of(handle).ok_or(Code::Closed)?;
    let open = {
        let mut slot = lock(slot);
        if slot.generation != generation {
            return Err(Code::Closed);
        }
        slot.open.take().ok_or(Code::Closed)?
    };
    drop(open);
    Ok(Code::Ok)
}

/// Does something, and lets no panic out: C has no name for it.
pub(crate) fn guarded(work: impl FnOnce() -> Result<Code, Code>) -> Code {
    code::begin();
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or(Err(Code::Fault)).unwrap_or_else(|code| {
        code::refused(code);
        code
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_nobody_opened_is_no_handle() {
        for handle in [0, 1, 63, 64, 65, 127, 1 << 32, u64::MAX] {
            assert_eq!(with(handle, |_| Ok(Code::Ok)), Err(Code::Closed), "{handle}");
            assert_eq!(remove(handle), Err(Code::Closed), "{handle}");
        }
    }

    #[test]
    fn a_panic_becomes_a_code() {
        assert_eq!(guarded(|| panic!("on purpose")), Code::Fault);
        assert_eq!(guarded(|| Err(Code::Busy)), Code::Busy);
    }
}
