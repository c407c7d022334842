//! A file mapped for writing, the only place that writes through a pointer. Crates with safe write calls
//! cannot make pages writable in one thread while another thread writes.
#![allow(unsafe_code, reason = "bytes of a mapped file are written in place")]

use std::fs::File;
use std::io;
use std::ptr::copy_nonoverlapping;
use std::sync::Arc;

use memmap2::{Advice, MmapRaw};

/// The bytes of a file. Only one value of this type writes a file: see the lock in `file.rs`.
#[derive(Debug)]
pub(super) struct Map(Arc<MmapRaw>);

/// Makes pages of a [`Map`] writable, from any thread.
#[derive(Debug)]
pub(super) struct Pages(Arc<MmapRaw>);

impl Map {
    /// Maps the whole file.
    pub(super) fn of(file: &File) -> io::Result<Self> {
        Ok(Self(Arc::new(MmapRaw::map_raw(file)?)))
    }

    pub(super) fn pages(&self) -> Pages {
        Pages(Arc::clone(&self.0))
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Copies bytes to offset `at`. Returns false, and copies nothing, if they do not fit. Makes no system
    /// call.
    pub(super) fn put(&mut self, at: usize, bytes: &[u8]) -> bool {
        let fits = at.checked_add(bytes.len()).is_some_and(|end| end <= self.len());
        if fits {
            // SAFETY: the range lies in the mapping, which lives as long as `self`; nothing else in
            // this process reads or writes it, so `bytes` lie elsewhere and no reference is broken.
            unsafe {
                copy_nonoverlapping(bytes.as_ptr(), self.0.as_mut_ptr().add(at), bytes.len());
            }
        }
        fits
    }
}

impl Pages {
    /// Makes the pages of `bytes` bytes from `at` on writable without changing them: a write there then
    /// causes no page fault, until the system has written them to the disk.
    pub(super) fn prepare(&self, at: usize, bytes: usize) -> io::Result<()> {
        let at = at.min(self.0.len());
        self.0.advise_range(Advice::PopulateWrite, at, bytes.min(self.0.len() - at))
    }
}
