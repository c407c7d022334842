//! Snapshots of a tissue on the heap, and of the output stage before it: the kernel's.

use chaincell_kernel::{Dynamics, Network, Settings, TOOLS_MAX};

use super::{Engine, Memory};
use crate::error::{Error, Result};

/// A tissue and its output stage between two ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// Which tools were engaged.
    pub engaged: [bool; TOOLS_MAX],
    /// The tissue's settings.
    pub settings: Settings,
    /// The tissue's snapshot.
    pub tissue: Vec<u8>,
    /// Those of the stages, one behind the other; none without a stage.
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
    /// All that the tissue knows, see [`chaincell_kernel::snapshot`].
    ///
    /// # Errors
    /// None that a tissue on the heap can have.
    pub fn save(&mut self) -> Result<Vec<u8>> {
        self.tissue.save(&self.network)
    }

    /// Goes on from what [`Self::save`] gave, of an engine with the same model, scheme, numbers,
    /// contact and settings.
    ///
    /// # Errors
    /// Bytes of another one, or damaged; the tissue stays as it is.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        self.tissue.restore(&self.network, bytes)
    }
}
