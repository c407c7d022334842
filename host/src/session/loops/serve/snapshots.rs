//! Snapshots by command: taken between two ticks, written beside the trace by a thread of their own.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use chaincell_kernel::TOOLS_MAX;

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

/// What a session that goes on from a snapshot knows of the one before.
#[derive(Debug, Clone, Copy)]
pub struct Resumed {
    /// Last tick before the snapshot, 0 for none.
    pub tick: u64,
    /// Id of the publisher that was in charge, 0 for none.
    pub publisher: u128,
    /// Which tools it was seen to release.
    pub released: [bool; TOOLS_MAX],
    /// Whether it was paused.
    pub is_paused: bool,
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
        let saved = self.engine.saved().ok_or(Refusal::Unsupported)?;
        let tick = self.last_tick();
        // Nobody has taken charge since a snapshot: what that one said still holds.
        let (publisher, released) = match (self.in_charge, self.resumed) {
            (Some(known), _) => (known.id.value(), self.has_released),
            (None, Some(resumed)) => (resumed.publisher, resumed.released),
            (None, None) => (0, self.has_released),
        };
        let snapshot = SessionSnapshot {
            tick,
            publisher,
            released,
            is_paused: self.paused,
            begun: snapshots.place.begun.clone(),
            saved,
        };
        let (bytes, checksum) = snapshot.to_bytes();
        let path = snapshot::place(&snapshots.place.trace, tick);
        snapshots.files.try_send((path, bytes)).map_err(|_| Refusal::Busy)?;
        Ok(checksum)
    }

    /// The last tick, which may be one before the snapshot that the session goes on from; 0 for none.
    pub(super) fn last_tick(&self) -> u64 {
        let before = self.server.resumed.map_or(0, |resumed| resumed.tick);
        self.shared.voice().answer.map_or(before, |last| last.force.tick)
    }

    /// A publisher takes charge: the one of the session before needs to release nothing again.
    pub(super) fn resume(&mut self, publisher: u128) {
        let Some(resumed) = self.resumed.take() else { return };
        if resumed.publisher == publisher {
            self.has_released = resumed.released;
        }
    }
}
