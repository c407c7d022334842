//! What the loop needs of a tissue.

use chaincell_kernel::sample::{TickOutput, ToolSample};
use chaincell_kernel::trace::Command;

use crate::session::ipc::command::Refusal;
use crate::session::ipc::payload::NodePosition;

/// A tissue that is advanced one tick at a time.
pub trait TissueEngine {
    /// Advances the tissue by one tick. Allocates nothing and never blocks.
    fn tick(&mut self, sample: &ToolSample) -> TickOutput;

    /// Hash of the state after the last tick.
    fn state_hash(&mut self) -> u64;

    /// Writes the nodes by ascending id, as far as there is room. Allocates nothing.
    fn read_nodes(&mut self, _to: &mut [NodePosition]) {}

    /// Carries out a command other than pause and resume. Allocates nothing.
    ///
    /// # Errors
    /// Why nothing was done.
    fn command(&mut self, _command: &Command) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }
}

/// A tissue that isn't there: force 0 at no cost, for measuring what the machine itself takes.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoTissue;

impl TissueEngine for NoTissue {
    fn tick(&mut self, _sample: &ToolSample) -> TickOutput {
        TickOutput::NONE
    }

    fn state_hash(&mut self) -> u64 {
        0
    }
}
