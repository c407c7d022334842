//! When something is sent to viewers: between ticks, while nobody waits for an answer, if somebody
//! reads and something is new, at most so many times a second.

use std::fmt::Debug;

use iceoryx2::prelude::{CallbackProgression, ZeroCopySend};
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::error::{Error, Result};
use crate::session::ipc::services::Ipc;
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS};

/// Most states a second, and contacts.
pub const STATE_HZ_MAX: u32 = 1000;
/// Span between looks for readers \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;

/// The pace of what is sent to the readers of one service.
#[derive(Debug)]
pub(crate) struct Pace {
    period_ns: u64,
    due_ns: u64,
    /// Sum over the ids of the readers, which changes when one joins.
    readers: u128,
    new: bool,
}

impl Pace {
    /// At most `hz` times a second.
    ///
    /// # Errors
    /// A rate out of range.
    pub(crate) fn new(hz: u32) -> Result<Self> {
        if !(1..=STATE_HZ_MAX).contains(&hz) {
            return Err(Error::input(format!(
                "`state_hz` {hz}: must be from 0 (off) to {STATE_HZ_MAX}"
            )));
        }
        Ok(Self { period_ns: SECOND_NS / u64::from(hz), due_ns: 0, readers: 0, new: true })
    }

    /// There is something else than what was sent last.
    pub(crate) fn changed(&mut self) {
        self.new = true;
    }

    /// It was sent.
    pub(crate) fn sent(&mut self) {
        self.new = false;
    }

    /// Whether to send now; where a pose may be waiting (`idle` is false) only once it is overdue by
    /// a period.
    pub(crate) fn is_due<Element: Debug + ZeroCopySend, Header: Debug + ZeroCopySend>(
        &mut self,
        topic: &PortFactory<Ipc, [Element], Header>,
        now_ns: u64,
        idle: bool,
    ) -> bool {
        let due_ns = self.due_ns + if idle { 0 } else { self.period_ns };
        if now_ns < due_ns {
            return false;
        }
        let service = topic.dynamic_config();
        if service.number_of_subscribers() == 0 {
            self.readers = 0;
            self.due_ns = now_ns + LOOK_NS.min(self.period_ns);
            return false;
        }
        let mut readers = 0_u128;
        service.list_subscribers(|details| {
            readers = readers.wrapping_add(details.subscriber_id.value());
            CallbackProgression::Continue
        });
        self.new |= readers != self.readers;
        self.readers = readers;
        // The list costs iceoryx2 an allocation: with readers there is a look a period.
        self.due_ns = now_ns + self.period_ns;
        self.new
    }
}
