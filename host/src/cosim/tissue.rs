//! What the loop needs of a tissue.

use chaincell_kernel::sample::{TickOutput, ToolSample};

/// A tissue that is advanced one tick at a time.
pub trait TissueEngine {
    /// Advances the tissue by one tick. Allocates nothing and never blocks.
    fn tick(&mut self, sample: &ToolSample) -> TickOutput;

    /// Hash of the state after the last tick.
    fn state_hash(&mut self) -> u64;
}

/// A tissue that isn't there: force 0 at no cost, for measuring what the machine itself takes.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoTissue;

impl TissueEngine for NoTissue {
    fn tick(&mut self, _sample: &ToolSample) -> TickOutput {
        TickOutput {
            force_n: nalgebra::Vector3::zeros(),
            energy_j: 0.0,
            contacts: 0,
            flags: chaincell_kernel::sample::Flags::default(),
        }
    }

    fn state_hash(&mut self) -> u64 {
        0
    }
}
