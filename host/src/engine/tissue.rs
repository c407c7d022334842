//! The loop's interface to a tissue.

pub use chaincell_client::command::Refusal;
use chaincell_client::payload::NodePosition;
use chaincell_client::stress::NodeStress;
use chaincell_client::surface::{SurfaceHeader, SurfaceRow};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{Budget, ContactForce, TickOutput, ToolPose};

use super::cut::report::CutReport;
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

    /// Returns true if a tick may end after any sweep. Otherwise every tick makes all its sweeps.
    fn is_anytime(&self) -> bool {
        false
    }

    /// Fewest sweeps of a tick that is not late, under any budget.
    fn least_sweeps(&self) -> u16 {
        1
    }

    /// Number of tools; 0 with held cells.
    fn tools(&self) -> usize {
        0
    }

    /// Output of a tool in the last tick.
    fn felt(&mut self, _tool: usize) -> Felt {
        Felt::default()
    }

    /// Position of a tool in the last tick, after an output stage, and the position at which the tissue meets
    /// it \[m\]; `None` if it is not engaged, waits inside the tissue, or holds cells.
    fn places_m(&mut self, _tool: usize) -> Option<[[f32; 3]; 2]> {
        None
    }

    /// Estimated error of a tool's force in the last tick, before its limit, see
    /// [`TissueMut::force_error_n`](chaincell_kernel::TissueMut::force_error_n) \[N\]; `None` if it is not known, and
    /// if an output stage answers another force.
    fn force_error_n(&mut self, _tool: usize) -> Option<f32> {
        None
    }

    /// Estimated error of a tool's torque likewise, see
    /// [`TissueMut::torque_error_n_m`](chaincell_kernel::TissueMut::torque_error_n_m) \[N m\].
    fn torque_error_n_m(&mut self, _tool: usize) -> Option<f32> {
        None
    }

    /// Returns true if the tissue has an output stage.
    fn has_stage(&self) -> bool {
        false
    }

    /// Restarts the ramp of an output stage: the device did not apply the computed force.
    fn restart_ramp(&mut self) {}

    /// Reports to an output stage, before the tick, that `ticks` samples before the next one were lost.
    fn skipped(&mut self, _ticks: u16) {}

    /// Reports to an output stage, before the tick, a measured delay: the device's ticks from a sample until
    /// it applies the answer.
    fn delayed(&mut self, _ticks: u16) {}

    /// Checksum of the model image, 0 without one.
    fn model_checksum(&self) -> u32 {
        0
    }

    /// The cut of a body since the last reset; `None` for one that cannot be cut. Allocates memory.
    fn cut(&mut self) -> Option<CutReport> {
        None
    }

    /// Energy that the branches of a body have relaxed since the last reset \[J\]; `None` for an elastic body.
    fn relaxed_j(&mut self) -> Option<f32> {
        None
    }

    /// Hash of the state after the last tick.
    fn state_hash(&mut self) -> u64;

    /// Writes the nodes by ascending id, as many as fit. Allocates nothing.
    fn read_nodes(&mut self, _to: &mut [Node]) {}

    /// Writes strain and stress of the nodes by ascending id from the `first` one on, see
    /// [`Engine::read_stresses`](super::Engine::read_stresses); false if the tissue has none. Allocates nothing.
    fn read_stresses(
        &mut self,
        _first: usize,
        _to: &mut [NodeStress],
        _means_pa: &mut [f32],
    ) -> bool {
        false
    }

    /// Gives the nodes of split cells the stress of those copies, from the `first` one on, that have more, see
    /// [`Engine::add_copies`](super::Engine::add_copies); the number of copies that it has looked at. Allocates
    /// nothing.
    fn add_copies(
        &mut self,
        _first: usize,
        _most: usize,
        _to: &mut [NodeStress],
        _means_pa: &mut [f32],
    ) -> usize {
        0
    }

    /// Writes the surface of a body that can be cut, see [`Engine::read_surface`](super::Engine::read_surface).
    /// Allocates nothing after its first call.
    fn read_surface(&mut self, _to: &mut [SurfaceRow]) -> SurfaceHeader {
        SurfaceHeader::default()
    }

    /// Calls `each` for every contact of a tool on a contact surface, with the input id of its node: at most
    /// [`CONTACTS_MAX`](super::tools::CONTACTS_MAX). Allocates nothing.
    fn read_contacts(&mut self, _each: &mut dyn FnMut(u32, &ContactForce)) {}

    /// The whole state of tissue and output stage; `None` if it cannot be saved. Allocates memory.
    fn saved(&mut self) -> Option<Saved> {
        None
    }

    /// The number of the pin that was set last, of those that hold. Allocates nothing.
    fn newest_pin(&mut self) -> Option<u16> {
        None
    }

    /// Executes a command other than pause and resume. Allocates nothing.
    ///
    /// # Errors
    /// The reason for the refusal.
    fn command(&mut self, _command: &Command) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }
}

/// No tissue: force 0 at no cost, to measure the overhead of the machine.
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
