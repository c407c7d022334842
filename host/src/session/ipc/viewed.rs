//! What viewers read: slices of one element with a header, beside the loop, at a bounded pace. Readers keep
//! the newest alone, and one that does not read delays nobody.

use std::fmt::Debug;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe;

use crate::error::{Error, Result};
use crate::session::ipc::complain::complain;
use crate::session::ipc::pace::Pace;
use crate::session::ipc::services::{
    Ipc, NODES_MAX, PUBLISHERS_MAX, SUBSCRIBERS_MAX, SceneServices, port_error, service_error,
};
use crate::session::timing::clock::now_ns;
use crate::session::timing::histogram::{Latencies, Summary};

/// An element of what viewers read.
pub trait Viewed: Debug + Copy + ZeroCopySend + 'static {
    /// What the slice belongs to.
    type Header: Debug + Copy + Default + ZeroCopySend;
    /// What a message is called: "cannot send ...".
    const WHAT: &'static str;
    /// How it is called where there is none.
    const NONE: &'static str;

    /// The scene's service for it.
    fn name(scene: &SceneServices) -> &ServiceName;
}

type Topic<T> = publish_subscribe::PortFactory<Ipc, [T], <T as Viewed>::Header>;

fn topic<T: Viewed>(scene: &SceneServices) -> Result<Topic<T>> {
    let name = T::name(scene);
    scene
        .node
        .service_builder(name)
        .publish_subscribe::<[T]>()
        .user_header::<T::Header>()
        .enable_safe_overflow(true)
        .history_size(0)
        .subscriber_max_buffer_size(1)
        .max_publishers(PUBLISHERS_MAX)
        .max_subscribers(SUBSCRIBERS_MAX)
        .max_nodes(NODES_MAX)
        .open_or_create()
        .map_err(|why| service_error(name, why))
}

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
    /// Room for `most` elements, sent at most `hz` times a second.
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

    /// There is something else than what was sent last.
    pub(crate) fn changed(&mut self) {
        self.pace.changed();
    }

    /// Whether to send now, see [`Pace::is_due`].
    pub(crate) fn is_due(&mut self, now_ns: u64, idle: bool) -> bool {
        self.pace.is_due(&self.topic, now_ns, idle)
    }

    /// Sends so many elements; the work on them began at `start_ns`. Allocates nothing of its own.
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

    /// Messages sent, and the time each took \[ns\].
    pub(crate) fn cost(&self) -> (u64, Summary) {
        (self.cost.count(), self.cost.summary())
    }
}

/// A viewer's side.
#[derive(Debug)]
pub struct Reader<T: Viewed> {
    topic: Topic<T>,
    subscriber: Subscriber<Ipc, [T], T::Header>,
}

impl<T: Viewed> Reader<T> {
    /// Joins the scene's readers.
    ///
    /// # Errors
    /// A service with other types or limits; too many readers.
    pub fn open(scene: &SceneServices) -> Result<Self> {
        let topic = topic::<T>(scene)?;
        let subscriber = topic.subscriber_builder().buffer_size(1).create();
        let subscriber = subscriber.map_err(|why| port_error(T::name(scene), why))?;
        Ok(Self { topic, subscriber })
    }

    /// Whether a server sends.
    #[must_use]
    pub fn is_served(&self) -> bool {
        // Meanwhile the connection is made, so that no message is missed.
        let _ = self.subscriber.update_connections();
        self.topic.dynamic_config().number_of_publishers() > 0
    }

    /// Limits and types of the service.
    #[must_use]
    pub fn topic(&self) -> &publish_subscribe::PortFactory<Ipc, [T], T::Header> {
        &self.topic
    }

    /// The newest message that has not been taken, if any.
    ///
    /// # Errors
    /// What shared memory says.
    pub fn take(&self) -> Result<Option<(T::Header, Vec<T>)>> {
        let sample = self.subscriber.receive();
        let sample =
            sample.map_err(|why| Error::check(format!("cannot read {}: {why:?}", T::WHAT)))?;
        Ok(sample.map(|sample| (*sample.user_header(), sample.payload().to_vec())))
    }
}
