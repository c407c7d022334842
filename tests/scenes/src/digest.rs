//! Everything that a run's ticks answer, in 64 bits.

use chaincell_kernel::TickOutput;
use crc::{CRC_64_XZ, Crc, Table};

static CRC: Crc<u64, Table<1>> = Crc::<u64, Table<1>>::new(&CRC_64_XZ);

/// Bytes that a tick adds.
pub const TICK_BYTES: usize = 32;

/// CRC-64/XZ over [`TICK_BYTES`] little-endian bytes a tick: state hash (u64), the bits of the
/// force's x, y, z and of the energy, contacts, flags (u32 each).
#[derive(Clone)]
pub struct Digest {
    crc: crc::Digest<'static, u64, Table<1>>,
    bytes: u64,
}

impl Digest {
    /// Of no bytes.
    #[must_use]
    pub fn new() -> Self {
        Self { crc: CRC.digest(), bytes: 0 }
    }

    /// Takes in one tick's answer.
    pub fn absorb(&mut self, output: &TickOutput, state_hash: u64) {
        let [x, y, z] = output.force_n.data.0[0].map(f32::to_bits);
        let words = [x, y, z, output.energy_j.to_bits(), output.contacts, output.flags.0];
        self.crc.update(&state_hash.to_le_bytes());
        for word in words {
            self.crc.update(&word.to_le_bytes());
        }
        self.bytes += TICK_BYTES as u64;
    }

    /// The digest of the bytes so far.
    #[must_use]
    pub fn value(&self) -> u64 {
        self.crc.clone().finalize()
    }

    /// Number of those bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Default for Digest {
    fn default() -> Self {
        Self::new()
    }
}
