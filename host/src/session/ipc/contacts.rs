//! Contacts for viewers: what each tool touches and how hard, beside the loop, at the pace of states.
//!
//! A message is a slice of [`Contact`], one for each triangle in contact with a part of a tool, as the
//! rows of contacts.csv; it is empty where nothing is in contact. Readers keep the newest alone. It
//! is sent by servers that have tools on a contact surface.

use std::mem::{offset_of, size_of};

use chaincell_kernel::ContactForce;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe;

use crate::engine::tissue::TissueEngine;
use crate::engine::tools::CONTACTS_MAX;
use crate::error::{Error, Result};
use crate::session::ipc::complain::complain;
use crate::session::ipc::pace::Pace;
use crate::session::ipc::services::{
    Ipc, NODES_MAX, PUBLISHERS_MAX, SUBSCRIBERS_MAX, SceneServices, port_error, service_error,
};
use crate::session::timing::clock::now_ns;
use crate::session::timing::histogram::{Latencies, Summary};

/// One triangle in contact with one part of a tool: 52 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.Contact.v1")]
#[repr(C)]
pub struct Contact {
    /// Which tool.
    pub tool: u32,
    /// Which of its parts.
    pub part: u32,
    /// Input id of the triangle's corner that takes the largest share.
    pub node: u32,
    /// Where it acts, in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Pressure on the tool \[N\].
    pub normal_n: [f32; 3],
    /// Friction, or the pull of a grip, on the tool \[N\].
    pub tangential_n: [f32; 3],
    /// Area of the triangle at rest, as far as its points are in contact \[m2\].
    pub area_m2: f32,
}

/// What the contacts belong to: 24 bytes, the user header of a slice of [`Contact`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("chaincell.Contacts.v1")]
#[repr(C)]
pub struct ContactsHeader {
    /// Number of the last answered tick, 0 before the first.
    pub tick: u64,
    /// Ticks answered since the server began.
    pub ticks_answered: u64,
    /// Number of contacts in the slice.
    pub contacts: u32,
    /// Flags of the last answer.
    pub flags: u32,
}

const _: () = {
    assert!(size_of::<Contact>() == 52);
    assert!(offset_of!(Contact, tool) == 0);
    assert!(offset_of!(Contact, part) == 4);
    assert!(offset_of!(Contact, node) == 8);
    assert!(offset_of!(Contact, position_m) == 12);
    assert!(offset_of!(Contact, normal_n) == 24);
    assert!(offset_of!(Contact, tangential_n) == 36);
    assert!(offset_of!(Contact, area_m2) == 48);
    assert!(size_of::<ContactsHeader>() == 24);
    assert!(offset_of!(ContactsHeader, tick) == 0);
    assert!(offset_of!(ContactsHeader, ticks_answered) == 8);
    assert!(offset_of!(ContactsHeader, contacts) == 16);
    assert!(offset_of!(ContactsHeader, flags) == 20);
};

impl Contact {
    /// Of a contact of the tissue whose corner has this input id.
    #[must_use]
    pub fn of(node: u32, contact: &ContactForce) -> Self {
        Self {
            tool: contact.tool.into(),
            part: contact.part.into(),
            node,
            position_m: contact.position_m,
            normal_n: contact.normal_n,
            tangential_n: contact.tangential_n,
            area_m2: contact.area_m2,
        }
    }
}

type Topic = publish_subscribe::PortFactory<Ipc, [Contact], ContactsHeader>;

fn topic(scene: &SceneServices) -> Result<Topic> {
    scene
        .node
        .service_builder(&scene.contacts_name)
        .publish_subscribe::<[Contact]>()
        .user_header::<ContactsHeader>()
        .enable_safe_overflow(true)
        .history_size(0)
        .subscriber_max_buffer_size(1)
        .max_publishers(PUBLISHERS_MAX)
        .max_subscribers(SUBSCRIBERS_MAX)
        .max_nodes(NODES_MAX)
        .open_or_create()
        .map_err(|why| service_error(&scene.contacts_name, why))
}

