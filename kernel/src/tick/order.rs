//! One tick, in the order that the contract fixes: sample, contact, sweeps, outputs. The terms' corrections
//! precede the contact.

use super::budget::Budget;
use super::pose::ToolPose;
use super::sample::{Flags, TickOutput, ToolSample};
use super::settings::{Network, Settings};
use super::tissue::{Head, TissueMut};
use super::touch_room::TouchRoom;
use crate::backend::team::Team;
use crate::energy::contact::Contact;
use crate::energy::residual::Terms;
use crate::energy::state::States;
use crate::energy::surface::{IS_BUILT, Touch};
use crate::number::cell::Cell;
use crate::number::clamp::finite;
use crate::number::two_float::{Eight, TwoFloat};
use crate::solver::Dynamics;
use crate::solver::coarse::Coarse;
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
        // Check network and sample; stop in the safe state if one is unusable.
        let is_late = D::IS_ANYTIME && budget.is_late() && !self.head.level.is_forgotten();
        let sample = self.joined(poses);
        let is_good = sample.is_some();
        let mut flags = Flags::default();
        let cells = network.model().cells();
        if self.head.model != Some(network.model().checksum()) {
            return self.safe(network, flags);
        }
        let Some(sample) = self.head.accept(sample, &mut flags) else {
            return self.safe(network, flags);
        };
        // Cut the arrays to the model's size.
        let (Some(state), Some(residual), Some(own)) = (
            self.state.get_mut(..cells),
            self.residual.get_mut(..cells),
            self.own.get_mut(..D::ARRAYS * cells),
        ) else {
            return self.safe(network, flags);
        };
        let chosen = self.contacts.len().min(self.head.chosen);
        let contacts = self.contacts.get_mut(..chosen).unwrap_or(&mut []);
        let (room, states) = (&mut *self.room, self.states.shared(network.model().kept_states()));
        // Collect the tick's data, then apply the terms' corrections and the tool's contact.
        let mut tick = Tick {
            network,
            head: self.head,
            state,
            residual,
            own,
            room,
            contacts,
            states,
            touch: self.touch.reborrow(),
            team: self.team,
            work: TwoFloat::ZERO,
            sweeps: 0,
            is_late,
            flags,
        };
        if !is_late {
            tick.begin_terms();
        }
        tick.hold_or_release(&sample);
        if tick.head.engaged {
            if IS_BUILT && tick.head.has_tools {
                // After bad poses the last good ones stay in effect.
                tick.press(if is_good { poses } else { &[] });
            } else {
                tick.follow(&sample);
            }
        }
        // Sweep, unless the tick is late.
        if !is_late {
            tick.unload();
            tick.sweep(&mut budget);
            tick.book();
            tick.settle();
        }
        tick.output()
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
}

/// Data of the current tick: the arrays cut to the model's size.
pub(crate) struct Tick<'a, 'm, D: Dynamics> {
    pub network: &'a Network<'m>,
    pub head: &'a mut Head<D>,
    pub state: &'a mut [Cell<D::Number>],
    pub residual: &'a mut [Cell<D::Number>],
    pub own: &'a mut [Cell<D::Number>],
    pub room: &'a mut [Eight],
    pub contacts: &'a mut [Contact<D::Number>],
    pub states: States<'a>,
    pub touch: TouchRoom<'a>,
    pub team: Team<'a>,
    /// Work of the tool's motion on the tissue, the change of E.
    pub work: TwoFloat,
    /// Sweeps made.
    pub sweeps: u16,
    /// True if the tick makes no sweep, see [`Budget::LATE`].
    pub is_late: bool,
    pub flags: Flags,
}

impl<'a, 'm, D: Dynamics> Tick<'a, 'm, D> {
    /// The terms without the tools.
    pub fn terms(&self) -> Terms<'a, 'm, D::Number> {
        let (team, current) = (self.team, self.current());
        let (closed, vectors) = (self.head.closed, self.head.vectors);
        let terms = Terms::of(self.network.model(), self.states);
        Terms { closed, vectors, team, current, ..terms }
    }

    /// Applies the terms' corrections for this tick and books their change of the energy.
    #[inline(always)]
    fn begin_terms(&mut self) {
        let (terms, awake) = (self.terms(), &mut self.head.awake);
        let mut is_changed = false;
        let rise = terms.begin_tick(self.state, |cell| {
            awake.wake_around(terms.model, cell);
            is_changed = true;
        });
        if is_changed {
            self.head.level.shift(rise);
            self.head.dynamics.pushed();
        }
    }

    /// Makes the link passes of the tick.
    fn sweep(&mut self, budget: &mut Budget<'_>) {
        let contacts: &[Contact<D::Number>] = if self.head.engaged { self.contacts } else { &[] };
        let terms = Terms { contacts, ..self.terms() };
        let (applied, coarse) = if IS_BUILT && self.head.has_tools {
            ([0.0; 3], self.head.resisted.map(Coarse::Resisted))
        } else {
            (self.head.applied, Some(Coarse::Corrected(terms.held().len())))
        };
        // Collect all that the scheme reads and writes.
        let &Settings { sweeps, step, tick_time, .. } = self.network.settings();
        let pace = Pace { sweeps, step, tick_time };
        let model = self.network.model();
        let mut arrays = self.touch.arrays(self.state.len());
        let nothing = (Touch::NONE, None);
        let (touch, coarse_touch) = arrays.as_mut().map_or(nothing, |of| of.touching(model));
        let mut body = Body {
            terms: Terms { touch, ..terms },
            pace,
            applied,
            coarse,
            coarse_touch,
            state: self.state,
            residual: self.residual,
            own: self.own,
            room: self.room,
            awake: &mut self.head.awake,
            level: &mut self.head.level,
        };
        // Sweep until the settings or the budget end it.
        self.head.dynamics.begin(&mut body);
        for done in 1..=sweeps {
            if self.head.dynamics.sweep(&mut body) {
                self.flags.insert(Flags::ROLLED_BACK);
            }
            self.sweeps = done;
            if D::IS_ANYTIME && done < sweeps && !budget.goes_on(done) {
                break;
            }
        }
    }

    /// Puts parts of the body to sleep. Runs after the sweeps, before anything else can move a cell.
    fn settle(&mut self) {
        let (state, own, residual) = (&*self.state, &*self.own, &*self.residual);
        self.head.awake.settle(self.network.model(), residual, |cell| {
            D::has_moved(state, own, residual, cell)
        });
    }
}
