//! Tools on a contact surface: a pose for each, what each feels, what it is in contact with.

use chaincell_kernel::{
    ContactForce, Dynamics, Network, ProxyPose, TickOutput, ToolOutput, ToolPose,
};

use super::{Engine, Memory};

/// What a tissue of any scheme does with tools.
pub(super) trait AnyTools {
    fn tick_tools(&mut self, network: &Network<'_>, poses: &[ToolPose]) -> TickOutput;
    fn tick_tools_again(
        &mut self,
        network: &Network<'_>,
        poses: &[ToolPose],
        sweeps: Option<u16>,
    ) -> TickOutput;
    fn tool_output(&mut self, network: &Network<'_>, tool: usize) -> ToolOutput;
    fn proxy_pose(&mut self, network: &Network<'_>, tool: usize) -> Option<ProxyPose>;
    fn contact_forces(&mut self, network: &Network<'_>, each: &mut dyn FnMut(&ContactForce));
    fn grip(&mut self, network: &Network<'_>, tool: usize) -> usize;
    fn let_go(&mut self, tool: usize, ticks: u16);
}

impl<D: Dynamics> AnyTools for Memory<D> {
    fn tick_tools(&mut self, network: &Network<'_>, poses: &[ToolPose]) -> TickOutput {
        self.view().tick_tools(network, poses)
    }

    fn tick_tools_again(
        &mut self,
        network: &Network<'_>,
        poses: &[ToolPose],
        sweeps: Option<u16>,
    ) -> TickOutput {
        let mut tissue = self.view();
        match sweeps {
            None => tissue.tick_tools(network, poses),
            Some(0) => tissue.tick_tools_late(network, poses),
            Some(sweeps) => tissue.tick_tools_while(network, poses, |done| done < sweeps),
        }
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
}

impl Engine<'_> {
    /// One tick with a pose for each tool, see
    /// [`TissueMut::tick_tools`](chaincell_kernel::TissueMut::tick_tools).
    pub fn tick_tools(&mut self, poses: &[ToolPose]) -> TickOutput {
        self.tissue.tick_tools(&self.network, poses)
    }

    /// The tick with a pose for each tool that made so many sweeps once: 0 for one that was late, `None`
    /// for one with the settings' count.
    pub fn tick_tools_again(&mut self, poses: &[ToolPose], sweeps: Option<u16>) -> TickOutput {
        self.tissue.tick_tools_again(&self.network, poses, sweeps)
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
}
