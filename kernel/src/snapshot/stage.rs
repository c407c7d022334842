//! Snapshots of the output stage.

use super::{SNAPSHOT_HEADER_BYTES, SnapshotError, open, seal};
use crate::number::kept::{Kept, Pass};
use crate::stage::Stage;

impl Stage {
    /// Returns the bytes of a [snapshot](crate::snapshot), the same for every stage.
    #[must_use]
    pub fn snapshot_bytes(&self) -> usize {
        let mut pass = Pass::count();
        let mut copy = *self;
        copy.keep(&mut pass);
        SNAPSHOT_HEADER_BYTES + pass.end().unwrap_or(0)
    }

    /// Saves the whole stage except its settings; returns the number of bytes written.
    ///
    /// ```
    /// use chaincell_kernel::stage::{Device, Stage, StageSettings};
    ///
    /// let stage = Stage::new(StageSettings::for_device(Device::Falcon))?;
    /// let mut bytes = vec![0; stage.snapshot_bytes()];
    /// stage.save(&mut bytes)?;
    /// let mut later = Stage::new(*stage.settings())?; // settings are not in the snapshot
    /// later.restore(&bytes)?;
    /// assert_eq!(later, stage);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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

    /// Continues from a snapshot with the settings of this stage; if the saved stage had the same settings,
    /// the forces are the same. For any snapshot the ramp has the length in the settings, and no force is
    /// above the largest of the settings. The delay is the saved one.
    ///
    /// # Errors
    /// The first fault of the bytes; the stage stays as it is.
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
