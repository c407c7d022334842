//! Files that a command reads, so that it removes and replaces none of them, whatever name it is given:
//! a link, another way to it, a second name on the disk.
//!
//! Kept for a process of the command line, whose life is one command. A program that uses this library
//! may read a file and write it again.

use std::collections::BTreeMap;
use std::fs::{self, File, Metadata};
use std::io;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::error::{Error, Result};

/// The name that each was given, by its place on the disk.
type Inputs = Mutex<BTreeMap<(u64, u64), PathBuf>>;

static INPUTS: OnceLock<Inputs> = OnceLock::new();

/// From here on what [`open`] opens stays.
pub fn begin() {
    let _ = INPUTS.get_or_init(Inputs::default);
}

/// Opens a file to read it, or what a shell pipes into `/dev/stdin` or `<(COMMAND)`.
///
/// # Errors
/// What the system says; a folder, a device or a named pipe, which may have no end or no writer.
pub fn open(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    // Only a named pipe has a place among the files; the others are open already, and end with their writer.
    let is_piped = kind.is_fifo() && fs::canonicalize(path).is_err();
    if !kind.is_file() && !is_piped {
        let kind = match kind {
            kind if kind.is_dir() => "a folder",
            kind if kind.is_fifo() => "a named pipe",
            kind if kind.is_socket() => "a socket",
            _ => "a device",
        };
        return Err(io::Error::other(format!("it is {kind}: give a file")));
    }
    let file = File::open(path)?;
    if let Some(inputs) = INPUTS.get() {
        let found = [file.metadata(), fs::symlink_metadata(path)];
        let mut inputs = inputs.lock().unwrap_or_else(PoisonError::into_inner);
        for details in found.into_iter().flatten() {
            inputs.entry(place(&details)).or_insert_with(|| path.to_owned());
        }
    }
    Ok(file)
}

/// Refuses to write at a place where an input stands.
///
/// # Errors
/// That it is one.
pub fn keep(output: &Path) -> Result<()> {
    keep_of(output, fs::metadata(output))
}

/// Refuses to remove an input; a link that leads to one may go.
///
/// # Errors
/// That it is one.
pub fn keep_there(output: &Path) -> Result<()> {
    keep_of(output, fs::symlink_metadata(output))
}

fn keep_of(output: &Path, details: io::Result<Metadata>) -> Result<()> {
    let Some((inputs, details)) = INPUTS.get().zip(details.ok()) else { return Ok(()) };
    let inputs = inputs.lock().unwrap_or_else(PoisonError::into_inner);
    match inputs.get(&place(&details)) {
        Some(input) => {
            let why = format!("it is the input {}; name another place", input.display());
            Err(Error::file("replace", output, why))
        }
        None => Ok(()),
    }
}

fn place(details: &Metadata) -> (u64, u64) {
    (details.dev(), details.ino())
}
