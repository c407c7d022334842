//! Estimate of the error of a tick's force.
//!
//! With r the residual of the last pass, z = M r the preconditioned residual (both levels), b the change of the
//! gradient with the tool's place and H the second derivative of the energy, the force is off by about b . `H^-1` r.
//! M stands for `H^-1`, and r . z is a sum that the sweep has already:
//!
//! ```text
//! estimate = A sqrt(sqrt(k l) r . z / n) + FLOOR |F| + B sqrt(k l) d
//! ```
//!
//! k is the tool's stiffness, l that of a link, n the number of sweeps in the tick and A a factor for held cells or for
//! tools. d is the tool's way since the last sweep, in late ticks, which repeat its force; B sqrt(k l) is above the
//! stiffness of the body under the tool, as k alone is many times.
//!
//! The form and the factors A are from an experiment, not from a theorem: 14 blocks, organs and real livers of nodal
//! shapes, 160 to 860 cells, Poisson's ratio 0.1 to 0.49; presses, slides, circles, taps, tremor, jumps and random
//! motions at two speeds, with 1, 2 and 4 sweeps under `predict`; one or seven held cells, balls of 1.1 to 4 edges, one
//! with friction, two at once. The true error is the distance to the force of 100 sweeps in the same tick. They cover
//! 99.3 % of these ticks; `tests/MEASURED.md` has what they cover of bodies and motions kept out, two of which gave B.

use super::settings::Network;
use super::tissue::TissueMut;
use crate::contact::ToolContact;
use crate::contact::context::Context;
use crate::contact::output::ToolOutput;
use crate::energy::surface::TOOLS_MAX;
use crate::model::Model;
use crate::number::cell::dot;
use crate::number::clamp::finite;
use crate::number::sqrt::sqrt;
use crate::solver::Dynamics;

/// Factor A of held cells, and of tools.
const OF_HELD: f32 = 2.4;
const OF_TOOLS: f32 = 7.0;
/// Factor B of the way in late ticks.
const OF_WAY: f32 = 1.5;
/// Share of the force within which a body at rest wanders.
const FLOOR: f32 = 2.0e-4;

