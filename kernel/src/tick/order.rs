//! One tick, in the order that the contract fixes: sample, contact, sweeps, outputs. The terms'
//! corrections come before the contact.

use super::pose::ToolPose;
use super::sample::{Flags, TickOutput, ToolSample};
use super::settings::{Network, Settings};
use super::tissue::{Head, TissueMut};
use super::touch_room::TouchRoom;
use crate::backend::team::Team;
use crate::number::cell::Cell;
use crate::number::clamp::finite;
use crate::number::two_float::{Eight, TwoFloat};
use crate::solver::Dynamics;
use crate::solver::coarse::Coarse;
use crate::solver::scheme::{Body, Pace};
use crate::terms::held::Contact;
use crate::terms::residual::Terms;
use crate::terms::state::States;
use crate::terms::surface::{IS_BUILT, Touch};
use crate::terms::term::Term;

/// Bad samples in a row that the last good one stands in for.
pub const HELD_TICKS_MAX: u32 = 10;

impl<D: Dynamics> TissueMut<'_, D> {
    /// One tick of the network: infallible, with [`Settings::sweeps`](crate::Settings::sweeps)
    /// link passes whatever the input, none in the safe state.
    ///
    /// The safe state (force 0, cells as they are) answers a sample that stays bad for more than
    /// [`HELD_TICKS_MAX`] ticks, and a network other than that of the last reset. The arithmetic
    /// of the calling thread must be that which the reset found: IEEE 754 to nearest.
    pub fn tick(&mut self, network: &Network<'_>, sample: &ToolSample) -> TickOutput {
        self.run_sweeps(network, sample, &mut |_| true)
    }

    /// As [`Self::tick`], with its code in the caller: smaller in a program that has one caller and
    /// no other kind of tick, as many with the C interface.
    #[inline(always)]
    pub fn tick_inlined(&mut self, network: &Network<'_>, sample: &ToolSample) -> TickOutput {
        self.run::<false>(network, sample, |_| true)
    }

    /// As [`Self::tick`], but it ends after the first sweep for which `more` says no: `more` is
    /// asked after each sweep but the last, and told how many are done. At least one sweep is made,
    /// at most [`Settings::sweeps`](crate::Settings::sweeps); [`TickOutput::sweeps`] says how many.
    ///
    /// The published state is certified after every sweep of `track` and `predict`.
    /// The sweeps of the other schemes are the tissue's time: there `more` is not asked, see
    /// [`Dynamics::IS_ANYTIME`].
    pub fn tick_while(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        mut more: impl FnMut(u16) -> bool,
    ) -> TickOutput {
        self.run_sweeps(network, sample, &mut more)
    }

    /// A tick without a sweep, for a sample that newer ones have overtaken: the tool moves, by the
    /// step limit and the energy limit as ever, and the level is charged. The answer repeats the
    /// force of the last tick with [`Flags::LATE`], 0 where the tool lets go. Bands stay as they
    /// are until a tick with a sweep. A probe pushes out what it touches and lets go of nothing; it
    /// looks for further cells where it has come an eighth of its radius further since it last did.
    ///
    /// Cost: the links of the contact cells, at most four times; for a probe that looks, one look at
    /// each surface cell besides.
    ///
    /// A scheme that is not [`Dynamics::IS_ANYTIME`] makes all its sweeps. Where the level is not
    /// known (positions were set, or bands changed) there is one sweep.
    pub fn tick_late(&mut self, network: &Network<'_>, sample: &ToolSample) -> TickOutput {
        if !D::IS_ANYTIME {
            return self.tick(network, sample);
        }
        if self.head.level.is_forgotten() {
            return self.tick_while(network, sample, |_| false);
        }
        self.run::<true>(network, sample, |_| false)
    }

    /// The tick that made so many sweeps once: 0 for one that was late, `None` for one with the
    /// settings' count.
    pub fn tick_again(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        sweeps: Option<u16>,
    ) -> TickOutput {
        match sweeps {
            None => self.tick(network, sample),
            Some(0) => self.tick_late(network, sample),
            Some(sweeps) => self.tick_while(network, sample, |done| done < sweeps),
        }
    }

    /// A tick with sweeps while `more` says so: one function for all that have sweeps, so that a
    /// firmware that uses several has the code of one.
    #[inline(never)]
    fn run_sweeps(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        more: &mut dyn FnMut(u16) -> bool,
    ) -> TickOutput {
        self.run::<false>(network, sample, more)
    }

    /// A tick with sweeps while `more` says so, or a late one.
    #[inline(always)]
    fn run<const LATE: bool>(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        more: impl FnMut(u16) -> bool,
    ) -> TickOutput {
        self.run_with::<LATE>(network, sample, None, more)
    }

    /// The same for several tools: one function, whatever the caller.
    #[inline(never)]
    pub(super) fn run_poses<const LATE: bool>(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        poses: Option<&[ToolPose]>,
        more: &mut dyn FnMut(u16) -> bool,
    ) -> TickOutput {
        self.run_with::<LATE>(network, sample, poses, more)
    }

    /// A tick whose tools have these poses; without any the sample is that of the first tool.
    #[inline(always)]
    fn run_with<const LATE: bool>(
        &mut self,
        network: &Network<'_>,
        sample: &ToolSample,
        poses: Option<&[ToolPose]>,
        more: impl FnMut(u16) -> bool,
    ) -> TickOutput {
        let is_good = sample.is_good();
        let mut flags = Flags::default();
        let cells = network.model().cells();
        if self.head.model != Some(network.model().checksum()) {
            return self.safe(network, flags);
        }
        let Some(sample) = self.head.accept(sample, &mut flags) else {
            return self.safe(network, flags);
        };
        let (Some(state), Some(residual), Some(own)) = (
            self.state.get_mut(..cells),
            self.residual.get_mut(..cells),
            self.own.get_mut(..D::ARRAYS * cells),
        ) else {
            return self.safe(network, flags);
        };
        let chosen = self.contacts.len().min(self.head.chosen);
        // A probe finds its cells by itself.
        let is_surface = IS_BUILT && network.model().has_contact_surface();
        let slots = match self.head.probe {
            Some(_) if is_surface => 0,
            Some(_) => self.contacts.len(),
            None => chosen,
        };
        let contacts = self.contacts.get_mut(..slots).unwrap_or(&mut []);
        let (room, states) = (&mut *self.room, self.states.shared(network.model().kept_states()));
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
            flags,
        };
        if !LATE {
            tick.begin_terms();
        }
        tick.hold_or_release(&sample);
        match tick.head.probe {
            _ if !tick.head.engaged => {}
            Some(_) if is_surface => match poses {
                None => tick.press::<LATE>(&[ToolPose::at(sample.position_m, sample.engaged)]),
                Some(poses) if is_good => tick.press::<LATE>(poses),
                // The last good poses stand.
                Some(_) => tick.press::<LATE>(&[]),
            },
            Some(radius) => tick.touch::<LATE>(&sample, radius),
            None => tick.follow(&sample),
        }
        if !LATE {
            tick.unload();
            tick.sweep(more);
            tick.book();
            tick.settle();
        }
        tick.output::<LATE>()
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
    /// The sample to act on; `None` where bad samples have gone on for too long.
    fn accept(&mut self, sample: &ToolSample, flags: &mut Flags) -> Option<ToolSample> {
        if sample.is_good() {
            self.last_good = *sample;
            self.bad_ticks = 0;
            return Some(*sample);
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

/// A tick under way: the arrays cut to the model's size.
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
    /// What the tool's motion did to E.
    pub work: TwoFloat,
    /// Sweeps made.
    pub sweeps: u16,
    pub flags: Flags,
}

impl<'a, 'm, D: Dynamics> Tick<'a, 'm, D> {
    pub fn terms(&self) -> Terms<'a, 'm> {
        let (model, current) = (self.network.model(), self.current());
        let (closed, vectors) = (self.head.closed, self.head.vectors);
        let (team, states, touch) = (self.team, self.states, Touch::NONE);
        Terms { model, closed, vectors, team, current, states, touch }
    }

    /// The corrections of the terms for this tick, and what they do to the energy.
    #[inline(always)]
    fn begin_terms(&mut self) {
        let (terms, awake) = (self.terms(), &mut self.head.awake);
        if !terms.model.others.corrects() {
            return;
        }
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

    /// The bounded number of link passes.
    fn sweep(&mut self, mut more: impl FnMut(u16) -> bool) {
        let current = self.current();
        let contacts: &[Contact<D::Number>] = if self.head.engaged { self.contacts } else { &[] };
        let held = if current.is_none() { contacts } else { &[] };
        // The origins of a probe's contacts are where it has put them.
        let (applied, coarse) = match self.head.probe {
            Some(_) if IS_BUILT && self.network.model().has_contact_surface() => {
                ([0.0; 3], self.head.deflated.map(Coarse::Resisted))
            }
            Some(_) => ([0.0; 3], self.head.deflated.map(Coarse::Deflated)),
            None => (self.head.applied, Some(Coarse::Corrected(held.len()))),
        };
        let &Settings { sweeps, step, tick_time, .. } = self.network.settings();
        let pace = Pace { sweeps, step, tick_time };
        let model = self.network.model();
        let mut arrays = self.touch.arrays(self.state.len());
        let nothing = (Touch::NONE, None);
        let (touch, coarse_touch) = arrays.as_mut().map_or(nothing, |of| of.touching(model));
        let mut body = Body {
            terms: Terms {
                model,
                closed: self.head.closed,
                vectors: self.head.vectors,
                team: self.team,
                current,
                states: self.states,
                touch,
            },
            pace,
            contacts,
            held,
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
        self.head.dynamics.begin(&mut body);
        for done in 1..=sweeps {
            if self.head.dynamics.sweep(&mut body) {
                self.flags.insert(Flags::ROLLED_BACK);
            }
            self.sweeps = done;
            if D::IS_ANYTIME && done < sweeps && !more(done) {
                break;
            }
        }
    }

    /// Puts parts of the body to sleep: behind the sweeps, before anything else can move a cell.
    fn settle(&mut self) {
        let (state, own, residual) = (&*self.state, &*self.own, &*self.residual);
        self.head.awake.settle(self.network.model(), residual, |cell| {
            D::has_moved(state, own, residual, cell)
        });
    }
}
