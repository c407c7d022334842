//! A trace on disk that grows with every tick of a running loop, by plain stores to memory: the
//! room is taken, mapped and made writable beforehand. What was added survives the end of the
//! process, however it ends; a failure of power it need not survive.
//!
//! The system writes the pages to the disk every half minute or so and makes them read-only for it;
//! a thread beside the loop makes the next ones writable again. Of the loop's own writes one or two
//! in half a minute meet such a page (a page fault, tens of microseconds); on a file system in
//! memory none does.
//!
//! The file is locked while it is written, so that no second run takes it. Another program that
//! cut it short all the same would end this one at the next write beyond the cut.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering, compiler_fence};
use std::thread::JoinHandle;
use std::time::Duration;

use chaincell_kernel::ToolPose;
use chaincell_kernel::trace::{CommandRecord, MAGIC, PoseRecord, RECORD_BYTES, Record, Writer};

use super::Recording;
use super::map::{Map, Pages};
use super::room::{self, no_room};
use crate::error::{Error, Result};
use crate::input;

/// Bytes ahead of the loop that are kept writable: six seconds at 1 kHz.
const AHEAD_BYTES: usize = 1 << 18;
/// Span between looks at how far the loop is.
const LOOK: Duration = Duration::from_millis(10);
/// Bytes of a record before its checksum, which is written last.
const BODY_BYTES: usize = RECORD_BYTES - 4;
/// Smallest page of memory.
const PAGE_BYTES: usize = 4096;

/// A trace file under way.
#[derive(Debug)]
pub struct TraceFile {
    path: PathBuf,
    file: File,
    // Before the map: its thread ends first.
    ahead: Ahead,
    map: Map,
    writer: Writer,
    at: usize,
}

impl TraceFile {
    /// Takes the room for `records` records behind what `begun` holds, and writes that. An earlier
    /// trace is replaced with `force`, any other file never; `option` names the file in errors.
    ///
    /// # Errors
    /// A file that stays, one that a run is recording to, a disk without room.
    pub fn create(
        option: &str,
        path: &Path,
        force: bool,
        begun: Recording,
        records: usize,
    ) -> Result<Self> {
        let bytes = room::bytes_of(records).saturating_add(begun.bytes.len() as u64);
        // Before anything is removed.
        room::check(option, path, records, room::taken(path))?;
        let mut file = open(option, path, force)?;
        let taken = room::take(&mut file, bytes).and_then(|()| {
            let mut map = Map::of(&file)?;
            // Where the kernel knows no such call, every page is touched.
            if map.pages().prepare(0, map.len()).is_err() {
                (0..map.len()).step_by(PAGE_BYTES).for_each(|at| _ = map.put(at, &[0]));
            }
            map.put(0, &begun.bytes);
            Ok(map)
        });
        let map = taken.map_err(|why| {
            // What was there before is gone; the rest of an attempt helps nobody.
            let _ = std::fs::remove_file(path);
            no_room(option, path, bytes, &why)
        })?;
        let at = begun.bytes.len();
        let ahead = Ahead::start(map.pages(), at);
        Ok(Self { path: path.to_owned(), file, ahead, map, writer: begun.writer, at })
    }