impl<D: Dynamics> TissueMut<'_, D> {
    /// Estimate of the distance between a tool's force in the last tick and the force of the body in equilibrium with
    /// the tools where they are \[N\]. In the experiment behind it the error was below it in 99 of 100 ticks, and in
    /// half of those that count below 0.3 of it. It is an estimate, no proven bound. Of held cells `tool` is 0; the
    /// force is that before its limit and before an output stage.
    ///
    /// `None` where none is known: under another scheme than [`Predict`](crate::Predict), and of bodies of links, which
    /// snap, or without a coarse level; once a face is open; after a tick in the safe state, or one in which a limit
    /// shortened the motion; in late ticks after them, after a restore or a release, and in all late ticks of cells
    /// held in a body that relaxes; without contact, under a current, beyond K. In a late tick the caller has to know
    /// which of several tools was released, and the motion of another tool is not counted.
    ///
    /// Cost: seven square roots at most; a tick keeps two numbers for it.
    ///
    /// ```
    /// # use chaincell_kernel::*;
    /// # if FEATURES != ["nodal", "surface"] {
    /// #     return Ok(());
    /// # }
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/touch6.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// # let network = Network::new(model, Settings::for_model(&model))?;
    /// # type Body = Tissue<160, Predict<{ elastic_room(32) }>, 4, { term_states(160) }>;
    /// # let mut body = Box::new(Body::new());
    /// # let mut store = TouchStore::<160, 64, 64>::new();
    /// # let mut tissue = body.touching(store.room());
    /// # tissue.reset(&network)?;
    /// tissue.choose_tools(&network, &[&[ToolPart::sphere(0.004)]], 0.3)?;
    /// for step in 0..=20 {
    ///     let pose = ToolPose::at([0.0, 0.0, 0.036 - 0.0002 * step as f32].into(), 1);
    ///     tissue.tick(&network, &[pose], Budget::All);
    /// }
    /// let force_n = tissue.tool_output(&network, 0).force_n.z;
    /// let error_n = tissue.force_error_n(&network, 0).ok_or("not known")?;
    /// assert!(0.0 < error_n && error_n < 0.5 * force_n, "{error_n} of {force_n}");
    /// tissue.tick(&network, &[ToolPose::at([0.0, 0.0, 0.031].into(), 1)], Budget::LATE);
    /// let late_n = tissue.force_error_n(&network, 0).ok_or("not known")?;
    /// assert!(late_n > 1.2 * error_n); // the force of an earlier tick, and the tool has gone 1 mm since
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn force_error_n(&self, network: &Network<'_>, tool: usize) -> Option<f32> {
        let (model, head, energy_j) = (network.model(), &*self.head, self.off_balance_j(network)?);
        let (scale, way_m) = if head.has_tools {
            let output = self.touch.output(model, tool);
            (Scale::of_tool(&output, model)?, self.way_m(model, tool, self.lever_m(model, tool)))
        } else {
            let is_held = tool == 0 && head.chosen > 0;
            let way = head.dynamics.ahead();
            let scale = is_held.then(|| Scale::of_held(head.force_n, head.outer_weight, model))?;
            (scale, model.unit_m() * sqrt(dot(way, way)))
        };
        Some(finite(scale.error_n(energy_j) + scale.late_n(way_m)))
    }

    /// Estimate of the distance between the torque on a tool, about its position, and that of the body in equilibrium
    /// \[N m\]: that of [`force_error_n`](Self::force_error_n), with the root mean square of the levers at which the
    /// contact resists a rotation. `None` where that is, and for held cells.
    ///
    /// Cost: eight square roots.
    #[must_use]
    pub fn torque_error_n_m(&self, network: &Network<'_>, tool: usize) -> Option<f32> {
        let (model, energy_j) = (network.model(), self.off_balance_j(network)?);
        let output = self.head.has_tools.then(|| self.touch.output(model, tool))?;
        let scale = Scale::of_tool(&output, model)?;
        let lever_m = self.lever_m(model, tool);
        let off_n = scale.off_balance_n(energy_j) + scale.late_n(self.way_m(model, tool, lever_m));
        let torque_n_m: [f32; 3] = output.torque_n_m.into();
        let floor_n_m = FLOOR * sqrt(dot(torque_n_m, torque_n_m));
        Some(finite(lever_m * off_n + floor_n_m))
    }

    /// Root mean square of the levers at which a tool's contact resists a rotation \[m\].
    fn lever_m(&self, model: &Model<'_>, tool: usize) -> f32 {
        let stiffness_n_per_m = self.touch.output(model, tool).stiffness_n_per_m;
        let turning_n_m = self.touch.turning_n_m(model, tool);
        // The stiffness of a tool in contact is above 0; one that is not is divided by nothing.
        if stiffness_n_per_m > 0.0 { sqrt(turning_n_m / stiffness_n_per_m) } else { 0.0 }
    }

    /// Way of a tool's contact since its last tick with a sweep, the rotation at the lever \[m\]; 0 but for late ticks.
    fn way_m(&self, model: &Model<'_>, tool: usize, lever_m: f32) -> f32 {
        let [way_m, angle] = self.touch.since(model, tool);
        let turned_m = lever_m * angle;
        sqrt(way_m * way_m + turned_m * turned_m)
    }

    /// r . z over the number of sweeps \[J\]; `None` where no error is known.
    fn off_balance_j(&self, network: &Network<'_>) -> Option<f32> {
        let (model, head) = (network.model(), &*self.head);
        let is_known = head.settled > 0 && head.off_balance >= 0.0 && !head.level.is_driven();
        if !is_known || !head.engaged || !self.tells_force_error(network) || self.is_open(model) {
            return None;
        }
        Some(head.off_balance * model.energy_unit_j() / f32::from(head.settled))
    }

    /// True once a face is open.
    pub(super) fn is_open(&self, model: &Model<'_>) -> bool {
        model.cuttable().is_any() && self.body_state(model).is_some()
    }

    /// Returns true if the error of a force can be known of this body: nodal shapes with a coarse level, under
    /// [`Predict`](crate::Predict).
    #[must_use]
    pub fn tells_force_error(&self, network: &Network<'_>) -> bool {
        is_told::<D>(network.model())
    }
}

