//! Tools on a contact surface: a pose, an output and contacts for each.

use chaincell_client::command::Refusal;
pub use chaincell_client::tools::{is_unit, length_of};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{
    ContactForce, Dynamics, Flags, Network, Number, ProxyPose, TOOLS_MAX, ToolOutput, ToolPose,
};

use super::touch::TRIANGLES;
use super::{Contact, Engine, Memory};

/// Largest number of contacts at a time.
pub const CONTACTS_MAX: usize = TRIANGLES;

/// The poses of all tools in a tick, number 0 first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Poses {
    count: usize,
    each: [ToolPose; TOOLS_MAX],
}

impl Poses {
    /// Poses of no tool.
    pub const NONE: Self = Self { count: 0, each: [ToolPose::AWAY; TOOLS_MAX] };

    /// Poses of `count` tools, at most [`TOOLS_MAX`], at the origin and not engaged.
    #[must_use]
    pub fn away(count: usize) -> Self {
        Self { count: count.min(TOOLS_MAX), ..Self::NONE }
    }

    /// These poses; those beyond [`TOOLS_MAX`] are ignored.
    #[must_use]
    pub fn of(poses: &[ToolPose]) -> Self {
        Self::of_tools(poses.len(), poses)
    }

    /// Of this many tools, of which the first have these poses and the others are [`Self::away`].
    #[must_use]
    pub fn of_tools(count: usize, poses: &[ToolPose]) -> Self {
        let mut all = Self::away(count);
        for (place, pose) in all.each_mut().iter_mut().zip(poses) {
            *place = *pose;
        }
        all
    }

    /// One pose for each tool.
    #[must_use]
    pub fn each(&self) -> &[ToolPose] {
        self.each.get(..self.count).unwrap_or(&[])
    }

    /// The same, mutable.
    pub fn each_mut(&mut self) -> &mut [ToolPose] {
        self.each.get_mut(..self.count).unwrap_or(&mut [])
    }

    /// Returns true if the tick may use all of them.
    #[must_use]
    pub fn are_good(&self) -> bool {
        self.each().iter().all(ToolPose::is_good)
    }
}

impl Default for Poses {
    fn default() -> Self {
        Self::NONE
    }
}

/// Output of one of several tools in a tick, within the limits.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Felt {
    /// Force of the tissue on the tool \[N\].
    pub force_n: [f32; 3],
    /// Torque on the tool about its position \[N m\].
    pub torque_n_m: [f32; 3],
    /// Number of triangles in contact with it, or with gripped samples.
    pub contacts: u32,
    /// Flags of this tool: [`Flags::FORCE_CLAMPED`], [`Flags::FORCE_WITHHELD`], [`Flags::RELEASE_FIRST`] and
    /// [`Flags::STARTS_INSIDE`].
    pub flags: Flags,
    /// Estimated error of the tissue's force, before its limit; `None` where it is not known, and where an output
    /// stage answers another force \[N\].
    pub force_error_n: Option<f32>,
    /// Estimated error of the torque likewise, `None` for held cells too \[N m\].
    pub torque_error_n_m: Option<f32>,
}

impl Felt {
    /// All flags of the tool in a tick: those of the tick, except that these four are the tool's.
    #[must_use]
    pub fn all_flags(&self, of_tick: u32) -> u32 {
        let own = [
            Flags::FORCE_CLAMPED,
            Flags::FORCE_WITHHELD,
            Flags::RELEASE_FIRST,
            Flags::STARTS_INSIDE,
        ];
        let own = own.iter().fold(0, |own, flag| own | flag.0);
        of_tick & !own | self.flags.0
    }
}

