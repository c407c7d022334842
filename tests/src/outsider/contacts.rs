//! A program of somebody else that reads contacts.

use iceoryx2::node::Node;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use super::{eventually, node, service};

/// A row of contacts: 52 bytes, as declared by the contract.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.Contact.v1")]
#[repr(C)]
pub struct Touch {
    /// Which tool.
    pub tool: u32,
    /// Which of its parts.
    pub part: u32,
    /// Input id of the corner with the largest share.
    pub node: u32,
    /// Where it acts \[m\].
    pub position_m: [f32; 3],
    /// Pressure on the tool \[N\].
    pub normal_n: [f32; 3],
    /// Friction on the tool \[N\].
    pub tangential_n: [f32; 3],
    /// Area \[m2\].
    pub area_m2: f32,
}

/// What they belong to: 24 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("chaincell.Contacts.v1")]
#[repr(C)]
pub struct Touched {
    /// Number of the last answered tick.
    pub tick: u64,
    /// Ticks answered.
    pub ticks_answered: u64,
    /// Rows.
    pub contacts: u32,
    /// Flags of the last answer.
    pub flags: u32,
}

const _: () = assert!(size_of::<Touch>() == 52 && size_of::<Touched>() == 24);

/// A reader of contacts of somebody else.
#[derive(Debug)]
pub struct Watcher {
    subscriber: Subscriber<ipc::Service, [Touch], Touched>,
    _node: Node<ipc::Service>,
}

impl Watcher {
    /// Joins a scene's readers.
    #[track_caller]
    #[must_use]
    pub fn join(scene: &str) -> Self {
        let node = node();
        let name = service(scene, "contacts");
        let contacts = eventually(|| {
            let service = node.service_builder(&name).publish_subscribe::<[Touch]>();
            service.user_header::<Touched>().open().ok()
        });
        let subscriber = contacts.subscriber_builder().create().unwrap();
        Self { subscriber, _node: node }
    }

    /// Contacts that have arrived.
    #[must_use]
    pub fn try_receive(&self) -> Option<(Touched, Vec<Touch>)> {
        let sample = self.subscriber.receive().unwrap()?;
        Some((*sample.user_header(), sample.payload().to_vec()))
    }

    /// The first contacts of at least so many answered ticks.
    #[track_caller]
    #[must_use]
    pub fn after(&self, ticks_answered: u64) -> (Touched, Vec<Touch>) {
        eventually(|| self.try_receive().filter(|found| found.0.ticks_answered >= ticks_answered))
    }
}
