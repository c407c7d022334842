//! Room on a disk for a trace: looked at before anything is removed, then taken.

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use chaincell_kernel::trace::RECORD_BYTES;
use rustix::fs::{FallocateFlags, fallocate, statvfs};
use rustix::process::geteuid;

use crate::error::{Error, Result};
use crate::files::whole::folder_of;

/// Unit of a file's blocks, whatever those of its disk are \[bytes\].
const BLOCK_BYTES: u64 = 512;

/// Bytes of so many records.
pub(super) fn bytes_of(records: usize) -> u64 {
    (records as u64).saturating_mul(RECORD_BYTES as u64)
}

/// What a file takes of its disk, 0 where there is none \[bytes\].
pub fn taken(path: &Path) -> u64 {
    path.metadata().map_or(0, |file| file.blocks().saturating_mul(BLOCK_BYTES))
}

/// Refuses a trace that the disk has no room for, `given_up` bytes of it being given up for the
/// trace. A folder that is not there yet has nothing to lose and is told when it is made; a disk that
/// does not tell its size is told when it is full.
///
/// # Errors
/// No room, with what to do.
pub fn check(option: &str, path: &Path, records: usize, given_up: u64) -> Result<()> {
    // Where a link leads, there the room is.
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let Ok(disk) = statvfs(folder_of(&place)) else { return Ok(()) };
    // A part of the disk is kept for root.
    let blocks = if geteuid().is_root() { disk.f_bfree } else { disk.f_bavail };
    let (free, bytes) = (blocks.saturating_mul(disk.f_frsize), bytes_of(records));
    if disk.f_blocks > 0 && bytes > free.saturating_add(given_up) {
        return Err(no_room(option, path, bytes, &format!("{:.1} MB free", free as f64 * 1e-6)));
    }
    Ok(())
}

pub(super) fn no_room(option: &str, path: &Path, bytes: u64, why: &dyn std::fmt::Display) -> Error {
    Error::input(format!(
        "{option} {}: no room for the trace, {:.1} MB ({why}): free some, name a place elsewhere, \
         or record fewer ticks (serve `record_ticks`)",
        path.display(),
        bytes as f64 * 1e-6
    ))
}

/// Takes so many bytes of the disk, all zero.
pub(super) fn take(file: &mut File, bytes: u64) -> std::io::Result<()> {
    match rustix::io::retry_on_intr(|| fallocate(&*file, FallocateFlags::empty(), 0, bytes)) {
        Ok(()) => Ok(()),
        Err(rustix::io::Errno::OPNOTSUPP) => {
            let zeros = [0; 1 << 16];
            let mut left = bytes;
            while left > 0 {
                let part = left.min(zeros.len() as u64);
                file.write_all(zeros.get(..part as usize).unwrap_or(&zeros))?;
                left -= part;
            }
            Ok(())
        }
        Err(why) => Err(why.into()),
    }
}
