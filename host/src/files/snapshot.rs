//! Snapshots of sessions as files: those of tissue and output stage, with the state of the session.
//!
//! ```text
//! offset  bytes  content, little-endian
//!      0      8  magic "CHAINSES"
//!      8      4  format version (1)
//!     12      4  CRC-32 (ISO-HDLC) of all bytes but these four; identifies the snapshot in a trace
//!     16      8  last tick before it, 0 for none
//!     24     16  id of the publisher in charge, 0 for none
//!     40      4  bit t: tool t was seen released
//!     44      4  bit t: tool t was engaged
//!     48      4  1 while paused
//!     52     28  current settings: sweeps, step, time per tick, largest motion per tick [m], largest
//!                force [N], unloading, drive
//!     80      …  three times a length n (u32) and n bytes: the start of the session's trace, the tissue's
//!                snapshot, the stage's (empty without a stage)
//! ```

use std::io::Read;
use std::path::{Path, PathBuf};

use chaincell_kernel::{Settings, TOOLS_MAX};

use crate::checksum::CRC_32;
use crate::engine::snapshot::Saved;
use crate::error::{Error, Result};
use crate::input;

const MAGIC: [u8; 8] = *b"CHAINSES";
const VERSION: u32 = 1;
const CRC_AT: usize = 12;
/// Largest snapshot that is read: much larger than that of the largest body.
const BYTES_MAX: u64 = 1 << 28;

/// A session between two ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionSnapshot {
    /// Last tick before it, 0 for none.
    pub tick: u64,
    /// Id of the publisher in charge, 0 for none.
    pub publisher: u128,
    /// True for each tool that was seen released.
    pub released: [bool; TOOLS_MAX],
    /// True if the session was paused.
    pub is_paused: bool,
    /// Start of a trace of the session, with all settings from which it was started.
    pub begun: Vec<u8>,
    /// State of tissue and output stage.
    pub saved: Saved,
}

/// Returns the path of the snapshot after a tick of a trace.
#[must_use]
pub fn place(trace: &Path, tick: u64) -> PathBuf {
    let mut name = trace.as_os_str().to_owned();
    name.push(format!(".{tick}.snapshot"));
    name.into()
}

/// Returns the path for a copy of the snapshot from which a trace begins; no later snapshot gets this name.
#[must_use]
pub fn start_place(trace: &Path) -> PathBuf {
    let mut name = trace.as_os_str().to_owned();
    name.push(".start.snapshot");
    name.into()
}

/// Returns the checksum of a snapshot, which identifies it in a trace.
fn checksum(bytes: &[u8]) -> u32 {
    let mut digest = CRC_32.digest();
    digest.update(bytes.get(..CRC_AT).unwrap_or(bytes));
    digest.update(bytes.get(CRC_AT + 4..).unwrap_or(&[]));
    digest.finalize()
}

impl SessionSnapshot {
    /// Returns the bytes of its file, and its checksum.
    #[must_use]
    pub fn to_bytes(&self) -> (Vec<u8>, u32) {
        let Saved { engaged, settings, tissue, stage } = &self.saved;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(self.tick.to_le_bytes());
        bytes.extend(self.publisher.to_le_bytes());
        let words = [bits(&self.released), bits(engaged), self.is_paused.into()];
        bytes.extend(words.iter().chain(&settings.words()).flat_map(|word| word.to_le_bytes()));
        for part in [&self.begun, tissue, stage] {
            bytes.extend((part.len() as u32).to_le_bytes());
            bytes.extend(part);
        }
        let sum = checksum(&bytes);
        bytes[CRC_AT..CRC_AT + 4].copy_from_slice(&sum.to_le_bytes());
        (bytes, sum)
    }