/// True if the experiment had bodies and schemes like these.
fn is_told<D: Dynamics>(model: &Model<'_>) -> bool {
    D::TELLS_ERROR && model.is_nodal() && model.coarse_functions() > 0
}

/// Turns the energy r . z / n into the error of a force, and back.
struct Scale {
    /// sqrt(k l) \[N/m\].
    stiffness_n_per_m: f32,
    factor: f32,
    /// Size of the force \[N\].
    force_n: f32,
}

impl Scale {
    /// For a tool with this output; `None` without contact.
    fn of_tool(output: &ToolOutput, model: &Model<'_>) -> Option<Self> {
        let force_n: [f32; 3] = output.force_n.into();
        let stiffness_n_per_m = sqrt(output.stiffness_n_per_m * model.stiffness_n_per_m());
        let force_n = sqrt(dot(force_n, force_n));
        (output.contacts > 0).then_some(Self { stiffness_n_per_m, factor: OF_TOOLS, force_n })
    }

    /// For held cells with this weight of the links around them.
    fn of_held(force_n: [f32; 3], outer_weight: f32, model: &Model<'_>) -> Self {
        let stiffness_n_per_m = model.stiffness_n_per_m() * sqrt(outer_weight);
        Self { stiffness_n_per_m, factor: OF_HELD, force_n: sqrt(dot(force_n, force_n)) }
    }

    fn error_n(&self, energy_j: f32) -> f32 {
        self.off_balance_n(energy_j) + FLOOR * self.force_n
    }

    /// Change of the force that the tissue has not followed on this way \[N\].
    fn late_n(&self, way_m: f32) -> f32 {
        OF_WAY * self.stiffness_n_per_m * way_m
    }

    /// Without the share of the force.
    fn off_balance_n(&self, energy_j: f32) -> f32 {
        self.factor * sqrt(self.stiffness_n_per_m * energy_j)
    }

    /// The energy at which the error is this share of the force \[J\]; below 0 for a share that is never reached.
    fn energy_j(&self, share: f32) -> f32 {
        let within_n = (share - FLOOR) * self.force_n / self.factor;
        let energy_j = within_n * within_n / self.stiffness_n_per_m;
        if share > FLOOR { energy_j } else { -1.0 }
    }
}

/// r . z over the number of sweeps at which the error of the force on every tool in contact is this share of its last
/// force, `force_n` of held cells; `None` where the error is not known.
pub(super) fn enough<D: Dynamics>(
    share: f32,
    context: &Context<'_, '_, D>,
    contact: &ToolContact<'_, D>,
    force_n: [f32; 3],
) -> Option<f32> {
    let model = context.model();
    if !context.was_engaged || !is_told::<D>(model) {
        return None;
    }
    // The tool whose force asks for the most counts.
    let energy_j = match contact {
        ToolContact::Held(held) => {
            Some(Scale::of_held(force_n, *held.outer_weight, model).energy_j(share))
        }
        ToolContact::Tools(_) => {
            let outputs = (0..TOOLS_MAX).map(|tool| contact.output(context, tool));
            let scales = outputs.filter_map(|output| Scale::of_tool(&output, model));
            scales.map(|scale| scale.energy_j(share)).reduce(f32::min)
        }
        ToolContact::Load(_) => None,
    };
    energy_j.map(|energy_j| energy_j / model.energy_unit_j())
}
