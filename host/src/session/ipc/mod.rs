//! Shared memory: services, their names and owners, and their messages.

pub use chaincell_client::{names, payload, services};

use crate::error::Result;
use crate::interrupt;
use services::{Domain, SceneServices};

pub mod command;
pub(crate) mod complain;
pub mod contacts;
mod pace;
pub mod serving;
pub mod shown;
pub mod state;
pub mod stress;
pub mod surface;
pub mod tools;
pub mod viewed;
pub mod watching;

/// Opens a scene, unless the user asks to stop. From then on a request to stop also removes leftovers of
/// killed programs, on which this process might hang.
///
/// # Errors
/// The reason why it cannot be opened; the request to stop.
pub fn open(scene: Option<&str>, domain: &Domain) -> Result<SceneServices> {
    let scene = SceneServices::open_unless(scene, domain, interrupt::asked)?;
    let leftovers = scene.leftovers();
    interrupt::besides(move || {
        leftovers.clear();
    });
    Ok(scene)
}
