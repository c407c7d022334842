//! Room in shared memory, taken before it is written: the system kills a program that writes where
//! none is left.

use std::fs::{OpenOptions, read_dir};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};

use rustix::fs::{FallocateFlags, OFlags, fallocate, statvfs};
use rustix::io::Errno;
use rustix::process::geteuid;

use crate::error::{Error, Kind, Result};

/// Where Linux keeps shared memory.
const FOLDER: &str = "/dev/shm";
/// What a server and a controller of either version take at most before the states \[bytes\].
const ROOM_BYTES: u64 = 8 << 20;

/// Refuses to begin where there is too little room for a scene.
///
/// # Errors
/// The room that there is, and the remedy.
pub(crate) fn check() -> Result<()> {
    // Where that cannot be told, iceoryx2 says what it lacks.
    let Ok(found) = statvfs(FOLDER) else { return Ok(()) };
    let free_bytes = found.f_bavail.saturating_mul(found.f_frsize);
    if free_bytes < ROOM_BYTES { Err(full(free_bytes)) } else { Ok(()) }
}

/// Takes every page of the files whose names begin with `prefix` and that are this user's.
///
/// # Errors
/// Too little room for them.
pub(crate) fn take(prefix: &str) -> Result<()> {
    let Ok(folder) = read_dir(FOLDER) else { return Ok(()) };
    for entry in folder.flatten() {
        if !entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) {
            continue;
        }
        // What other users put there, and what has just gone, is not ours to fill or to wait for.
        let Ok(details) = entry.metadata() else { continue };
        let is_ours = details.is_file() && details.uid() == geteuid().as_raw();
        if !is_ours || details.len() == 0 {
            continue;
        }
        let mut options = OpenOptions::new();
        options.write(true).custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32);
        let Ok(file) = options.open(entry.path()) else { continue };
        if fallocate(&file, FallocateFlags::KEEP_SIZE, 0, details.len()) == Err(Errno::NOSPC) {
            return Err(full(0));
        }
    }
    Ok(())
}

fn full(free_bytes: u64) -> Error {
    Error::new(
        Kind::Memory,
        format!(
            "shared memory is full: {FOLDER} has {} kB left, a scene takes up to {} kB and its states \
         more; end programs that use it, remove what they left there, or give it more room",
            free_bytes / 1024,
            ROOM_BYTES / 1024
        ),
    )
}