/// Interface to the tools of a tissue of any scheme.
pub(super) trait AnyTools {
    fn tool_output(&mut self, network: &Network<'_>, tool: usize) -> ToolOutput;
    fn force_error_n(&mut self, network: &Network<'_>, tool: usize) -> Option<f32>;
    fn torque_error_n_m(&mut self, network: &Network<'_>, tool: usize) -> Option<f32>;
    fn tells_force_error(&mut self, network: &Network<'_>) -> bool;
    fn opening_torque_n_m(&mut self, network: &Network<'_>, tool: usize) -> f32;
    fn given_j(&mut self, network: &Network<'_>) -> f32;
    fn proxy_pose(&mut self, network: &Network<'_>, tool: usize) -> Option<ProxyPose>;
    fn contact_position(&mut self, network: &Network<'_>, tool: usize, cell: usize) -> [f64; 3];
    fn contact_forces(&mut self, network: &Network<'_>, each: &mut dyn FnMut(&ContactForce));
    fn grip(&mut self, network: &Network<'_>, tool: usize) -> usize;
    fn let_go(&mut self, tool: usize, ticks: u16);
    fn gripped(&mut self, network: &Network<'_>, tool: usize) -> usize;
}

impl<D: Dynamics> AnyTools for Memory<D> {
    fn tool_output(&mut self, network: &Network<'_>, tool: usize) -> ToolOutput {
        self.view().tool_output(network, tool)
    }

    fn force_error_n(&mut self, network: &Network<'_>, tool: usize) -> Option<f32> {
        self.view().force_error_n(network, tool)
    }

    fn torque_error_n_m(&mut self, network: &Network<'_>, tool: usize) -> Option<f32> {
        self.view().torque_error_n_m(network, tool)
    }

    fn tells_force_error(&mut self, network: &Network<'_>) -> bool {
        self.view().tells_force_error(network)
    }

    fn opening_torque_n_m(&mut self, network: &Network<'_>, tool: usize) -> f32 {
        self.view().opening_torque_n_m(network, tool)
    }

    fn given_j(&mut self, network: &Network<'_>) -> f32 {
        self.view().given_j(network)
    }

    fn proxy_pose(&mut self, network: &Network<'_>, tool: usize) -> Option<ProxyPose> {
        self.view().proxy_pose(network, tool)
    }

    fn contact_position(&mut self, network: &Network<'_>, tool: usize, cell: usize) -> [f64; 3] {
        let position = self.view().contact_position(network.model(), tool, cell);
        position.map_or([0.0; 3], |position| position.map(Number::double))
    }

    fn contact_forces(&mut self, network: &Network<'_>, each: &mut dyn FnMut(&ContactForce)) {
        self.view().contact_forces(network, each);
    }

    fn grip(&mut self, network: &Network<'_>, tool: usize) -> usize {
        self.view().grip(network, tool)
    }

    fn let_go(&mut self, tool: usize, ticks: u16) {
        self.view().let_go(tool, ticks);
    }

    fn gripped(&mut self, network: &Network<'_>, tool: usize) -> usize {
        self.view().gripped(network, tool)
    }
}

impl Engine<'_> {
    /// Output of a tool in the last tick, see
    /// [`TissueMut::tool_output`](chaincell_kernel::TissueMut::tool_output).
    pub fn tool_output(&mut self, tool: usize) -> ToolOutput {
        self.tissue.tool_output(&self.network, tool)
    }

    /// Estimate of the error of a tool's force in the last tick, see
    /// [`TissueMut::force_error_n`](chaincell_kernel::TissueMut::force_error_n) \[N\].
    pub fn force_error_n(&mut self, tool: usize) -> Option<f32> {
        self.tissue.force_error_n(&self.network, tool)
    }

    /// Estimate of the error of a tool's torque in the last tick, see
    /// [`TissueMut::torque_error_n_m`](chaincell_kernel::TissueMut::torque_error_n_m) \[N m\].
    pub fn torque_error_n_m(&mut self, tool: usize) -> Option<f32> {
        self.tissue.torque_error_n_m(&self.network, tool)
    }

    /// Returns true if the error of a force can be known of this tissue.
    pub fn tells_force_error(&mut self) -> bool {
        self.tissue.tells_force_error(&self.network)
    }

    /// Torque of the tissue on the handles of a tool's scissors in the last tick with a sweep, above 0 where it
    /// resists closing \[N m\]; `None` for a tool without scissors.
    pub fn opening_torque_n_m(&mut self, tool: usize) -> Option<f32> {
        self.has_scissors(tool).then(|| self.tissue.opening_torque_n_m(&self.network, tool))
    }

    /// Energy that the tools on the surface gave the body in the last tick, see
    /// [`TissueMut::given_j`](chaincell_kernel::TissueMut::given_j) \[J\].
    pub fn given_j(&mut self) -> f32 {
        self.tissue.given_j(&self.network)
    }

    /// Returns true for a tool with scissors.
    pub fn has_scissors(&self, tool: usize) -> bool {
        let Contact::Tools { tools, .. } = &self.contact else { return false };
        let parts = tools.get(tool);
        parts.is_some_and(|parts| parts.iter().any(|part| part.blades().is_some()))
    }

    /// The pose at which the tissue meets a tool; `None` while the tool is not engaged.
    pub fn proxy_pose(&mut self, tool: usize) -> Option<ProxyPose> {
        self.tissue.proxy_pose(&self.network, tool)
    }

    /// Returns true if a tool waits inside the tissue: it has no force until it has been outside.
    pub(super) fn waits(&mut self, tool: usize) -> bool {
        self.proxy_pose(tool).is_some_and(|pose| pose.share <= 0.0)
    }

    /// Positions of all cells at which a tool's force is taken [mean link lengths].
    pub fn contact_positions(&mut self, tool: usize) -> Vec<[f64; 3]> {
        let cells = 0..self.network.model().cells();
        cells.map(|cell| self.tissue.contact_position(&self.network, tool, cell)).collect()
    }

    /// Calls `each` for every contact of [`Self::contact_forces`], with the input id of its node; of a copy in a
    /// wound that of the node it was made from. Allocates nothing.
    pub fn read_contacts(&mut self, each: &mut dyn FnMut(u32, &ContactForce)) {
        let ids = self.network.model().input_id();
        self.tissue.contact_forces(&self.network, &mut |of| {
            each(ids.get(usize::from(of.origin)).copied().unwrap_or(u32::MAX), of);
        });
    }

    /// The contacts of all tools, one for each triangle and part of a tool; none for held cells.
    pub fn contact_forces(&mut self) -> Vec<ContactForce> {
        let mut forces = Vec::new();
        self.tissue.contact_forces(&self.network, &mut |of| forces.push(*of));
        forces
    }

    /// Makes a tool grip its samples in contact. Returns the number of samples that it holds.
    pub fn grip(&mut self, tool: usize) -> usize {
        self.tissue.grip(&self.network, tool)
    }

    /// Releases a tool's grip within `ticks` ticks.
    pub fn let_go(&mut self, tool: usize, ticks: u16) {
        self.tissue.let_go(tool, ticks);
    }

    /// Number of samples that a tool grips.
    pub fn gripped(&mut self, tool: usize) -> usize {
        self.tissue.gripped(&self.network, tool)
    }

    /// Executes a grip or a release. A refused command changes nothing.
    pub(super) fn obey_hold(&mut self, command: &Command) -> Result<(), Refusal> {
        let (Command::Grip { tool } | Command::LetGo { tool, .. }) = *command else {
            return Err(Refusal::Unsupported);
        };
        let (tool, tools) = (tool as usize, self.contact.tools());
        if tool >= tools {
            return Err(if tools == 0 { Refusal::NoSurface } else { Refusal::NoTool });
        }
        match *command {
            Command::LetGo { ticks, .. } if self.gripped(tool) > 0 => self.let_go(tool, ticks),
            Command::Grip { .. } if self.is_pressed(tool) => _ = self.grip(tool),
            _ => return Err(Refusal::NothingHeld),
        }
        Ok(())
    }

    /// Returns true if the tissue presses on a tool now, so that a grip would hold something.
    fn is_pressed(&mut self, tool: usize) -> bool {
        let mut found = false;
        self.read_contacts(&mut |_, of| {
            found |= usize::from(of.tool) == tool && of.normal_n != [0.0; 3];
        });
        found
    }
}
