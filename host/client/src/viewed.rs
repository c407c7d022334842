//! Messages for viewers: slices of one element with a header, sent outside the control loop at a bounded
//! rate. Readers keep only the newest, and one that does not read delays nobody.

use std::fmt::Debug;

use iceoryx2::port::ReceiveError;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::publish_subscribe;

use crate::error::{Error, Kind, Result};
use crate::services::{
    Ipc, NODES_MAX, PUBLISHERS_MAX, SUBSCRIBERS_MAX, SceneServices, port_error, service_error,
};

/// An element of a message for viewers.
pub trait Viewed: Debug + Copy + ZeroCopySend + 'static {
    /// Header of the slice: the tick that it belongs to.
    type Header: Debug + Copy + Default + ZeroCopySend;
    /// Name of a message in errors: "cannot send ...".
    const WHAT: &'static str;
    /// Text if there is none: "no state".
    const NONE: &'static str;

    /// Returns the name of the scene's service for it.
    fn name(scene: &SceneServices) -> &ServiceName;
}

/// The service of an element.
pub type Topic<T> = publish_subscribe::PortFactory<Ipc, [T], <T as Viewed>::Header>;

/// Opens or creates the service.
///
/// # Errors
/// The service exists with other types or limits.
pub fn topic<T: Viewed>(scene: &SceneServices) -> Result<Topic<T>> {
    let name = *T::name(scene);
    scene.further(move |node| opened::<T>(node, &name))
}

fn opened<T: Viewed>(node: &Node<Ipc>, name: &ServiceName) -> Result<Topic<T>> {
    node.service_builder(name)
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

/// A viewer's side; see [`StateReader`](crate::state::StateReader) and
/// [`ContactReader`](crate::contacts::ContactReader).
#[derive(Debug)]
pub struct Reader<T: Viewed> {
    topic: Topic<T>,
    subscriber: Subscriber<Ipc, [T], T::Header>,
}

impl<T: Viewed> Reader<T> {
    /// Joins the scene's readers.
    ///
    /// # Errors
    /// The service exists with other types or limits, or it has too many readers.
    pub fn open(scene: &SceneServices) -> Result<Self> {
        let topic = topic::<T>(scene)?;
        let subscriber = topic.subscriber_builder().buffer_size(1).create();
        let subscriber = subscriber.map_err(|why| port_error(T::name(scene), why))?;
        Ok(Self { topic, subscriber })
    }

    /// Returns true if a server sends.
    #[must_use]
    pub fn is_served(&self) -> bool {
        // Also connects, so that no message is missed.
        let _ = self.subscriber.update_connections();
        self.topic.dynamic_config().number_of_publishers() > 0
    }

    /// Returns the service, with its limits and types.
    #[must_use]
    pub fn topic(&self) -> &publish_subscribe::PortFactory<Ipc, [T], T::Header> {
        &self.topic
    }

    /// Returns the newest message that has not been taken, if any, in shared memory without a copy.
    ///
    /// # Errors
    /// Two messages are held already, or shared memory failed.
    pub fn borrow(&self) -> Result<Option<View<T>>> {
        let sample = self.subscriber.receive();
        let sample = sample.map_err(|why| {
            let text = match why {
                ReceiveError::ExceedsMaxBorrows => "two of them are held: let go of one".to_owned(),
                other => format!("{other:?}"),
            };
            Error::new(Kind::Connection, format!("cannot read {}: {text}", T::WHAT))
        })?;
        Ok(sample.map(View))
    }

    /// Returns a copy of the newest message that has not been taken, if any.
    ///
    /// # Errors
    /// Two messages are held already, or shared memory failed.
    pub fn take(&self) -> Result<Option<(T::Header, Vec<T>)>> {
        Ok(self.borrow()?.map(|view| (view.header(), view.rows().to_vec())))
    }
}

/// A message that stays in shared memory until this is dropped.
#[derive(Debug)]
pub struct View<T: Viewed>(Sample<Ipc, [T], T::Header>);

impl<T: Viewed> View<T> {
    /// Returns the header: the tick that the rows belong to.
    #[must_use]
    pub fn header(&self) -> T::Header {
        *self.0.user_header()
    }

    /// Returns its elements.
    #[must_use]
    pub fn rows(&self) -> &[T] {
        self.0.payload()
    }
}
