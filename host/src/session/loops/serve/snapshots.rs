//! Snapshots by command: taken between two ticks, written beside the trace by a thread of their own.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use super::Run;
use crate::engine::tissue::Refusal;
use crate::files::snapshot::{self, SessionSnapshot};
use crate::files::whole::write_whole;
use crate::session::ipc::command::CommandServer;

/// Most snapshots of a session: their files take room.
const SNAPSHOTS_MAX: u32 = 1000;
/// Longest wait for a file when the session ends.
const LAST_FILE: Duration = Duration::from_secs(4);

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
    /// Whether each was written, once that is known.
    written: Receiver<bool>,
    taken: u32,
}

/// The writer's end.
pub(super) struct Writer {
    files: Receiver<File>,
    written: SyncSender<bool>,
}

impl Snapshots {
    /// And the writer's end.
    pub(super) fn new(place: SnapshotPlace) -> (Self, Writer) {
        // One file is under way at a time, so that nothing ever waits for room in a channel.
        let (files, of_loop) = sync_channel(1);
        let (of_writer, written) = sync_channel(1);
        let writer = Writer { files: of_loop, written: of_writer };
        (Self { place, files, written, taken: 0 }, writer)
    }
}

impl Writer {
    /// Writes until the loop has ended.
    pub(super) fn write_all(&self) {
        while let Ok((path, bytes)) = self.files.recv() {
            let written = write_whole(&path, &bytes);
            match &written {
                Ok(()) => log::info!("snapshot {}", path.display()),
                Err(why) => log::error!("no snapshot: {why}"),
            }
            if self.written.send(written.is_ok()).is_err() {
                return;
            }
        }
    }
}

impl Run<'_> {
    /// Takes a snapshot; gives its number.
    pub(super) fn snapshot(&mut self) -> Result<u32, Refusal> {
        let tick = self.session.last_tick();
        let Some(snapshots) = &mut self.snapshots else { return Err(Refusal::NoTrace) };
        if snapshots.taken == SNAPSHOTS_MAX {
            return Err(Refusal::Snapshots);
        }
        if self.commands.as_ref().is_some_and(CommandServer::waits) {
            return Err(Refusal::Busy);
        }
        let saved = self.session.saved().ok_or(Refusal::Unsupported)?;
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
        snapshots.taken += 1;
        Ok(checksum)
    }

    /// Replies to a command once its snapshot is written.
    pub(super) fn told_of_file(&mut self) {
        let Some(snapshots) = &self.snapshots else { return };
        if let Ok(is_written) = snapshots.written.try_recv() {
            self.reply_of_file(is_written);
        }
    }

    /// The session ends: nothing more is written than what is under way.
    pub(super) fn end_snapshots(&mut self) {
        let Some(Snapshots { files, written, .. }) = self.snapshots.take() else { return };
        drop(files);
        if self.commands.as_ref().is_some_and(CommandServer::waits)
            && let Ok(is_written) = written.recv_timeout(LAST_FILE)
        {
            self.reply_of_file(is_written);
        }
    }

    fn reply_of_file(&mut self, is_written: bool) {
        let refusal = if is_written { None } else { Some(Refusal::NotWritten) };
        if let Some(commands) = &mut self.commands {
            commands.finish(refusal);
        }
        let refused = u64::from(!is_written);
        (self.obeyed, self.disobeyed) = (self.obeyed - refused, self.disobeyed + refused);
    }
}
