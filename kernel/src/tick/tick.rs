//! One tick, in the order that the contract fixes: sample, contact, sweeps, output. The terms' corrections
//! precede the contact.

use super::budget::Budget;
use super::choices::Drive;
use super::force_error;
use super::sample::{Flags, TickOutput, ToolSample};
use super::settings::{Network, Settings};
use super::tissue::{Head, TissueMut};
use crate::contact::context::Context;
use crate::contact::held::Held;
use crate::contact::load::Load;
use crate::contact::output::ToolOutput;
use crate::contact::pose::ToolPose;
use crate::contact::tools::Tools;
use crate::contact::{Acting, ToolContact};
use crate::energy::residual::Terms;
use crate::energy::surface::IS_BUILT;
use crate::number::cell::{Cell, dot};
use crate::number::clamp::finite;
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;
use crate::solver::scheme::{Body, Pace};

/// Consecutive bad samples for which the last good one is used.
///
/// ```
/// # use chaincell_kernel::{Budget, Flags, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
/// use chaincell_kernel::HELD_TICKS_MAX;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
/// let bad = [ToolPose::at([f32::NAN; 3].into(), 1)];
/// for _ in 0..HELD_TICKS_MAX {
///     let output = tissue.tick(&network, &bad, Budget::All);
///     assert_eq!(output.flags, Flags::BAD_SAMPLE);
/// }
/// let output = tissue.tick(&network, &bad, Budget::All); // the eleventh
/// assert!(output.flags.contains(Flags::SAFE_STATE)); // force 0 until a good one comes
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub const HELD_TICKS_MAX: u32 = 10;

