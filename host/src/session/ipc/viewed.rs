//! Data for viewers, on the server's side: sent between ticks, at a limited rate.

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::*;

pub use chaincell_client::viewed::{Reader, Viewed};
use chaincell_client::viewed::{Topic, topic};

use crate::error::Result;
use crate::session::ipc::complain::complain;
use crate::session::ipc::pace::Pace;
use crate::session::ipc::services::{Ipc, SceneServices, port_error};
use crate::session::timing::clock::now_ns;
use crate::session::timing::histogram::{Latencies, Summary};

/// The server's side.
#[derive(Debug)]
pub(crate) struct Feed<T: Viewed> {
    topic: Topic<T>,
    publisher: Publisher<Ipc, [T], T::Header>,
    pace: Pace,
    failed: u64,
    cost: Latencies,
}

impl<T: Viewed> Feed<T> {
    /// Opens a feed with capacity for `most` elements, sent at most `hz` times per second.
    pub(crate) fn open(scene: &SceneServices, most: usize, hz: u32) -> Result<Self> {
        let pace = Pace::new(hz)?;
        let topic = topic::<T>(scene)?;
        let publisher = topic
            .publisher_builder()
            .initial_max_slice_len(most.max(1))
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|why| port_error(T::name(scene), why))?;
        Ok(Self { topic, publisher, pace, failed: 0, cost: Latencies::new()? })
    }

    /// Notes that there is new data.
    pub(crate) fn changed(&mut self) {
        self.pace.changed();
    }

    /// Returns true if it is time to send, see [`Pace::is_due`].
    pub(crate) fn is_due(&mut self, now_ns: u64, idle: bool) -> bool {
        self.pace.is_due(&self.topic, now_ns, idle)
    }

    /// Sends `count` elements; the work on them began at `start_ns`. Does not allocate itself.
    pub(crate) fn send(
        &mut self,
        start_ns: u64,
        header: T::Header,
        (count, element): (usize, impl FnMut(usize) -> T),
    ) {
        let sent = self.publisher.loan_slice_uninit(count).map(|mut sample| {
            *sample.user_header_mut() = header;
            sample.write_from_fn(element).send()
        });
        match sent {
            Ok(Ok(_)) => {}
            Ok(Err(why)) => {
                complain(&mut self.failed, format_args!("cannot send {}", T::WHAT), why)
            }
            Err(why) => {
                complain(&mut self.failed, format_args!("cannot take memory for {}", T::WHAT), why)
            }
        }
        self.pace.sent();
        self.cost.record(now_ns() - start_ns);
    }

    /// Returns the number of messages sent, and their durations \[ns\].
    pub(crate) fn cost(&self) -> (u64, Summary) {
        (self.cost.count(), self.cost.summary())
    }
}
