//! Snapshots by command: taken between two ticks, written next to the trace by a separate thread.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use super::Run;
use crate::engine::tissue::Refusal;
use crate::files::snapshot::{self, SessionSnapshot};
use crate::files::whole::write_whole;
use crate::session::ipc::command::CommandServer;

/// Largest number of snapshots per session, to limit the disk space.
const SNAPSHOTS_MAX: u32 = 1000;
/// Longest wait for a file at the end of the session.
const LAST_FILE: Duration = Duration::from_secs(4);

/// Path of a session's snapshots, and the start of its trace.
#[derive(Debug, Clone)]
pub struct SnapshotPlace {
    /// The session's trace.
    pub trace: PathBuf,
    /// The bytes that it starts with.
    pub begun: Vec<u8>,
}

/// A file to be written.
type File = (PathBuf, Vec<u8>);

/// The loop's side of the writing.
pub(super) struct Snapshots {
    place: SnapshotPlace,
    files: SyncSender<File>,
    /// True for each written file, once that is known.
    written: Receiver<bool>,
    taken: u32,
}

/// The writer's side.
pub(super) struct Writer {
    files: Receiver<File>,
    written: SyncSender<bool>,
}

impl Snapshots {
    /// Creates both sides.
    pub(super) fn new(place: SnapshotPlace) -> (Self, Writer) {
        // Only one file is written at a time, so that no send has to wait for a channel.
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
    /// Takes a snapshot. Returns its checksum.
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

    /// Ends the snapshots with the session: only the file in progress is completed.
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
