//! Tools on a model with a contact surface: choosing them, their outputs and their grips.

use nalgebra::Vector3;

use super::pose::{ToolPart, ToolPose};
use super::sample::ToolSample;
use super::settings::Network;
use super::surface::{held_by, places, take_hold};
use super::tissue::TissueMut;
use crate::energy::held::ContactError;
use crate::energy::surface::{
    ContactForce, IS_BUILT, PARTS_MAX, Proxies, Proxy, TOOLS_MAX, ToolState, forces,
};
use crate::model::COORDINATE_MAX;
use crate::number::cell::{add, scale};
use crate::number::clamp::{clamped, finite};
use crate::solver::Dynamics;

/// Largest coefficient of friction.
pub const FRICTION_MAX: f32 = 10.0;

/// Output of one of several tools in a tick.
///
/// ```
/// # use chaincell_kernel::{Budget, FEATURES, Model, Network, Settings, Tissue, ToolPart, ToolPose, TouchStore, Track, elastic_room, include_model, term_states};
/// use chaincell_kernel::ToolOutput;
/// # if FEATURES != ["nodal", "surface"] {
/// #     return Ok(());
/// # }
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/touch6.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # type Body = Tissue<160, Track<{ elastic_room(32) }>, 4, { term_states(160) }>;
/// # let mut body = Box::new(Body::new());
/// # let mut store = TouchStore::<160, 64, 64>::new();
/// # let mut tissue = body.touching(store.room());
/// # tissue.reset(&network)?;
/// # tissue.choose_tools(&network, &[&[ToolPart::sphere(0.004)]], 0.3)?;
/// # for step in 0..=6 {
/// #     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.001 * step as f32].into(), 1);
/// #     tissue.tick(&network, &[pose], Budget::All);
/// # }
///
/// let ToolOutput { force_n, torque_n_m, contacts, .. } = tissue.tool_output(&network, 0);
/// assert!(force_n.z > 0.05 && contacts > 0); // [N], a ball pressed down by 4 mm
/// assert!(torque_n_m.x.abs() < 0.004 * force_n.z); // [N m], about its centre
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolOutput {
    /// Force of the tissue on the tool \[N\].
    pub force_n: Vector3<f32>,
    /// Torque on it about its position \[N m\].
    pub torque_n_m: Vector3<f32>,
    /// Its part of [`TickOutput::work_j`](crate::TickOutput::work_j), including the work of the torque \[J\].
    pub work_j: f32,
    /// Upper bound of the stiffness at the tool within a tick [N/m].
    pub stiffness_n_per_m: f32,
    /// Number of triangles in contact with it, or with gripped samples.
    pub contacts: u32,
}

impl ToolOutput {
    /// Output of a tool without contact.
    pub const NONE: Self = Self {
        force_n: Vector3::new(0.0, 0.0, 0.0),
        torque_n_m: Vector3::new(0.0, 0.0, 0.0),
        work_j: 0.0,
        stiffness_n_per_m: 0.0,
        contacts: 0,
    };
}

/// Where the tissue meets a tool: its proxy, which stops short of the tool where that is too deep.
///
/// ```
/// # use chaincell_kernel::{Budget, FEATURES, Model, Network, Settings, Tissue, ToolPart, ToolPose, TouchStore, Track, elastic_room, include_model, term_states};
/// use chaincell_kernel::ProxyPose;
/// # if FEATURES != ["nodal", "surface"] {
/// #     return Ok(());
/// # }
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/touch6.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # type Body = Tissue<160, Track<{ elastic_room(32) }>, 4, { term_states(160) }>;
/// # let mut body = Box::new(Body::new());
/// # let mut store = TouchStore::<160, 64, 64>::new();
/// # let mut tissue = body.touching(store.room());
/// # tissue.reset(&network)?;
/// # tissue.choose_tools(&network, &[&[ToolPart::sphere(0.004)]], 0.3)?;
///
/// let outside = ToolPose::at([0.0, 0.0, 0.036].into(), 1);
/// tissue.tick(&network, &[outside], Budget::All);
/// let ProxyPose { position_m, share, .. } = tissue.proxy_pose(&network, 0).ok_or("not engaged")?;
/// assert!((position_m[2] - 0.036).abs() < 1e-6 && share == 1.0); // [m], at the tool
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProxyPose {
    /// Position of its frame in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Rotation from its frame to the mesh's: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// Share of the parts' radii that it has: below 1 after engaging in contact, 0 while it waits inside the
    /// tissue.
    pub share: f32,
}

