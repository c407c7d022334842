//! Snapshots of the output stage.

use super::{SNAPSHOT_HEADER_BYTES, SnapshotError, open, seal};
use crate::number::kept::{Kept, Pass};
use crate::stage::Stage;

impl Stage {
    /// Bytes of a [snapshot](crate::snapshot): always as many.
    #[must_use]
    pub fn snapshot_bytes(&self) -> usize {
        let mut pass = Pass::count();
        let mut copy = *self;
        copy.keep(&mut pass);
        SNAPSHOT_HEADER_BYTES + pass.end().unwrap_or(0)
    }

    /// Saves all that the stage knows but its settings; gives the number of bytes written.
    ///
    /// # Errors
    /// A buffer that is too short.
    pub fn save(&self, bytes: &mut [u8]) -> Result<usize, SnapshotError> {
        let (needed, given) = (self.snapshot_bytes(), bytes.len());
        let bytes = bytes.get_mut(..needed).ok_or(SnapshotError::Buffer { needed, given })?;
        let mut pass = Pass::write(bytes.get_mut(SNAPSHOT_HEADER_BYTES..).unwrap_or(&mut []));
        let mut copy = *self;
        copy.keep(&mut pass);
        pass.end()?;
        seal(bytes, <Self as Kept>::LAYOUT, 0);
        Ok(needed)
    }

    /// Goes on from a snapshot, with the settings that this stage has: with those of the saved one to
    /// the same forces. Whatever the snapshot says, the ramp is as long as the settings have it, and no
    /// force is above their largest. The delay is the one that was saved.
    ///
    /// # Errors
    /// What is wrong with the bytes; the stage stays as it is.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        let words = open(bytes, <Self as Kept>::LAYOUT, 0)?;
        let mut copy = *self;
        let mut pass = Pass::read(words);
        copy.keep(&mut pass);
        if pass.end()? != words.len() {
            return Err(SnapshotError::Length);
        }
        self.go_on_as(copy);
        Ok(())
    }
}
