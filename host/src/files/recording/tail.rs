//! Reads a trace that another program may still be writing.

use std::fs::{File, TryLockError};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use chaincell_kernel::trace::{Decoder, Entry, MAGIC, RECORD_BYTES, Reader, TraceError};

use super::Mark;
use crate::checksum::CRC_32;
use crate::error::{Error, Result};
use crate::input;

/// Most bytes of a header with the parts of all tools: 65,535 contact cells, or 8 tools of 8 parts.
const BEGUN_BYTES_MAX: usize = 1 << 19;
/// Most records that are read at once.
const RECORDS_MAX: usize = 4096;

/// A trace that is read while it grows. The writer is not involved: the file is read, and locked by nobody for longer
/// than a look.
#[derive(Debug)]
pub struct Tail {
    path: PathBuf,
    file: File,
    header_bytes: usize,
    begun: Vec<u8>,
    decoder: Decoder,
}

impl Tail {
    /// Opens a trace; its header and the parts of its tools have to be there.
    ///
    /// # Errors
    /// A file that is not there, or is no trace, with its path.
    pub fn open(path: &Path) -> Result<Self> {
        let file = input::open(path).map_err(|why| Error::file("read trace", path, why))?;
        let front = read_at(&file, 0, BEGUN_BYTES_MAX);
        let front = front.map_err(|why| Error::file("read trace", path, why))?;
        if !front.starts_with(&MAGIC) {
            return Err(Error::file("read trace", path, TraceError::Magic));
        }
        let trace = Reader::open(&front).map_err(|why| Error::file("read trace", path, why))?;
        // The parts of the tools are records that belong to the beginning.
        let mut parts = 0;
        let _ = trace.entries(|_, entry| match entry {
            Entry::Part(_) => {
                parts += 1;
                Ok(())
            }
            _ => Err(()),
        });
        let header_bytes = trace.header().bytes(trace.contacts().len());
        let decoder = trace.decoder();
        let begun = front[..header_bytes + 2 * parts * RECORD_BYTES].to_vec();
        Ok(Self { path: path.to_owned(), file, header_bytes, begun, decoder })
    }

    /// Path of the trace.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The bytes that the trace begins with: its header, and the parts of its tools.
    #[must_use]
    pub fn begun(&self) -> &[u8] {
        &self.begun
    }

    /// Index of the first record after them.
    #[must_use]
    pub fn first_record(&self) -> u32 {
        ((self.begun.len() - self.header_bytes) / RECORD_BYTES) as u32
    }

    /// Returns the bytes of whole records from the record `from` on, at most `most` of them and at most 4,096.
    ///
    /// # Errors
    /// The system's error; a record that is damaged, with its number; a file in which another session has
    /// begun.
    pub fn records(&self, from: u32, most: usize) -> Result<Vec<u8>> {
        let mut bytes = self.slots(from, most)?;
        let mut whole = 0;
        for (index, record) in (from..).zip(bytes.as_chunks().0) {
            match self.decoder.check(index, record) {
                Ok(()) => whole += 1,
                Err(_) if is_unwritten(record) => break,
                // Read while it was written: it is whole the next time, unless it is damaged.
                Err(_) if self.is_written() => break,
                Err(why) => return Err(Error::file("read trace", &self.path, why)),
            }
        }
        bytes.truncate(whole * RECORD_BYTES);
        Ok(bytes)
    }

    /// Returns the bytes of the places of records from `from` on.
    fn slots(&self, from: u32, most: usize) -> Result<Vec<u8>> {
        let most = most.min(RECORDS_MAX);
        let at = self.header_bytes as u64 + u64::from(from) * RECORD_BYTES as u64;
        read_at(&self.file, at, most * RECORD_BYTES)
            .map_err(|why| Error::file("read trace", &self.path, why))
    }

