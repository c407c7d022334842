//! Shared memory: services, their names and owners, and what travels over them.

pub use chaincell_client::{names, payload, services};

use crate::error::Result;
use crate::interrupt;
use services::{Domain, SceneServices};

pub mod command;
pub(crate) mod complain;
pub mod contacts;
mod pace;
pub mod serving;
pub mod state;
pub mod tools;
pub mod viewed;

/// Opens a scene, unless the user asks to stop. From then on asking to stop also clears up what this
/// process may hang in.
///
/// # Errors
/// Why it cannot be opened; the wish to stop.
pub fn open(scene: Option<&str>, domain: &Domain) -> Result<SceneServices> {
    let scene = SceneServices::open_unless(scene, domain, interrupt::asked)?;
    let leftovers = scene.leftovers();
    interrupt::besides(move || {
        leftovers.clear();
    });
    Ok(scene)
}
