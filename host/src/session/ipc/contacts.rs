//! Contacts for viewers: position and forces of each contact of a tool, sent between ticks at the rate of
//! states.

use chaincell_kernel::ContactForce;

pub use chaincell_client::contacts::{Contact, ContactReader, ContactsHeader};

use crate::engine::tissue::TissueEngine;
use crate::engine::tools::CONTACTS_MAX;
use crate::error::Result;
use crate::session::ipc::services::SceneServices;
use crate::session::ipc::viewed::Feed;
use crate::session::timing::clock::now_ns;

/// Returns the message of a contact of the tissue; `node` is the input id of its corner.
fn message(node: u32, contact: &ContactForce) -> Contact {
    Contact {
        tool: contact.tool.into(),
        part: contact.part.into(),
        node,
        position_m: contact.position_m,
        normal_n: contact.normal_n,
        tangential_n: contact.tangential_n,
        area_m2: contact.area_m2,
    }
}

/// The server's side.
#[derive(Debug)]
pub(crate) struct ContactPublisher {
    pub feed: Feed<Contact>,
    contacts: Vec<Contact>,
}

impl ContactPublisher {
    /// Opens a publisher that sends at most `hz` times per second.
    pub(crate) fn open(scene: &SceneServices, hz: u32) -> Result<Self> {
        let feed = Feed::open(scene, CONTACTS_MAX, hz)?;
        let mut contacts = Vec::new();
        // Write every element now, to keep page faults out of the loop.
        contacts.resize(CONTACTS_MAX, Contact::default());
        Ok(Self { feed, contacts })
    }

    /// Sends the contacts. Does not allocate itself.
    pub(crate) fn send(&mut self, header: ContactsHeader, engine: &mut dyn TissueEngine) {
        let start_ns = now_ns();
        let found = &mut self.contacts;
        found.clear();
        engine.read_contacts(&mut |node, contact| {
            if found.len() < CONTACTS_MAX {
                found.push(message(node, contact));
            }
        });
        let contacts = u32::try_from(found.len()).unwrap_or(u32::MAX);
        let header = ContactsHeader { contacts, ..header };
        self.feed.send(start_ns, header, (found.len(), |at| found[at]));
    }
}
