//! Helpers of the end-to-end tests: the built command, its runs with an end, and its files.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failing helper fails its test"
)]

pub mod allocations;
pub mod bodies;
pub mod files;
pub mod forge;
pub mod fuzz;
pub mod graph;
pub mod lattice;
pub mod outsider;
pub mod page;
pub mod place;
pub mod process;
pub mod remark;

use std::path::PathBuf;

pub use process::{Ended, Running, chaincell, run};

/// Folder of the published reference data, or `None` with a line that says what is skipped.
#[must_use]
pub fn reference(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CHAINCELL_REFERENCE").map(PathBuf::from);
    if folder.is_none() {
        println!("SKIPPED {test}: CHAINCELL_REFERENCE is not set");
    }
    folder
}

/// A scene name that no other test and no other run has.
#[must_use]
pub fn scene(test: &str) -> String {
    chaincell_host::session::ipc::names::unique_scene(test)
}

/// Real-time loops of several tests would take each other's cores: each waits for its turn.
pub fn turn() -> std::sync::MutexGuard<'static, ()> {
    static TURN: std::sync::Mutex<()> = std::sync::Mutex::new(());
    TURN.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

// The Rust of the pages, compiled as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../host/client/README.md")]
mod client_page {}
#[cfg(doctest)]
#[doc = include_str!("../../kernel/README.md")]
mod kernel_page {}
