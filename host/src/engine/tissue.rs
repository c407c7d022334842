//! What the loop needs of a tissue.

pub use chaincell_client::command::Refusal;
use chaincell_client::payload::NodePosition;
use chaincell_kernel::trace::Command;
use chaincell_kernel::{Budget, ContactForce, TickOutput, ToolPose};

use super::snapshot::Saved;
use super::tools::Felt;

/// A node with its published position.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Node {
    /// Id of the node in the input mesh.
    pub id: u32,
    /// Its position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
}

impl From<Node> for NodePosition {
    fn from(node: Node) -> Self {
        Self { node: node.id, position_m: node.position_m }
    }
}

/// A tissue that is advanced one tick at a time.
pub trait TissueEngine {
    /// Advances the tissue by one tick, with a pose for each tool, number 0 first, and this budget where
    /// [`Self::is_anytime`]. Tools beyond the poses are not engaged. Allocates nothing and never blocks.
    fn tick_by(&mut self, poses: &[ToolPose], budget: Budget<'_>) -> TickOutput;

    /// As [`Self::tick_by`], of one tool with all sweeps.
    fn tick(&mut self, pose: &ToolPose) -> TickOutput {
        self.tick_by(core::slice::from_ref(pose), Budget::All)
    }

    /// Whether a tick may end after any sweep. Without it every tick makes all its sweeps.
    fn is_anytime(&self) -> bool {
        false
    }

    /// Fewest sweeps of a tick that is not late, under whatever budget.
    fn least_sweeps(&self) -> u16 {
        1
    }

    /// How many tools were chosen by their parts; 0 where a sample is that of a probe or of held
    /// cells.
    fn tools(&self) -> usize {
        0
    }

    /// What a tool felt in the last tick.
    fn felt(&mut self, _tool: usize) -> Felt {
        Felt::default()
    }

    /// Whether an output stage stands before the device.
    fn has_stage(&self) -> bool {
        false
    }

    /// The ramp of an output stage begins anew: the device did not feel what was computed.
    fn restart_ramp(&mut self) {}

    /// So many samples in front of the next one got lost: told to an output stage before the tick.
    fn skipped(&mut self, _ticks: u16) {}

    /// An answer takes so many ticks of the device from its sample to the device's pushing with it: told
    /// before the tick, where the delay is measured.
    fn delayed(&mut self, _ticks: u16) {}

    /// Checksum of the model image, 0 without one.
    fn model_checksum(&self) -> u32 {
        0
    }

    /// Hash of the state after the last tick.
    fn state_hash(&mut self) -> u64;

    /// Writes the nodes by ascending id, as far as there is room. Allocates nothing.
    fn read_nodes(&mut self, _to: &mut [Node]) {}

    /// Tells each contact of a tool on a contact surface, with the input id of its node: at most
    /// [`CONTACTS_MAX`](super::tools::CONTACTS_MAX). Allocates nothing.
    fn read_contacts(&mut self, _each: &mut dyn FnMut(u32, &ContactForce)) {}

    /// All that tissue and output stage know; `None` where there is nothing to save. Takes memory.
    fn saved(&mut self) -> Option<Saved> {
        None
    }

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
    fn tick_by(&mut self, _poses: &[ToolPose], _budget: Budget<'_>) -> TickOutput {
        TickOutput::NONE
    }

    fn state_hash(&mut self) -> u64 {
        0
    }
}
