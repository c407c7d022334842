//! A program of somebody else that reads contacts.

use iceoryx2::prelude::*;

use super::{Header, Reader};

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
pub type Watcher = Reader<Touch, Touched>;

impl Header for Touched {
    const TOPIC: &'static str = "contacts";

    fn ticks_answered(&self) -> u64 {
        self.ticks_answered
    }
}