impl<D: Dynamics> TissueMut<'_, D> {
    /// Returns the pose at which the tissue meets a tool; `None` while the tool is not engaged.
    #[must_use]
    pub fn proxy_pose(&self, network: &Network<'_>, tool: usize) -> Option<ProxyPose> {
        let (model, proxy) = (network.model(), &self.touch.tool(tool)?.proxy);
        let position_m = add(model.centre_m(), scale(model.unit_m(), proxy.pivot));
        Some(ProxyPose { position_m, orientation: proxy.turn.orientation(), share: proxy.share })
    }

    /// Replaces chosen cells by tools: each is a list of at most [`PARTS_MAX`] convex parts; one coefficient
    /// of Coulomb friction serves all, 0 for none. Each [`Self::tick`] then takes a pose for each tool.
    ///
    /// The model needs a contact surface ([`Model::has_contact_surface`](crate::Model)). A tissue without
    /// memory for anchors has no friction and no grips.
    ///
    /// # Errors
    /// The reason for the refusal; the old choice stays.
    pub fn choose_tools(
        &mut self,
        network: &Network<'_>,
        tools: &[&[ToolPart]],
        friction: f32,
    ) -> Result<(), ContactError> {
        // Check build, model and memory.
        let model = self.may_choose(network)?;
        if !IS_BUILT {
            return Err(ContactError::SurfaceUnbuilt);
        }
        if !model.has_contact_surface() {
            return Err(ContactError::NoContactSurface);
        }
        let (capacity, anchors) = self.touch.tool_capacity();
        let capacity = capacity.min(TOOLS_MAX);
        if tools.is_empty() || tools.len() > capacity {
            return Err(ContactError::Tools { needed: tools.len(), capacity });
        }
        if !(0.0..=FRICTION_MAX).contains(&friction) {
            return Err(ContactError::Friction { max: FRICTION_MAX });
        }
        if friction > 0.0 && anchors == 0 {
            return Err(ContactError::AnchorRoom);
        }
        // Check every part of every tool.
        let unit_m = model.unit_m();
        for (tool, parts) in tools.iter().enumerate() {
            if parts.is_empty() || parts.len() > PARTS_MAX {
                return Err(ContactError::Parts { tool, most: PARTS_MAX });
            }
            for (part, of) in parts.iter().enumerate() {
                let Some(solid) = of.solid(unit_m, COORDINATE_MAX) else {
                    return Err(ContactError::Part { tool, part });
                };
                self.check_touch(model, solid.sampled)?;
            }
        }
        let (needed, room) = (D::tool_room(model), self.room.len());
        if needed > room {
            return Err(ContactError::ToolRoom { needed, room });
        }
        // Take over the tools, at no contact.
        if let Some(arrays) = self.touch.whole() {
            for (slot, parts) in arrays.tools.iter_mut().zip(tools) {
                let parts = parts.iter().filter_map(|part| part.solid(unit_m, COORDINATE_MAX));
                *slot = ToolState { proxy: Proxy::of(parts), ..ToolState::NONE };
            }
            for state in &mut *arrays.state {
                (state.tools, state.friction) = (tools.len(), friction);
                (state.count, state.anchors) = (0, 0);
            }
        }
        self.head.chosen = 0;
        self.head.dynamics.release();
        self.head.has_tools = true;
        Ok(())
    }

    /// Output of a tool in the last tick with a sweep; zero while it is not engaged.
    #[must_use]
    pub fn tool_output(&self, network: &Network<'_>, tool: usize) -> ToolOutput {
        let model = network.model();
        let Some(tool) = self.touch.tool(tool) else { return ToolOutput::NONE };
        let force_n = scale(model.force_unit_n(), tool.met.force);
        let (force_n, _) = clamped(force_n, network.settings().max_force_n);
        let torque_n_m = scale(model.force_unit_n() * model.unit_m(), tool.met.torque).map(finite);
        ToolOutput {
            force_n: force_n.into(),
            torque_n_m: torque_n_m.into(),
            work_j: finite(tool.work * model.energy_unit_j()),
            stiffness_n_per_m: finite(2.0 * model.stiffness_n_per_m() * tool.met.stiffness),
            contacts: tool.met.touched,
        }
    }

    /// Calls `each` for every present contact, one per triangle and part of a tool. Cost: one look at the
    /// samples in reach.
    ///
    /// ```
    /// # use chaincell_kernel::{Budget, FEATURES, Model, Network, Settings, Tissue, ToolPart, ToolPose, TouchStore, Track, elastic_room, include_model, term_states};
    /// # if FEATURES != ["nodal", "surface"] {
    /// #     return Ok(());
    /// # }
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/touch6.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// # let network = Network::new(model, Settings::for_model(&model))?;
    /// # type Body = Tissue<160, Track<{ elastic_room(32) }>, 4, { term_states(160) }>;
    /// # let mut body = Box::new(Body::new());
    /// # let mut store = TouchStore::<160, 64, 64>::new();
    /// # let mut tissue = body.touching(store.room());
    /// # tissue.reset(&network)?;
    /// # tissue.choose_tools(&network, &[&[ToolPart::sphere(0.004)]], 0.3)?;
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
    pub fn contact_forces(&mut self, network: &Network<'_>, mut each: impl FnMut(&ContactForce)) {
        let model = network.model();
        let Some(state) = self.state.get(..model.cells()) else { return };
        let at = places(model, state);
        let Some(arrays) = self.touch.arrays(model.cells()) else { return };
        let among = (Proxies(arrays.tools), arrays.near(), arrays.anchors());
        let (unit_m, unit_n) = (model.unit_m(), model.force_unit_n());
        for contact in forces(among.0, among.1, among.2, at) {
            let area = model.contact_surface().and_then(|surface| {
                surface.triangle(contact.triangle as usize).map(|(_, of)| of.area)
            });
            each(&ContactForce {
                position_m: add(model.centre_m(), scale(unit_m, contact.position_m)),
                normal_n: scale(unit_n, contact.normal_n).map(finite),
                tangential_n: scale(unit_n, contact.tangential_n).map(finite),
                area_m2: finite(contact.area_m2 * area.unwrap_or(0.0) * (unit_m * unit_m)),
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
    /// # use chaincell_kernel::{Budget, FEATURES, Model, Network, Settings, Tissue, ToolPart, ToolPose, TouchStore, Track, elastic_room, include_model, term_states};
    /// # if FEATURES != ["nodal", "surface"] {
    /// #     return Ok(());
    /// # }
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/touch6.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// # let network = Network::new(model, Settings::for_model(&model))?;
    /// # type Body = Tissue<160, Track<{ elastic_room(32) }>, 4, { term_states(160) }>;
    /// # let mut body = Box::new(Body::new());
    /// # let mut store = TouchStore::<160, 64, 64>::new();
    /// # let mut tissue = body.touching(store.room());
    /// # tissue.reset(&network)?;
    /// # tissue.choose_tools(&network, &[&[ToolPart::sphere(0.004)]], 0.3)?;
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
        let (held, change, _) = take_hold(&mut arrays, tool, &at);
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
        arrays.map_or(0, |arrays| held_by(&arrays, tool))
    }

    /// Joins the poses into a sample: the first pose's position, engaged if any pose is or a tool beyond the
    /// poses is. `None` if a pose is bad, or there is none.
    pub(super) fn joined(&self, poses: &[ToolPose]) -> Option<ToolSample> {
        let (first, tools) = (poses.first()?, self.touch.tools());
        if !poses.iter().all(ToolPose::is_good) {
            return None;
        }
        let stays = tools.iter().skip(poses.len()).any(|tool| tool.is_in);
        let moved = poses.get(..tools.len().max(1)).unwrap_or(poses);
        let engaged = u32::from(stays || moved.iter().any(|pose| pose.engaged == 1));
        Some(ToolSample { position_m: first.position_m, engaged })
    }
}