    /// Reads the bytes of a file. Returns the snapshot and its checksum.
    ///
    /// # Errors
    /// The fault in the bytes.
    pub fn of(bytes: &[u8]) -> std::result::Result<(Self, u32), &'static str> {
        let mut rest = Rest(bytes);
        if rest.take() != Some(MAGIC) {
            return Err("it is no snapshot of a session: take one with chaincell command snapshot");
        }
        let damaged = "it is damaged or not whole: copy it again";
        if rest.word().ok_or(damaged)? != VERSION {
            return Err("it has another version: restore it with the release that took it");
        }
        let sum = checksum(bytes);
        if rest.word().ok_or(damaged)? != sum {
            return Err(damaged);
        }
        let snapshot = rest.snapshot().filter(|_| rest.0.is_empty()).ok_or(damaged)?;
        Ok((snapshot, sum))
    }

    /// Like [`Self::of`], for a file.
    ///
    /// # Errors
    /// The system's error, or the fault in the file, with the path.
    pub fn read(path: &Path) -> Result<(Self, u32)> {
        let failed = |why: std::io::Error| Error::file("read snapshot", path, why);
        let mut bytes = Vec::new();
        let file = input::open(path).map_err(failed)?;
        file.take(BYTES_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
        Self::of(&bytes).map_err(|why| Error::file("read snapshot", path, why))
    }
}

/// Returns bit t for tool t.
fn bits(tools: &[bool; TOOLS_MAX]) -> u32 {
    tools.iter().rev().fold(0, |bits, &is| bits << 1 | u32::from(is))
}

/// Bytes that are still to be read.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (front, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*front)
    }

    fn word(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn tools(&mut self) -> Option<[bool; TOOLS_MAX]> {
        let bits = self.word()?;
        Some(std::array::from_fn(|tool| bits >> tool & 1 == 1))
    }

    fn part(&mut self) -> Option<Vec<u8>> {
        let length = self.word()? as usize;
        let (part, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(part.to_vec())
    }

    fn snapshot(&mut self) -> Option<SessionSnapshot> {
        let tick = u64::from_le_bytes(self.take()?);
        let publisher = u128::from_le_bytes(self.take()?);
        let (released, engaged) = (self.tools()?, self.tools()?);
        let is_paused = match self.word()? {
            0 => false,
            1 => true,
            _ => return None,
        };
        let mut words = [0; Settings::WORDS];
        for word in &mut words {
            *word = self.word()?;
        }
        let settings = Settings::from_words(words)?;
        let (begun, tissue, stage) = (self.part()?, self.part()?, self.part()?);
        let saved = Saved { engaged, settings, tissue, stage };
        Some(SessionSnapshot { tick, publisher, released, is_paused, begun, saved })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::fixture::{engine, plane};

    fn only(tools: &[usize]) -> [bool; TOOLS_MAX] {
        std::array::from_fn(|tool| tools.contains(&tool))
    }

    fn snapshot() -> SessionSnapshot {
        let image = plane();
        let mut engine = engine(&image);
        let settings = Settings { sweeps: 7, ..*engine.network().settings() };
        let tissue = engine.save().unwrap();
        let saved = Saved { engaged: only(&[0]), settings, tissue, stage: vec![1, 2, 3] };
        let (tick, publisher, released) = (1234, 1 << 100, only(&[0, 2]));
        SessionSnapshot { tick, publisher, released, is_paused: true, begun: vec![9; 80], saved }
    }

    #[test]
    fn what_is_written_is_read() {
        let (bytes, sum) = snapshot().to_bytes();
        assert_eq!(SessionSnapshot::of(&bytes), Ok((snapshot(), sum)));
    }

    #[test]
    fn damage_is_seen() {
        let (bytes, _) = snapshot().to_bytes();
        for at in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            assert!(SessionSnapshot::of(&flipped).is_err(), "byte {at}");
            assert!(SessionSnapshot::of(&bytes[..at]).is_err(), "{at} bytes");
        }
        assert!(SessionSnapshot::of(&[bytes, vec![0]].concat()).is_err());
    }

    #[test]
    fn it_stands_beside_its_trace() {
        assert_eq!(place(Path::new("a/left.trace"), 12), Path::new("a/left.trace.12.snapshot"));
        assert_eq!(start_place(Path::new("a/b.trace")), Path::new("a/b.trace.start.snapshot"));
    }
}