    /// Whether there is room for another record.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.map.len() - self.at >= RECORD_BYTES
    }

    /// Adds an executed tick; false where it is full. No system call, no allocation.
    pub fn add(&mut self, record: &Record) -> bool {
        self.has_room() && {
            let bytes = self.writer.record(record);
            self.append(&bytes)
        }
    }

    /// As [`Self::add`], with the poses of the tools ahead of the tick: all of them, or nothing.
    pub fn add_tools(&mut self, record: &Record, poses: &[ToolPose]) -> bool {
        if self.map.len() - self.at < (poses.len() + 1) * RECORD_BYTES {
            return false;
        }
        for (tool, &pose) in (0_u8..).zip(poses) {
            let bytes = self.writer.pose(&PoseRecord { tool, pose });
            self.append(&bytes);
        }
        self.add(record)
    }

    /// As [`Self::add`], for a command that took effect.
    pub fn add_command(&mut self, record: &CommandRecord) -> bool {
        self.has_room() && {
            let bytes = self.writer.command(record);
            self.append(&bytes)
        }
    }

    fn append(&mut self, bytes: &[u8; RECORD_BYTES]) -> bool {
        let (body, checksum) = bytes.split_at(BODY_BYTES);
        let whole = self.map.put(self.at, body) && {
            // Killed between the two, the process leaves a record that is known as unfinished.
            compiler_fence(Ordering::SeqCst);
            self.map.put(self.at + BODY_BYTES, checksum)
        };
        // An answer is sent after this, to memory that others see.
        compiler_fence(Ordering::SeqCst);
        self.at += if whole { RECORD_BYTES } else { 0 };
        self.ahead.cursor.store(self.at, Ordering::Relaxed);
        whole
    }

    /// Cuts the file to what was recorded.
    ///
    /// # Errors
    /// What the system says, with the path; the trace can be read all the same.
    pub fn finish(self) -> Result<()> {
        let Self { path, file, ahead, map, at, .. } = self;
        drop(ahead);
        drop(map);
        file.set_len(at as u64).map_err(|why| Error::file("cut to its length", &path, why))
    }
}

fn refused<T>(option: &str, path: &Path, why: &str) -> Result<T> {
    Err(Error::input(format!("{option} {}: {why}", path.display())))
}

/// Refuses what is there and no file.
pub(super) fn check_kind(option: &str, path: &Path) -> Result<()> {
    if path.exists() && !path.is_file() {
        return refused(option, path, "it is there and no file: name another one");
    }
    Ok(())
}

/// Refuses a file that holds something: with `force` an earlier trace may go, anything else stays.
pub(super) fn check_content(option: &str, path: &Path, file: &File, force: bool) -> Result<()> {
    let mut front = Vec::new();
    let read = file.take(MAGIC.len() as u64).read_to_end(&mut front);
    read.map_err(|why| Error::file("read", path, why))?;
    if !front.is_empty() && front != MAGIC {
        return refused(option, path, "the file is there and is no trace: name another one");
    }
    if !front.is_empty() && !force {
        let why = "the file is there: name another one, or pass `force` to overwrite it";
        return refused(option, path, why);
    }
    Ok(())
}

/// Opens the file for this process alone, emptied.
fn open(option: &str, path: &Path, force: bool) -> Result<File> {
    let failed = |why: std::io::Error| Error::file("write", path, why);
    check_kind(option, path)?;
    input::keep(path)?;
    let mut options = OpenOptions::new();
    let mut file =
        options.read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return refused(option, path, TAKEN),
        Err(TryLockError::Error(why)) => return Err(failed(why)),
    }
    check_content(option, path, &file, force)?;
    file.set_len(0).and_then(|()| file.rewind()).map_err(failed)?;
    Ok(file)
}

const TAKEN: &str = "another run is recording to it: name another one, or end that run";

/// Refuses a trace that a run is recording to; one that is not there is none.
///
/// # Errors
/// That it is taken.
pub fn check_idle(option: &str, path: &Path) -> Result<()> {
    // What cannot be opened is told where it is written.
    let is_taken = |file: File| matches!(file.try_lock(), Err(TryLockError::WouldBlock));
    let taken = path.is_file() && File::open(path).is_ok_and(is_taken);
    if taken {
        return refused(option, path, TAKEN);
    }
    Ok(())
}

/// A thread that keeps the pages ahead of the loop writable.
#[derive(Debug)]
struct Ahead {
    cursor: Arc<AtomicUsize>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Ahead {
    fn start(pages: Pages, at: usize) -> Self {
        let (cursor, ends) = (Arc::new(AtomicUsize::new(at)), Arc::new(AtomicBool::new(false)));
        let (of_loop, ended) = (Arc::clone(&cursor), Arc::clone(&ends));
        let work = move || {
            while !ended.load(Ordering::Relaxed) {
                if pages.prepare(of_loop.load(Ordering::Relaxed), AHEAD_BYTES).is_err() {
                    return;
                }
                std::thread::park_timeout(LOOK);
            }
        };
        // Without the thread the loop has the page faults itself.
        let thread = std::thread::Builder::new().name("trace".into()).spawn(work).ok();
        Self { cursor, ends, thread }
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It never panics.
            let _ = thread.join();
        }
    }
}
