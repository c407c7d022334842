//! A trace on disk to which a running loop adds every tick by plain stores to memory: the file is allocated,
//! mapped and made writable beforehand. Added records survive any end of the process, but not necessarily
//! a power failure.
//!
//! About every half minute the system writes the pages to the disk, and makes them read-only for it; a
//! separate thread makes the next ones writable again. One or two of the loop's writes per half minute
//! still hit such a page (a page fault, tens of microseconds); none does on a file system in memory.
//!
//! The file is locked while it is written, so that no second run uses it. If another program truncates it
//! anyway, the next write beyond its end kills this process.

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

/// Bytes after the loop's position that are kept writable: five seconds at 1 kHz with a record per tick.
const AHEAD_BYTES: usize = 1 << 18;
/// Time between checks of the loop's position.
const LOOK: Duration = Duration::from_millis(10);
/// Size of a record without its checksum, which is written last \[bytes\].
const BODY_BYTES: usize = RECORD_BYTES - 4;
/// Size of the smallest memory page \[bytes\].
const PAGE_BYTES: usize = 4096;

/// A trace file to which a run is recording.
#[derive(Debug)]
pub struct TraceFile {
    path: PathBuf,
    file: File,
    // Declared before the map, so that its thread ends first.
    ahead: Ahead,
    map: Map,
    writer: Writer,
    at: usize,
}

impl TraceFile {
    /// Creates a file that starts with the bytes of `begun`, with space for `records` further records.
    /// Replaces an earlier trace if `force` is set, and never any other file; `option` names the file in
    /// errors.
    ///
    /// # Errors
    /// A file that must not be replaced, one to which a run is recording, a full disk.
    pub fn create(
        option: &str,
        path: &Path,
        force: bool,
        begun: Recording,
        records: usize,
    ) -> Result<Self> {
        let bytes = room::bytes_of(records).saturating_add(begun.bytes.len() as u64);
        // Check the disk before anything is removed.
        room::check(option, path, records, room::taken(path))?;
        let mut file = open(option, path, force)?;
        let taken = room::take(&mut file, bytes).and_then(|()| {
            let mut map = Map::of(&file)?;
            // If the system does not support this call, touch every page.
            if map.pages().prepare(0, map.len()).is_err() {
                (0..map.len()).step_by(PAGE_BYTES).for_each(|at| _ = map.put(at, &[0]));
            }
            map.put(0, &begun.bytes);
            Ok(map)
        });
        let map = taken.map_err(|why| {
            // The earlier content is gone; remove the incomplete file too.
            let _ = std::fs::remove_file(path);
            no_room(option, path, bytes, &why)
        })?;
        let at = begun.bytes.len();
        let ahead = Ahead::start(map.pages(), at);
        Ok(Self { path: path.to_owned(), file, ahead, map, writer: begun.writer, at })
    }

    /// Returns true if another record fits.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.map.len() - self.at >= RECORD_BYTES
    }

    /// Adds an executed tick. Returns false if the file is full. Makes no system call and no allocation.
    pub fn add(&mut self, record: &Record) -> bool {
        self.has_room() && {
            let bytes = self.writer.record(record);
            self.append(&bytes)
        }
    }

    /// Like [`Self::add`], with the poses of the tools before the tick. Adds all of it or nothing.
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

    /// Like [`Self::add`], for an executed command.
    pub fn add_command(&mut self, record: &CommandRecord) -> bool {
        self.has_room() && {
            let bytes = self.writer.command(record);
            self.append(&bytes)
        }
    }

    fn append(&mut self, bytes: &[u8; RECORD_BYTES]) -> bool {
        let (body, checksum) = bytes.split_at(BODY_BYTES);
        let whole = self.map.put(self.at, body) && {
            // If the process is killed between the two, the checksum marks the record as incomplete.
            compiler_fence(Ordering::SeqCst);
            self.map.put(self.at + BODY_BYTES, checksum)
        };
        // The answer, which other processes see, must be sent after this.
        compiler_fence(Ordering::SeqCst);
        self.at += if whole { RECORD_BYTES } else { 0 };
        self.ahead.cursor.store(self.at, Ordering::Relaxed);
        whole
    }

    /// Cuts the file to the recorded length.
    ///
    /// # Errors
    /// The system's error, with the path; the trace is readable nevertheless.
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

/// Refuses a path that exists and is not a file.
pub(super) fn check_kind(option: &str, path: &Path) -> Result<()> {
    if path.exists() && !path.is_file() {
        return refused(option, path, "it is there and no file: name another one");
    }
    Ok(())
}

/// Refuses a file with content, except an earlier trace if `force` is set.
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

/// Opens the file, locks it for this process, and empties it.
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

/// Refuses a trace to which a run is recording; a missing file is accepted.
///
/// # Errors
/// A trace in use.
pub fn check_idle(option: &str, path: &Path) -> Result<()> {
    // A file that cannot be opened is reported when it is written.
    let is_taken = |file: File| matches!(file.try_lock(), Err(TryLockError::WouldBlock));
    let taken = path.is_file() && File::open(path).is_ok_and(is_taken);
    if taken {
        return refused(option, path, TAKEN);
    }
    Ok(())
}

/// A thread that keeps the pages after the loop's position writable.
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
        // Without the thread, the page faults occur in the loop.
        let thread = std::thread::Builder::new().name("trace".into()).spawn(work).ok();
        Self { cursor, ends, thread }
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // The thread never panics.
            let _ = thread.join();
        }
    }
}