impl<D: Dynamics> TissueMut<'_, D> {
    /// Computes one tick of the network with a pose for each tool. It cannot fail and makes at most
    /// [`Settings::sweeps`](crate::Settings::sweeps) link passes for any input, none in the safe state; under
    /// `predict`, tools that moved take at most two thirds of a pass more, around their contacts.
    /// [`TickOutput::sweeps`] is the number of sweeps made. Under `track` and `predict` the published state is
    /// certified after every sweep.
    ///
    /// Held cells follow the first pose and ignore its orientation. Poses beyond the
    /// tools are ignored; tools beyond the poses stay as they are. A bad pose, or no pose, makes the sample a
    /// bad one. The output is that of the first tool, with the work of all; [`Self::tool_output`] has the
    /// others'.
    ///
    /// The safe state (force 0, cells unchanged) is the output for samples that stay bad for more than
    /// [`HELD_TICKS_MAX`] ticks, and for a network other than that of the last reset. The calling thread must
    /// have the floating-point environment that the reset checked: IEEE 754, rounding to nearest.
    // Not inlined, so that a firmware with several calls has the code and its frame once.
    #[inline(never)]
    pub fn tick(
        &mut self,
        network: &Network<'_>,
        poses: &[ToolPose],
        mut budget: Budget<'_>,
    ) -> TickOutput {
        self.head.given = 0.0;
        let settled = core::mem::take(&mut self.head.settled);
        // Check network and sample; stop in the safe state if one is unusable.
        let mut flags = Flags::default();
        if self.head.model != Some(network.model().checksum()) {
            return self.safe(network, flags);
        }
        let sample = ToolSample::joined(poses, self.touch.tools());
        // After bad poses tools on the surface keep the last good ones.
        let poses = if sample.is_some() { poses } else { &[] };
        let Some(sample) = self.head.accept(sample, &mut flags) else {
            return self.safe(network, flags);
        };
        let is_late = D::IS_ANYTIME && budget.is_late() && !self.head.level.is_forgotten();
        // The cells that are held in a body that relaxes wait in late ticks.
        if is_late && (self.head.has_tools || !network.model().relaxes()) {
            self.head.settled = settled;
        }
        #[cfg(any(feature = "cut", feature = "relax"))]
        if network.model().cuttable().is_any() || network.model().relaxes() {
            return self.run_changed(network, &sample, poses, &mut budget, flags, is_late);
        }
        self.run(network, &sample, poses, &mut budget, flags, is_late).0
    }

    /// Changes a body that can be cut or that relaxes, then computes the tick. Cells split unless the tick is late, and
    /// in a body that tears the energy by which the sweeps lower the level pays for the next decay of offsets. The
    /// memory of one that relaxes follows its strain.
    // Not inlined: its frame holds a model.
    #[cfg(any(feature = "cut", feature = "relax"))]
    #[inline(never)]
    fn run_changed(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        poses: &[ToolPose],
        budget: &mut Budget<'_>,
        flags: Flags,
        is_late: bool,
    ) -> TickOutput {
        #[cfg(feature = "cut")]
        if !is_late {
            let of_pins = self.energy_of_pins(network.model());
            self.part(network);
            if let Some(of_pins) = of_pins {
                self.rename_pins(network, of_pins);
            }
            if D::TELLS_ERROR && budget.within().is_some() && self.is_open(network.model()) {
                budget.forget_error();
            }
        }
        #[cfg(feature = "relax")]
        self.relax(network, is_late);
        let (output, fallen) = self.with_body(network, |tissue, network| {
            tissue.run(network, sample, poses, budget, flags, is_late)
        });
        #[cfg(feature = "cut")]
        if !is_late {
            self.earn(network.model(), fallen);
        }
        #[cfg(not(feature = "cut"))]
        let _ = fallen;
        output
    }

    /// Computes a tick of a body as it is. Returns also the energy by which the sweeps have lowered the level, in
    /// internal units.
    #[cfg_attr(any(feature = "cut", feature = "relax"), inline(never))]
    #[cfg_attr(not(any(feature = "cut", feature = "relax")), inline(always))]
    fn run(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        poses: &[ToolPose],
        budget: &mut Budget<'_>,
        mut flags: Flags,
        is_late: bool,
    ) -> (TickOutput, f32) {
        let Some(mut tick) = self.start(network, sample, is_late) else {
            self.head.settled = 0;
            return (self.safe(network, flags), 0.0);
        };
        // Apply the terms' corrections and move the tools.
        let share = if D::TELLS_ERROR { budget.within() } else { None };
        let enough = share.and_then(|share| {
            force_error::enough(share, &tick.context, &tick.contact, *tick.force_n)
        });
        if !is_late {
            tick.correct();
        }
        tick.contact.advance(&mut tick.context, poses);
        // Sweep, unless the tick is late.
        let (mut sweeps, mut fallen) = (0, 0.0);
        if !is_late {
            tick.unload();
            let before = *tick.context.level;
            sweeps = tick.sweep(budget, enough, &mut flags);
            fallen = tick.context.level.fallen(&before);
            tick.settle();
        }
        let output = tick.output(flags, sweeps);
        // Beyond a limit the body follows another motion than the tool's.
        if !is_late {
            self.head.settled = sweeps;
        }
        if output.flags.contains(Flags::MOTION_CLAMPED) || !self.head.engaged {
            self.head.settled = 0;
        }
        (output, fallen)
    }

    /// Collects the tick's data: the arrays cut to the model's size, and the contact. `None` if they are too
    /// short.
    #[inline(always)]
    fn start<'a, 'm>(
        &'a mut self,
        network: &'a Network<'m>,
        sample: &ToolSample,
        is_late: bool,
    ) -> Option<Tick<'a, 'm, D>> {
        let (model, settings, head) = (network.model(), network.settings(), &mut *self.head);
        let (cells, chosen) = (model.cells(), self.contacts.len().min(head.chosen));
        let state = self.state.get_mut(..cells)?;
        let residual = self.residual.get_mut(..cells)?;
        let scheme_arrays = self.own.get_mut(..D::ARRAYS * cells)?;
        let contacts = self.contacts.get_mut(..chosen)?;
        // A drive chosen while the tool is engaged takes effect when it next engages.
        let is_driven = head.engaged && head.level.is_driven();
        let is_load = is_driven || (!head.engaged && settings.drive == Drive::Current);
        let was_engaged = head.engage(sample);
        // Choose what the tool acts on: the surface, a load, or held cells.
        let contact = if IS_BUILT && head.has_tools {
            let (memory, resisted) = (self.touch.reborrow(), &mut head.resisted);
            ToolContact::Tools(Tools { memory, resisted })
        } else if is_load {
            ToolContact::Load(Load { cells: contacts })
        } else {
            ToolContact::Held(Held { cells: contacts, outer_weight: &mut head.outer_weight })
        };
        // Gather what the passes read and write.
        let terms = Terms::of(model, self.states.shared(model.kept_states()));
        let terms = Terms { closed: head.closed, vectors: head.vectors, team: self.team, ..terms };
        let context = Context {
            terms,
            state,
            scheme_arrays,
            coarse_memory: self.room,
            dynamics: &mut head.dynamics,
            level: &mut head.level,
            off_balance: &mut head.off_balance,
            awake: &mut head.awake,
            position_m: sample.position_m.into(),
            origin_m: head.tool_origin_m,
            applied: &mut head.applied,
            touched: &mut head.touched,
            step_max: settings.max_tool_step_m / model.unit_m(),
            was_engaged,
            is_engaged: head.engaged,
            is_late,
            work: TwoFloat::ZERO,
            given: &mut head.given,
            is_clamped: false,
            is_full: false,
        };
        let (deepest, closed, force_n) = (&mut head.deepest, &mut head.closed, &mut head.force_n);
        let released = head.released;
        Some(Tick { network, contact, context, residual, released, deepest, closed, force_n })
    }

    fn safe(&self, network: &Network<'_>, mut flags: Flags) -> TickOutput {
        flags.insert(Flags::SAFE_STATE);
        if self.head.closed {
            flags.insert(Flags::BAND_CLOSED);
        }
        TickOutput {
            energy_j: finite(self.head.level.published() * network.model().energy_unit_j()),
            contacts: if self.head.engaged { self.head.chosen as u32 } else { 0 },
            flags,
            ..TickOutput::NONE
        }
    }
}

