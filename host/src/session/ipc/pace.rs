//! Rate limit of the data for viewers. It is sent between ticks while no pose waits for its answer, if there
//! are a reader and new data, at most at a given rate.

use std::fmt::Debug;

use iceoryx2::prelude::{CallbackProgression, ZeroCopySend};
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::error::{Error, Result};
use crate::session::ipc::services::Ipc;
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS};

/// Highest rate of states and of contacts \[Hz\].
pub const STATE_HZ_MAX: u32 = 1000;
/// Time between checks for readers \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;

/// Rate limit of one service.
#[derive(Debug)]
pub(crate) struct Pace {
    period_ns: u64,
    due_ns: u64,
    /// Sum of the readers' ids, which changes when one joins.
    readers: u128,
    new: bool,
}

impl Pace {
    /// Creates a limit of `hz` messages per second.
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

    /// Notes that there is new data.
    pub(crate) fn changed(&mut self) {
        self.new = true;
    }

    /// Notes that the data was sent.
    pub(crate) fn sent(&mut self) {
        self.new = false;
    }

    /// Returns true if it is time to send. While a pose may be waiting (`idle` is false), the message has to
    /// be overdue by a period.
    pub(crate) fn is_due<Element: Debug + ZeroCopySend, Header: Debug + ZeroCopySend>(
        &mut self,
        topic: &PortFactory<Ipc, [Element], Header>,
        now_ns: u64,
        idle: bool,
    ) -> bool {
        // Wait for the period, or two of them.
        let due_ns = self.due_ns + if idle { 0 } else { self.period_ns };
        if now_ns < due_ns {
            return false;
        }
        // Without readers nothing is sent.
        let service = topic.dynamic_config();
        if service.number_of_subscribers() == 0 {
            self.readers = 0;
            self.due_ns = now_ns + LOOK_NS.min(self.period_ns);
            return false;
        }
        // A new reader gets the data even if it is unchanged.
        let mut readers = 0_u128;
        service.list_subscribers(|details| {
            readers = readers.wrapping_add(details.subscriber_id.value());
            CallbackProgression::Continue
        });
        self.new |= readers != self.readers;
        self.readers = readers;
        // The list makes iceoryx2 allocate: with readers it is read once per period.
        self.due_ns = now_ns + self.period_ns;
        self.new
    }
}
