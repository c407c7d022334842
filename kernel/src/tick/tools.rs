//! Tools on a model with a contact surface: choosing them, their outputs and their grips.

use super::settings::Network;
use super::tissue::TissueMut;
use crate::contact::error::ContactError;
use crate::contact::output::{ProxyPose, ToolOutput};
use crate::contact::pose::ToolPart;
use crate::contact::tools::{self, ContactForce};
use crate::energy::residual::places;
use crate::energy::surface::Proxies;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{add, output, scale};
use crate::number::clamp::finite;
use crate::solver::Dynamics;

impl<D: Dynamics> TissueMut<'_, D> {
    /// Returns the pose at which the tissue meets a tool; `None` while the tool is not engaged.
    #[must_use]
    pub fn proxy_pose(&self, network: &Network<'_>, tool: usize) -> Option<ProxyPose> {
        let (model, proxy) = (network.model(), &self.touch.tool(tool)?.proxy);
        let position_m = add(model.centre_m(), scale(model.unit_m(), proxy.pivot));
        Some(ProxyPose { position_m, orientation: proxy.turn.orientation(), share: proxy.share })
    }

    /// Replaces chosen cells by tools: each is a list of at most [`PARTS_MAX`](crate::PARTS_MAX) convex parts;
    /// one coefficient of Coulomb friction serves all, 0 for none. Each [`Self::tick`] then takes a pose for each
    /// tool.
    ///
    /// The model needs a contact surface ([`Model::has_contact_surface`](crate::Model)). A tissue without
    /// memory for anchors has no friction and no grips.
    ///
    /// # Errors
    /// The reason for the refusal; the old choice stays.
    pub fn choose_tools(
        &mut self,
        network: &Network<'_>,
        chosen: &[&[ToolPart]],
        friction: f32,
    ) -> Result<(), ContactError> {
        let model = self.may_choose(network)?;
        tools::check::<D>(model, &self.touch, self.room.len(), chosen, friction)?;
        if chosen.iter().any(|parts| parts.iter().any(ToolPart::is_edge))
            && !self.has_cut_memory(model)
        {
            return Err(ContactError::CannotCut);
        }
        tools::choose(model, &mut self.touch, chosen, friction);
        self.head.chosen = 0;
        self.head.dynamics.release();
        self.head.has_tools = true;
        Ok(())
    }

    /// Output of a tool in the last tick with a sweep; zero while it is not engaged.
    #[must_use]
    pub fn tool_output(&self, network: &Network<'_>, tool: usize) -> ToolOutput {
        let mut output = self.touch.output(network.model(), tool);
        output.clamp(network.settings().max_force_n);
        output
    }

    /// Energy that the tools on the surface gave the body in the last tick: the change of the contact energy by their
    /// motion before the sweeps let the tissue give way, and that with which the fronts of a blade begin \[J\]. Below 0
    /// where the tissue pushes them back; 0 for held cells, whose work is the change of the energy itself.
    ///
    /// Elastic energy and the work of cutting stay within the sum of it over all ticks: what the offsets of split cells
    /// add as they decay is a quarter at most of what the sweeps take. They may exceed the sum of
    /// [`TickOutput::work_j`](crate::TickOutput), which is that of the published forces, where the body lags behind a
    /// fast tool: in cuts with one sweep a tick by up to half, with more sweeps not at all.
    ///
    /// ```
    #[doc = include_str!("../contact/example.txt")]
    /// let (mut given_j, mut energy_j) = (0.0, 0.0);
    /// for step in 0..=6 {
    ///     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
    ///     energy_j = tissue.tick(&network, &[pose], Budget::All).energy_j;
    ///     given_j += tissue.given_j(&network);
    /// }
    /// assert!(0.0 < energy_j && energy_j < 1.001 * given_j);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn given_j(&self, network: &Network<'_>) -> f32 {
        finite(self.head.given * network.model().energy_unit_j())
    }

    /// Torque of the tissue on the handles of a tool's scissors about their pivot, in the last tick with a sweep
    /// \[N m\]: the force on the edge in the direction of cutting times the change of its place with the opening.
    /// Above 0 it resists closing. 0 for a tool without scissors. It is not clamped by the largest force.
    ///
    /// The work of the tool includes that of closing: this torque times the change of the opening.
    #[must_use]
    pub fn opening_torque_n_m(&self, network: &Network<'_>, tool: usize) -> f32 {
        let (model, torque) = (
            network.model(),
            self.touch.tool(tool).map(|tool| tool.proxy.edge.crossing().torque()),
        );
        finite(torque.unwrap_or(0.0) * (model.force_unit_n() * model.unit_m()))
    }

    /// Position of a cell at which a tool's force of the last tick with a sweep is taken [mean link lengths from
    /// the body's centre]: that of the next pass, where the body is nearer to its equilibrium, or
    /// [`Self::position`]. `None` beyond the last cell.
    ///
    /// ```
    #[doc = include_str!("../contact/example.txt")]
    /// tissue.choose_tools(&network, &[&[ToolPart::sphere(0.004)]], 0.0)?; // without friction
    /// for step in 0..=6 {
    ///     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
    ///     tissue.tick(&network, &[pose], Budget::All);
    /// }
    /// let mut cells = 0..model.cells();
    /// assert!(cells.any(|cell| {
    ///     tissue.contact_position(&model, 0, cell) != tissue.position(&model, cell) // it still gives way
    /// }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn contact_position(
        &self,
        model: &Model<'_>,
        tool: usize,
        cell: usize,
    ) -> Option<[D::Number; 3]> {
        let is_ahead = self.touch.tool(tool).is_some_and(|tool| tool.is_ahead);
        let next = self.head.dynamics.next_points(self.own, model.cells());
        let Some(next) = next.filter(|_| is_ahead) else { return self.position(model, cell) };
        let k = D::Number::from_single(model.saturation());
        Some(output(next.get(cell)?.xyz(), k))
    }

    /// Calls `each` for every contact of the last tick with a sweep, one per triangle and part of a tool. In all
    /// they make each tool's force. Cost: one look at the samples in reach.
    ///
    /// ```
    #[doc = include_str!("../contact/example.txt")]
    /// # for step in 0..=6 {
    /// #     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
    /// #     tissue.tick(&network, &[pose], Budget::All);
    /// # }
    /// let mut sum_n = 0.0;
    /// tissue.contact_forces(&network, |contact| sum_n += contact.normal_n[2] + contact.tangential_n[2]);
    /// let force_n = tissue.tool_output(&network, 0).force_n.z;
    /// assert!((sum_n - force_n).abs() < 1e-3 * force_n); // [N], in all the tool's force
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contact_forces(&mut self, network: &Network<'_>, each: impl FnMut(&ContactForce)) {
        let whole = network.model();
        self.with_body_model(whole, |tissue, model| tissue.contacts_of(whole, model, each));
    }

    /// Calls `each` for the contacts on a body as it is; `whole` is the body as its image has it.
    fn contacts_of(
        &mut self,
        whole: &Model<'_>,
        model: &Model<'_>,
        mut each: impl FnMut(&ContactForce),
    ) {
        let Some(state) = self.state.get(..model.cells()) else { return };
        let next = self.head.dynamics.next_points(self.own, model.cells()).unwrap_or(state);
        let points = [places(model, state), places(model, next)];
        let Some(arrays) = self.touch.arrays(model.cells()) else { return };
        let among = (Proxies(arrays.tools), arrays.near(), arrays.anchors());
        let (unit_m, unit_n) = (model.unit_m(), model.force_unit_n());
        for contact in tools::forces(whole, among.0, among.1, among.2, &points) {
            let surface = model.contact_surface();
            let named = surface.and_then(|surface| surface.named(contact.triangle));
            let area = named.map_or(0.0, |(_, of)| of.area);
            each(&ContactForce {
                position_m: add(model.centre_m(), scale(unit_m, contact.position_m)),
                normal_n: scale(unit_n, contact.normal_n).map(finite),
                tangential_n: scale(unit_n, contact.tangential_n).map(finite),
                area_m2: finite(contact.area_m2 * area * (unit_m * unit_m)),
                ..contact
            });
        }
    }

    /// Makes a tool grip its samples in contact: it holds them at their positions in its frame, without slip,
    /// until [`Self::let_go`] or until it is no longer engaged. A tool that does not move then acts as a pin.
    /// Returns the number of samples that it holds, 0 without contact.
    ///
    /// The force does not jump: a grip starts without pull. Call it between two ticks.
    ///
    /// ```
    #[doc = include_str!("../contact/example.txt")]
    /// # for step in 0..=6 {
    /// #     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
    /// #     tissue.tick(&network, &[pose], Budget::All);
    /// # }
    /// assert!(tissue.grip(&network, 0) > 0); // samples held
    /// for step in 0..=10 {
    ///     let pose = ToolPose::at([0.0, 0.0, 0.030 + 0.001 * step as f32].into(), 1);
    ///     tissue.tick(&network, &[pose], Budget::All);
    /// }
    /// assert!(tissue.tool_output(&network, 0).force_n.z < 0.0); // [N], the tissue pulls at the tool
    ///
    /// tissue.let_go(0, 5); // within five ticks
    /// # for _ in 0..6 {
    /// #     tissue.tick(&network, &[ToolPose::at([0.0, 0.0, 0.040].into(), 1)], Budget::All);
    /// # }
    /// assert_eq!(tissue.gripped(&network, 0), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn grip(&mut self, network: &Network<'_>, tool: usize) -> usize {
        let model = network.model();
        let Some(state) = self.state.get(..model.cells()) else { return 0 };
        let at = places(model, state);
        let Some(mut arrays) = self.touch.arrays(model.cells()) else { return 0 };
        let (held, change) = tools::take_hold(&mut arrays, tool, &at);
        self.head.level.shift(change);
        self.head.awake.wake_all(model);
        self.head.dynamics.interrupt();
        held
    }

    /// Releases the tool's grip within `ticks` ticks: the pull falls to 0 without a jump.
    pub fn let_go(&mut self, tool: usize, ticks: u16) {
        let Some(arrays) = self.touch.whole() else { return };
        if let Some(tool) = arrays.tools.get_mut(tool) {
            tool.fade = 1.0 / f32::from(if ticks > 0 { ticks } else { 1 });
        }
    }

    /// Number of samples that a tool grips.
    #[must_use]
    pub fn gripped(&mut self, network: &Network<'_>, tool: usize) -> usize {
        let arrays = self.touch.arrays(network.model().cells());
        arrays.map_or(0, |arrays| tools::held_by(&arrays, tool))
    }
}