impl<D> Head<D> {
    /// Returns the sample to use; `None` after too many bad samples.
    fn accept(&mut self, sample: Option<ToolSample>, flags: &mut Flags) -> Option<ToolSample> {
        if let Some(sample) = sample {
            self.last_good = sample;
            self.bad_ticks = 0;
            return Some(sample);
        }
        flags.insert(Flags::BAD_SAMPLE);
        self.bad_ticks = self.bad_ticks.saturating_add(1);
        if self.bad_ticks == HELD_TICKS_MAX + 1 {
            self.force_n = [0.0; 3];
            log::warn!("tool samples stay bad: safe state");
        }
        (self.bad_ticks <= HELD_TICKS_MAX).then_some(self.last_good)
    }

    /// Notes that the tool engages, which starts its displacement anew, or releases. Returns true if it was
    /// engaged.
    fn engage(&mut self, sample: &ToolSample) -> bool {
        let (was_engaged, is_engaged) = (self.engaged, sample.engaged == 1);
        if is_engaged && !was_engaged {
            self.tool_origin_m = sample.position_m.into();
            self.applied = [0.0; 3];
            // Any depth is deeper: engaging reopens the bands.
            self.deepest = -1.0;
        }
        if is_engaged != was_engaged {
            self.released = !is_engaged;
        }
        self.engaged = is_engaged;
        was_engaged
    }
}