/// The server's side.
#[derive(Debug)]
pub(crate) struct ContactPublisher {
    topic: Topic,
    publisher: Publisher<Ipc, [Contact], ContactsHeader>,
    contacts: Vec<Contact>,
    pace: Pace,
    failed: u64,
    cost: Latencies,
}

impl ContactPublisher {
    /// Sent at most `hz` times a second.
    pub(crate) fn open(scene: &SceneServices, hz: u32) -> Result<Self> {
        let pace = Pace::new(hz)?;
        let topic = topic(scene)?;
        let publisher = topic
            .publisher_builder()
            .initial_max_slice_len(CONTACTS_MAX)
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|why| port_error(&scene.contacts_name, why))?;
        let mut contacts = Vec::new();
        // Written once now: no page fault in the loop.
        contacts.resize(CONTACTS_MAX, Contact::default());
        Ok(Self { topic, publisher, contacts, pace, failed: 0, cost: Latencies::new()? })
    }

    /// The contacts are others than those that were sent last.
    pub(crate) fn changed(&mut self) {
        self.pace.changed();
    }

    /// Whether they are to be sent now, see [`Pace::is_due`].
    pub(crate) fn is_due(&mut self, now_ns: u64, idle: bool) -> bool {
        self.pace.is_due(&self.topic, now_ns, idle)
    }

    /// Sends them. Allocates nothing of its own.
    pub(crate) fn send(&mut self, header: ContactsHeader, engine: &mut dyn TissueEngine) {
        let start_ns = now_ns();
        let found = &mut self.contacts;
        found.clear();
        engine.read_contacts(&mut |node, contact| {
            if found.len() < CONTACTS_MAX {
                found.push(Contact::of(node, contact));
            }
        });
        let contacts = u32::try_from(found.len()).unwrap_or(u32::MAX);
        let sent = self.publisher.loan_slice_uninit(found.len()).map(|mut sample| {
            *sample.user_header_mut() = ContactsHeader { contacts, ..header };
            sample.write_from_fn(|at| found[at]).send()
        });
        match sent {
            Ok(Ok(_)) => {}
            Ok(Err(why)) => complain(&mut self.failed, "cannot send contacts", why),
            Err(why) => complain(&mut self.failed, "cannot take memory for contacts", why),
        }
        self.pace.sent();
        self.cost.record(now_ns() - start_ns);
    }

    /// Messages sent, and the time each took \[ns\].
    pub(crate) fn cost(&self) -> (u64, Summary) {
        (self.cost.count(), self.cost.summary())
    }
}

/// A reader of contacts.
#[derive(Debug)]
pub struct ContactReader {
    topic: Topic,
    subscriber: Subscriber<Ipc, [Contact], ContactsHeader>,
}

impl ContactReader {
    /// Joins the scene's readers.
    ///
    /// # Errors
    /// A service with other types or limits; too many readers.
    pub fn open(scene: &SceneServices) -> Result<Self> {
        let topic = topic(scene)?;
        let subscriber = topic.subscriber_builder().buffer_size(1).create();
        let subscriber = subscriber.map_err(|why| port_error(&scene.contacts_name, why))?;
        Ok(Self { topic, subscriber })
    }

    /// Whether a server sends contacts.
    #[must_use]
    pub fn is_served(&self) -> bool {
        // Meanwhile the connection is made, so that no message is missed.
        let _ = self.subscriber.update_connections();
        self.topic.dynamic_config().number_of_publishers() > 0
    }

    /// The newest contacts that have not been taken, if any.
    ///
    /// # Errors
    /// What shared memory says.
    pub fn take(&self) -> Result<Option<(ContactsHeader, Vec<Contact>)>> {
        let sample = self.subscriber.receive();
        let sample =
            sample.map_err(|why| Error::check(format!("cannot read contacts: {why:?}")))?;
        Ok(sample.map(|sample| (*sample.user_header(), sample.payload().to_vec())))
    }
}
