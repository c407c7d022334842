//! Snapshots of a tissue on the heap and of its output stages, in the kernel's format.

use chaincell_kernel::{Dynamics, Network, Settings, TOOLS_MAX};

use super::{Engine, Memory};
use crate::error::{Error, Result};

/// A tissue and its output stage between two ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// Tools that were engaged.
    pub engaged: [bool; TOOLS_MAX],
    /// The tissue's settings.
    pub settings: Settings,
    /// The tissue's snapshot.
    pub tissue: Vec<u8>,
    /// The snapshots of the stages in sequence; empty without a stage.
    pub stage: Vec<u8>,
}

/// A tissue that can be saved, whatever its scheme.
pub(super) trait AnySaved {
    fn save(&mut self, network: &Network<'_>) -> Result<Vec<u8>>;
    fn restore(&mut self, network: &Network<'_>, bytes: &[u8]) -> Result<()>;
}

impl<D: Dynamics> AnySaved for Memory<D> {
    fn save(&mut self, network: &Network<'_>) -> Result<Vec<u8>> {
        let mut bytes = vec![0; self.view().snapshot_bytes(network).map_err(Error::check)?];
        self.view().save(network, &mut bytes).map_err(Error::check)?;
        Ok(bytes)
    }

    fn restore(&mut self, network: &Network<'_>, bytes: &[u8]) -> Result<()> {
        self.view().restore(network, bytes).map_err(Error::input)
    }
}

impl Engine<'_> {
    /// The whole state of the tissue, see [`chaincell_kernel::snapshot`].
    ///
    /// # Errors
    /// None for a tissue on the heap.
    pub fn save(&mut self) -> Result<Vec<u8>> {
        self.tissue.save(&self.network)
    }

    /// Restores the bytes of [`Self::save`] from an engine with the same model, scheme, numbers, contact and
    /// settings.
    ///
    /// # Errors
    /// Bytes of another engine, or damaged ones; the tissue is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        self.tissue.restore(&self.network, bytes)
    }
}