/// Data of the current tick.
struct Tick<'a, 'm, D: Dynamics> {
    network: &'a Network<'m>,
    contact: ToolContact<'a, D>,
    context: Context<'a, 'm, D>,
    residual: &'a mut [Cell<D::Number>],
    // Scalars of the tissue, see [`Head`].
    released: bool,
    deepest: &'a mut f32,
    closed: &'a mut bool,
    force_n: &'a mut [f32; 3],
}

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Applies the terms' corrections for this tick and books their change of the energy.
    #[inline(always)]
    fn correct(&mut self) {
        let (terms, awake) = (self.context.terms, &mut *self.context.awake);
        let mut is_changed = false;
        let rise = terms.begin_tick(self.context.state, |cell| {
            awake.wake_around(terms.model, cell);
            is_changed = true;
        });
        if is_changed {
            *self.context.touched = None;
            self.context.level.shift(rise);
            self.context.dynamics.pushed();
        }
    }

    /// Closes or reopens the bands, see [`unloading`](super::unloading).
    fn unload(&mut self) {
        let depth = sqrt(dot(*self.context.applied, *self.context.applied));
        let rule = self.network.settings().unloading;
        let closed = rule.closes(self.released, depth, *self.deepest, *self.closed);
        if depth > *self.deepest {
            *self.deepest = depth;
        }
        if closed != *self.closed {
            *self.closed = closed;
            self.context.terms.closed = closed;
            self.context.level.forget();
            self.context.dynamics.interrupt();
            self.context.awake.wake_all(self.network.model());
        }
    }

    /// Makes the link passes of the tick, until r . z over their number is `enough`; returns their number.
    // Not inlined: its frame is off the stack while the tools move.
    #[inline(never)]
    fn sweep(&mut self, budget: &mut Budget<'_>, enough: Option<f32>, flags: &mut Flags) -> u16 {
        // Collect all that the scheme reads and writes.
        let &Settings { sweeps, step, tick_time, .. } = self.network.settings();
        let context = &mut self.context;
        let acting = self.contact.acting(context);
        let Acting { contacts, current, touch, .. } = acting;
        let mut body = Body {
            terms: Terms { contacts, current, touch, ..context.terms },
            pace: Pace { sweeps, step, tick_time },
            applied: acting.applied,
            coarse: acting.coarse,
            coarse_touch: acting.coarse_touch,
            state: context.state,
            residual: self.residual,
            own: context.scheme_arrays,
            room: context.coarse_memory,
            awake: context.awake,
            level: context.level,
            off_balance: context.off_balance,
        };
        // Sweep until the settings or the budget end it.
        context.dynamics.begin(&mut body);
        for done in 1..=sweeps {
            if context.dynamics.sweep(&mut body) {
                flags.insert(Flags::ROLLED_BACK);
            }
            let is_enough = D::TELLS_ERROR
                && enough.is_some_and(|enough| {
                    (0.0..=enough * f32::from(done)).contains(body.off_balance)
                });
            if D::IS_ANYTIME && done < sweeps && (is_enough || !budget.goes_on(done)) {
                return done;
            }
        }
        sweeps
    }

    /// Puts parts of the body to sleep. Runs after the sweeps, before anything else can move a cell.
    fn settle(&mut self) {
        let Context { terms, state, scheme_arrays, awake, .. } = &mut self.context;
        let (state, arrays, residual) = (&**state, &**scheme_arrays, &*self.residual);
        awake.settle(terms.model, residual, |cell| D::has_moved(state, arrays, residual, cell));
    }

    /// Computes force and energy after the last update. A late tick repeats the last force while the tool
    /// stays engaged, with the present energy.
    fn output(mut self, mut flags: Flags, sweeps: u16) -> TickOutput {
        let (model, settings) = (self.network.model(), self.network.settings());
        // Compute or repeat the force, and clamp it.
        let (mut tool, mut is_limited) = (ToolOutput::NONE, false);
        if self.context.is_engaged {
            if !self.context.is_late {
                self.contact.book(&mut self.context);
            }
            tool = self.contact.output(&self.context, 0);
            if self.context.is_late {
                tool.force_n = (*self.force_n).into();
            }
            // A repeated force is clamped too: the limit may have changed.
            is_limited = tool.clamp(settings.max_force_n);
        }
        *self.force_n = tool.force_n.into();
        for (flag, is_set) in [
            (Flags::MOTION_CLAMPED, self.context.is_clamped),
            (Flags::FORCE_CLAMPED, is_limited),
            (Flags::BAND_CLOSED, *self.closed),
            (Flags::CONTACT_CAPACITY, self.context.is_full),
            (Flags::LATE, self.context.is_late),
            (Flags::STARTS_INSIDE, self.contact.waits()),
        ] {
            if is_set {
                flags.insert(flag);
            }
        }
        TickOutput {
            force_n: tool.force_n,
            energy_j: finite(self.context.level.published() * model.energy_unit_j()),
            work_j: finite(self.context.work.hi * model.energy_unit_j()),
            stiffness_n_per_m: tool.stiffness_n_per_m,
            contacts: tool.contacts,
            sweeps,
            flags,
        }
    }
}
