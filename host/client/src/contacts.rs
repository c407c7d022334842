//! Contacts for viewers: positions and forces on each tool, at the rate of states.
//!
//! A message is a slice of [`Contact`], one for each triangle in contact with a part of a tool, as the
//! rows of contacts.csv; it is empty if nothing is in contact. Readers keep only the newest. Servers
//! that have tools on a contact surface send it.

use iceoryx2::prelude::*;

use crate::services::SceneServices;
use crate::viewed::{Reader, Viewed};

/// One triangle in contact with one part of a tool: 52 bytes.
///
/// ```
/// use chaincell_client::contacts::Contact;
///
/// let contact = Contact { normal_n: [0.0, 0.0, 0.4], area_m2: 2.0e-5, ..Contact::default() };
/// let pressure_pa = contact.normal_n[2] / contact.area_m2;
/// assert!((pressure_pa - 20_000.0).abs() < 1.0); // [Pa]
/// assert_eq!(size_of::<Contact>(), 52);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.Contact.v1")]
#[repr(C)]
pub struct Contact {
    /// The tool, from 0.
    pub tool: u32,
    /// The part of the tool, from 0.
    pub part: u32,
    /// Input id of the triangle's corner that takes the largest share of the force.
    pub node: u32,
    /// The point at which the force acts, in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Normal force on the tool \[N\].
    pub normal_n: [f32; 3],
    /// Friction, or the pull of a grip, on the tool \[N\].
    pub tangential_n: [f32; 3],
    /// Area of the triangle at rest, as far as its points are in contact \[m2\].
    pub area_m2: f32,
}

/// Tick and flags that the contacts belong to: 24 bytes, the user header of a slice of [`Contact`].
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

// The offsets follow from the order of the fields, which the tables of the reference are compared with.
const _: () = {
    assert!(size_of::<Contact>() == 52);
    assert!(size_of::<ContactsHeader>() == 24);
};

impl Viewed for Contact {
    type Header = ContactsHeader;
    const WHAT: &'static str = "contacts";
    const NONE: &'static str = "no contacts";

    fn name(scene: &SceneServices) -> &ServiceName {
        &scene.contacts_name
    }
}

/// A reader of contacts.
///
/// ```no_run
/// # fn read() -> chaincell_client::Result<()> {
/// use chaincell_client::contacts::ContactReader;
/// use chaincell_client::services::{Domain, SceneServices};
///
/// let scene = SceneServices::open(Some("left"), &Domain::default())?;
/// let reader = ContactReader::open(&scene)?;
/// if let Some(view) = reader.borrow()? {
///     for contact in view.rows() {
///         println!("tool {} at node {}: {:?} N", contact.tool, contact.node, contact.normal_n);
///     }
/// }
/// # Ok(())
/// # }
/// ```
pub type ContactReader = Reader<Contact>;
