//! Tools on a contact surface: a pose for each, what each feels, what it is in contact with.

use chaincell_kernel::trace::Command;
use chaincell_kernel::{
    ContactForce, Dynamics, Network, ProxyPose, TickOutput, ToolOutput, ToolPose,
};

use super::tissue::Refusal;
use super::touch::TRIANGLES;
use super::{Contact, Engine, Memory};

/// Most contacts at a time.
pub const CONTACTS_MAX: usize = TRIANGLES;

/// What a tissue of any scheme does with tools.
pub(super) trait AnyTools {
    fn tick_tools(&mut self, network: &Network<'_>, poses: &[ToolPose]) -> TickOutput;
    fn tool_output(&mut self, network: &Network<'_>, tool: usize) -> ToolOutput;
    fn proxy_pose(&mut self, network: &Network<'_>, tool: usize) -> Option<ProxyPose>;
    fn contact_forces(&mut self, network: &Network<'_>, each: &mut dyn FnMut(&ContactForce));
    fn grip(&mut self, network: &Network<'_>, tool: usize) -> usize;
    fn let_go(&mut self, tool: usize, ticks: u16);
    fn gripped(&mut self, network: &Network<'_>, tool: usize) -> usize;
}

impl<D: Dynamics> AnyTools for Memory<D> {
    fn tick_tools(&mut self, network: &Network<'_>, poses: &[ToolPose]) -> TickOutput {
        self.view().tick_tools(network, poses)
    }

    fn tool_output(&mut self, network: &Network<'_>, tool: usize) -> ToolOutput {
        self.view().tool_output(network, tool)
    }

    fn proxy_pose(&mut self, network: &Network<'_>, tool: usize) -> Option<ProxyPose> {
        self.view().proxy_pose(network, tool)
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
    /// One tick with a pose for each tool, see
    /// [`TissueMut::tick_tools`](chaincell_kernel::TissueMut::tick_tools).
    pub fn tick_tools(&mut self, poses: &[ToolPose]) -> TickOutput {
        self.tissue.tick_tools(&self.network, poses)
    }

    /// What a tool felt in the last tick, see
    /// [`TissueMut::tool_output`](chaincell_kernel::TissueMut::tool_output).
    pub fn tool_output(&mut self, tool: usize) -> ToolOutput {
        self.tissue.tool_output(&self.network, tool)
    }

    /// Where the tissue meets a tool; `None` while that is not engaged.
    pub fn proxy_pose(&mut self, tool: usize) -> Option<ProxyPose> {
        self.tissue.proxy_pose(&self.network, tool)
    }

    /// Tools on a contact surface; 0 with held cells and with a probe among cells.
    #[must_use]
    pub fn tools_on_surface(&self) -> usize {
        if !self.network.model().has_contact_surface() {
            return 0;
        }
        match &self.contact {
            Contact::Cells(_) => 0,
            Contact::Probe { .. } => 1,
            Contact::Tools { tools, .. } => tools.len(),
        }
    }

    /// Tells each contact that [`Self::contact_forces`] gives, with the input id of its node. Allocates
    /// nothing.
    pub fn read_contacts(&mut self, each: &mut dyn FnMut(u32, &ContactForce)) {
        let ids = self.network.model().input_id();
        self.tissue.contact_forces(&self.network, &mut |of| {
            each(ids.get(usize::from(of.cell)).copied().unwrap_or(u32::MAX), of);
        });
    }

    /// The contacts of all tools, one for each triangle and part of a tool; none for held cells and
    /// for a probe among cells.
    pub fn contact_forces(&mut self) -> Vec<ContactForce> {
        let mut forces = Vec::new();
        self.tissue.contact_forces(&self.network, &mut |of| forces.push(*of));
        forces
    }

    /// A tool grips what it is in contact with; gives how many samples it holds.
    pub fn grip(&mut self, tool: usize) -> usize {
        self.tissue.grip(&self.network, tool)
    }

    /// A tool lets go of what it grips, within so many ticks.
    pub fn let_go(&mut self, tool: usize, ticks: u16) {
        self.tissue.let_go(tool, ticks);
    }

    /// Samples that a tool grips.
    pub fn gripped(&mut self, tool: usize) -> usize {
        self.tissue.gripped(&self.network, tool)
    }

    /// Carries out a grip or a letting go. What is refused changes nothing.
    pub(super) fn obey_hold(&mut self, command: &Command) -> Result<(), Refusal> {
        let (Command::Grip { tool } | Command::LetGo { tool, .. }) = *command else {
            return Err(Refusal::Unsupported);
        };
        let (tool, tools) = (tool as usize, self.tools_on_surface());
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

    /// Whether the tissue presses on a tool now: a grip then holds something.
    fn is_pressed(&mut self, tool: usize) -> bool {
        let mut found = false;
        self.read_contacts(&mut |_, of| {
            found |= usize::from(of.tool) == tool && of.normal_n != [0.0; 3];
        });
        found
    }
}
