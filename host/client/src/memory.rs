//! Allocates shared memory before it is written: the system kills a program that writes when none is
//! left. Also raises the limit of open files: each piece of shared memory is one.

use std::fs::{OpenOptions, read_dir};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};

use rustix::fs::{FallocateFlags, OFlags, fallocate, statvfs};
use rustix::io::Errno;
use rustix::process::{Resource, Rlimit, geteuid, getrlimit, setrlimit};

use crate::error::{Error, Kind, Result};

/// Linux's folder of shared memory.
pub(crate) const FOLDER: &str = "/dev/shm";
/// Upper bound of the memory for joining a scene \[bytes\].
pub(crate) const JOIN_BYTES: u64 = 256 << 10;
/// Upper bound of the memory of a server, without states, and of its clients \[bytes\].
pub(crate) const SERVER_BYTES: u64 = 6 << 20;
/// Upper bound of the memory of a controller and some viewers \[bytes\].
pub(crate) const CLIENTS_BYTES: u64 = 4 << 20;
/// Files that a program opens to join a scene.
pub(crate) const JOIN_FILES: u64 = 32;
/// Files that a server opens for itself and its clients: two senders, eight readers of everything, eight
/// programs that send commands.
pub(crate) const SERVER_FILES: u64 = 96;

/// Checks that `bytes` of shared memory are left for `what`.
///
/// # Errors
/// The memory that is left, and the remedy.
pub(crate) fn check(what: &str, bytes: u64) -> Result<()> {
    // If the free memory is unknown, iceoryx2 reports what it lacks.
    let Ok(found) = statvfs(FOLDER) else { return Ok(()) };
    let free_bytes = found.f_bavail.saturating_mul(found.f_frsize);
    if free_bytes < bytes { Err(full(free_bytes, what, bytes)) } else { Ok(()) }
}

/// Ensures that `more` files can be opened for `what`: raises this process's limit if needed and
/// permitted.
///
/// # Errors
/// The limit, and the number needed.
pub(crate) fn take_files(what: &str, more: u64) -> Result<()> {
    let Ok(open) = read_dir("/proc/self/fd") else { return Ok(()) };
    let needed = open.count() as u64 + more;
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let Some(limit) = current.filter(|&limit| limit < needed) else { return Ok(()) };
    let raised = Rlimit { current: Some(needed), maximum };
    if maximum.is_none_or(|most| needed <= most) && setrlimit(Resource::Nofile, raised).is_ok() {
        return Ok(());
    }
    Err(Error::new(
        Kind::Memory,
        format!(
            "a process may open {limit} files here, and {what} needs {needed}, since each piece of shared \
             memory is one: raise the limit with ulimit -n {}",
            needed.next_power_of_two()
        ),
    ))
}

/// Allocates every page of this user's files whose names begin with `prefix`.
///
/// # Errors
/// Too little memory for them.
pub(crate) fn take(prefix: &str) -> Result<()> {
    let Ok(folder) = read_dir(FOLDER) else { return Ok(()) };
    for entry in folder.flatten() {
        if !entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) {
            continue;
        }
        // Files of other users and files that have just been removed are skipped.
        let Ok(details) = entry.metadata() else { continue };
        let is_ours = details.is_file() && details.uid() == geteuid().as_raw();
        if !is_ours || details.len() == 0 {
            continue;
        }
        let mut options = OpenOptions::new();
        options.write(true).custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32);
        let Ok(file) = options.open(entry.path()) else { continue };
        if fallocate(&file, FallocateFlags::KEEP_SIZE, 0, details.len()) == Err(Errno::NOSPC) {
            return Err(full(0, "a scene", SERVER_BYTES));
        }
    }
    Ok(())
}

fn full(free_bytes: u64, what: &str, bytes: u64) -> Error {
    Error::new(
        Kind::Memory,
        format!(
            "shared memory is full: {FOLDER} has {} kB left, {what} takes up to {} kB and its states \
         more; end programs that use it, remove what they left there, or give it more room",
            free_bytes / 1024,
            bytes / 1024
        ),
    )
}