    /// Number of records that the trace has: the place of the first one that is not written, by halving.
    ///
    /// # Errors
    /// The system's error.
    pub fn count(&self) -> Result<u32> {
        let places = self.bytes()?.saturating_sub(self.header_bytes as u64) / RECORD_BYTES as u64;
        let (mut written, mut end) =
            (self.first_record(), u32::try_from(places).unwrap_or(u32::MAX));
        while written < end {
            let middle = written + (end - written) / 2;
            match self.slots(middle, 1)?.first_chunk() {
                Some(record) if !is_unwritten(record) => written = middle + 1,
                _ => end = middle,
            }
        }
        Ok(written)
    }

    /// Returns the snapshots to which the trace refers so far, in order.
    ///
    /// # Errors
    /// The system's error.
    pub fn marks(&self) -> Result<Vec<Mark>> {
        let (mut marks, mut from) = (Vec::new(), self.first_record());
        loop {
            let bytes = self.slots(from, RECORDS_MAX)?;
            let (records, _) = bytes.as_chunks();
            for (index, record) in (from..).zip(records) {
                if is_unwritten(record) {
                    return Ok(marks);
                }
                let command = self.decoder.command(index, record);
                marks.extend(command.and_then(|of| Mark::of(index, &Entry::Command(of))));
            }
            if records.is_empty() {
                return Ok(marks);
            }
            from += records.len() as u32;
        }
    }

    /// Length of the file \[bytes\].
    fn bytes(&self) -> Result<u64> {
        let details = self.file.metadata();
        details.map(|of| of.len()).map_err(|why| Error::file("read", &self.path, why))
    }

    /// Returns true if the file ends with its `count` records: its writer has ended it. That of a killed one has
    /// room for more.
    ///
    /// # Errors
    /// The system's error.
    pub fn is_whole(&self, count: u32) -> Result<bool> {
        let bytes = self.header_bytes as u64 + u64::from(count) * RECORD_BYTES as u64;
        Ok(self.bytes()? <= bytes)
    }

    /// Returns true while a program records to the file.
    #[must_use]
    pub fn is_written(&self) -> bool {
        match self.file.try_lock_shared() {
            Ok(()) => {
                let _ = self.file.unlock();
                false
            }
            Err(TryLockError::WouldBlock) => true,
            Err(TryLockError::Error(_)) => false,
        }
    }

    /// Returns a number that identifies the session up to the record `next`: the checksum of the record before
    /// it, which counts its content, its index and the header; before the first record that of the beginning.
    ///
    /// # Errors
    /// The system's error.
    pub fn seal(&self, next: u32) -> Result<u32> {
        let before = next.checked_sub(1).filter(|_| next > self.first_record());
        match before {
            Some(record) => Ok(self.slots(record, 1)?.first_chunk().map_or(0, seal_of)),
            None => {
                let front = read_at(&self.file, 0, self.begun.len());
                let front = front.map_err(|why| Error::file("read trace", &self.path, why))?;
                Ok(seal_of_begun(&front))
            }
        }
    }
}

/// Returns the checksum of a record, which its writer stores last.
#[must_use]
pub fn seal_of(record: &[u8; RECORD_BYTES]) -> u32 {
    record.last_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

/// Returns what identifies a session before its first record, from the bytes that its trace begins with: see
/// [`Tail::seal`].
#[must_use]
pub fn seal_of_begun(begun: &[u8]) -> u32 {
    CRC_32.checksum(begun)
}

/// Returns true if a record's writer has not stored its checksum.
fn is_unwritten(record: &[u8; RECORD_BYTES]) -> bool {
    seal_of(record) == 0
}

/// Reads up to `most` bytes from an offset.
fn read_at(file: &File, at: u64, most: usize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; most];
    let mut read = 0;
    while read < most {
        match file.read_at(&mut bytes[read..], at + read as u64) {
            Ok(0) => break,
            Ok(more) => read += more,
            Err(why) if why.kind() == io::ErrorKind::Interrupted => {}
            Err(why) => return Err(why),
        }
    }
    bytes.truncate(read);
    Ok(bytes)
}
