//! A snapshot of a session, whose layout is in `host/src/files/snapshot.rs`.

use chaincell_kernel::Settings;

use super::stream::CRC;

/// Room for a snapshot of this board's body \[bytes\].
pub const ROOM_BYTES: usize = 48 << 10;

const HEAD: [u8; 12] = *b"CHAINSES\x01\0\0\0";

/// The part of a snapshot that a board needs.
pub struct Snapshot<'a> {
    pub is_paused: bool,
    /// The settings in force.
    pub settings: Settings,
    /// What the session's trace begins with.
    pub begun: &'a [u8],
    /// The kernel's snapshots.
    pub tissue: &'a [u8],
    pub stage: &'a [u8],
}

impl<'a> Snapshot<'a> {
    /// Reads a snapshot; `None` for bytes that are none, or are damaged.
    pub fn read(bytes: &'a [u8]) -> Option<Self> {
        let mut rest = Rest(bytes.strip_prefix(&HEAD)?);
        let sum = rest.word()?;
        let mut digest = CRC.digest();
        digest.update(&HEAD);
        digest.update(rest.0);
        if digest.finalize() != sum {
            return None;
        }
        // Tick and publisher belong to the server, the engaged tools to the stages of several.
        let [.., paused]: [u32; 9] = rest.words()?;
        let settings = Settings::from_words(rest.words()?)?;
        let (begun, tissue, stage) = (rest.part()?, rest.part()?, rest.part()?);
        Some(Self { is_paused: paused != 0, settings, begun, tissue, stage })
    }
}

/// Bytes that are still to be read.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn word(&mut self) -> Option<u32> {
        let (word, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*word))
    }

    fn words<const COUNT: usize>(&mut self) -> Option<[u32; COUNT]> {
        let mut words = [0; COUNT];
        for word in &mut words {
            *word = self.word()?;
        }
        Some(words)
    }

    fn part(&mut self) -> Option<&'a [u8]> {
        let length = self.word()? as usize;
        let (part, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(part)
    }
}
