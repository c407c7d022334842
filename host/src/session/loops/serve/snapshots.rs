//! Snapshots by command: taken between two ticks, written beside the trace by a thread of their own.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use super::Run;
use crate::engine::tissue::Refusal;
use crate::files::snapshot::{self, SessionSnapshot};
use crate::files::whole::write_whole;

/// Where snapshots of a session are written, and what they belong to.
#[derive(Debug, Clone)]
pub struct SnapshotPlace {
    /// The session's trace.
    pub trace: PathBuf,
    /// What it begins with.
    pub begun: Vec<u8>,
}

/// A file to be written.
type File = (PathBuf, Vec<u8>);

/// The loop's end of the writing.
pub(super) struct Snapshots {
    place: SnapshotPlace,
    files: SyncSender<File>,
}

impl Snapshots {
    /// And the writer's end.
    pub(super) fn new(place: SnapshotPlace) -> (Self, Receiver<File>) {
        let (files, written) = sync_channel(1);
        (Self { place, files }, written)
    }
}

/// Writes until the loop has ended.
pub(super) fn write_all(files: &Receiver<File>) {
    while let Ok((path, bytes)) = files.recv() {
        match write_whole(&path, &bytes) {
            Ok(()) => log::info!("snapshot {}", path.display()),
            Err(why) => log::error!("no snapshot: {why}"),
        }
    }
}

impl Run<'_> {
    /// Takes a snapshot; gives its number.
    pub(super) fn snapshot(&mut self) -> Result<u32, Refusal> {
        let Some(snapshots) = &self.snapshots else { return Err(Refusal::NoTrace) };
        let saved = self.session.saved().ok_or(Refusal::Unsupported)?;
        let tick = self.session.last_tick();
        let (publisher, released) = self.session.charge().saved();
        let snapshot = SessionSnapshot {
            tick,
            publisher,
            released,
            is_paused: self.session.is_paused(),
            begun: snapshots.place.begun.clone(),
            saved,
        };
        let (bytes, checksum) = snapshot.to_bytes();
        let path = snapshot::place(&snapshots.place.trace, tick);
        snapshots.files.try_send((path, bytes)).map_err(|_| Refusal::Busy)?;
        Ok(checksum)
    }
}
