//! Disk space for a trace: checked before anything is removed, then allocated.

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use chaincell_kernel::trace::RECORD_BYTES;
use rustix::fs::{FallocateFlags, fallocate, statvfs};
use rustix::process::geteuid;

use crate::error::{Error, Result};
use crate::files::whole::folder_of;

/// Unit in which a file's blocks are counted, whatever the block size of its disk \[bytes\].
const BLOCK_BYTES: u64 = 512;

/// Returns the size of `records` records \[bytes\].
pub(super) fn bytes_of(records: usize) -> u64 {
    (records as u64).saturating_mul(RECORD_BYTES as u64)
}

/// Returns the disk space that a file uses, 0 if it does not exist \[bytes\].
pub fn taken(path: &Path) -> u64 {
    path.metadata().map_or(0, |file| file.blocks().saturating_mul(BLOCK_BYTES))
}

/// Refuses a trace for which the free disk space, and the `given_up` bytes of files that it replaces, are too
/// small. A missing folder is checked when it is created; a disk of unknown size fails only when it is full.
///
/// # Errors
/// Too little disk space, with the remedy.
pub fn check(option: &str, path: &Path, records: usize, given_up: u64) -> Result<()> {
    // For a link, the disk of its target counts.
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let Ok(disk) = statvfs(folder_of(&place)) else { return Ok(()) };
    // A part of the disk is reserved for root.
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

/// Allocates `bytes` zero bytes for the file.
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
