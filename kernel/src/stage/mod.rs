//! The output stage: what stands between a tissue's answer and a hand.
//!
//! Optional stages in a fixed order, one file each; an absent one is a branch:
//!
//! 1. finite check: a bad sample is no sample, a bad answer is no force (always there); a pose that no
//!    hand can have reached since the last one is a bad sample too (`max_speed_m_per_s`);
//! 2. virtual coupling: the tool is a proxy on a spring;
//! 3. passivity observer and controller, on what the hand pays and is given;
//! 4. magnitude clamp;
//! 5. ramp after engaging and after a silence;
//! 6. watchdog: without samples the last force holds for a while, then falls;
//! 7. slew limit.
//!
//! The slew limit is the last, so that it bounds the step between any two forces that the device is
//! given, whatever happens: also on release, on a bad answer and in a silence, where the force goes
//! to zero by steps of that size. Without a slew limit it goes there at once.
//!
//! A firmware that does not use the stage links none of it.
//!
//! | part | field of [`StageSettings`] | what it is for |
//! |---|---|---|
//! | coupling | `coupling` | the device never feels more stiffness than it can show |
//! | passivity | `passivity` | takes out the energy that sampling and holding make |
//! | reach | `max_speed_m_per_s` | a pose that is wrong, though finite, makes no force |
//! | clamp | `max_force_n` | no force above the device's largest; the direction stays |
//! | ramp | `ramp_ticks` | the force rises from 0 after engaging and after a silence |
//! | watchdog | `watchdog_ticks` | without samples the force falls to 0 |
//! | slew limit | `max_slew_n_per_s` | largest change of the force from tick to tick |
//!
//! [`StageSettings::for_device`] sets all of them for the Touch, Premium, Falcon, omega and
//! sigma.7; [`StageSettings::NONE`] sets none. The stage is a function of the samples and answers
//! alone, so a recorded session replays to the same forces. It works with held cells and with a
//! probe. Under a current the tissue tells no stiffness: a stage with coupling or passivity control
//! gives no force there, in the safe state.
//!
//! **What it does not do.** Passivity is tested in closed loop with models of five handles and of
//! soft and stiff hands (`tests/README.md`), not proven. Known, on models with links of 5000 N/m
//! and more:
//!
//! - In a soft hand on stiff tissue the force hums by up to two counts of the encoder, 0.02 to
//!   0.08 N. A handle of 50 g in a loose hand hums with couplings above 1000 N/m.
//! - A press begun within the ramp, or a tool that engages inside the tissue, gives the hand up to 3 and
//!   8 mJ that it did not put in. Then the force is let go (flag 1024), and comes back as slowly as
//!   0.2 mW allow: in a stiff hand on stiff links within half a minute. Outside of the tissue it is
//!   forgotten within a second or two.
//! - A force at the clamp takes the 10 ms of the slew limit to go.
//! - Without a coupling, on a contact of 10 kN/m and more, the controller cannot make up for the
//!   delay. With a ramp the force is let go (flag 1024) and comes back, again and again: keep the
//!   coupling.
//! - A hand that lets go deep in the tissue gets back what it put in.
//! - With [`Passivity::delay_ticks`] of 2 and more the coupling is a soft spring ([`passive_stiffness_n_per_m`]).
//! - Where the tissue lets a tool go no deeper (flag 1), the hand feels the coupling's spring alone.
//!
//! A firmware's tick:
//!
//! ```
//! use chaincell_kernel::stage::{Device, Stage, StageSettings};
//! use chaincell_kernel::{TickOutput, ToolSample};
//! use nalgebra::Vector3;
//!
//! let mut stage = Stage::new(StageSettings::for_device(Device::Falcon))?;
//! let mut tick = |sample: Option<ToolSample>| match sample {
//!     Some(sample) => {
//!         let tool = stage.sample(&sample);
//!         let answer = TickOutput::NONE; // tissue.tick(&network, &tool)
//!         # let _ = tool;
//!         stage.output(&answer)
//!     }
//!     None => stage.missed(),
//! };
//! let sample = ToolSample { position_m: Vector3::zeros(), engaged: 1 };
//! assert_eq!(tick(Some(sample)).force_n + tick(None).force_n, Vector3::zeros());
//! # Ok::<(), chaincell_kernel::stage::StageError>(())
//! ```

mod controller;
mod coupling;
mod delay;
mod finite;
mod observer;
mod ramp;
mod reach;
mod settings;
mod slew;
#[cfg(test)]
mod tests;
mod unpaid;
mod watchdog;

pub use delay::{DELAY_TICKS_MAX, passive_stiffness_n_per_m};
pub use ramp::{on_ramp, ramp_share};
pub use reach::{Pose, Reach};
pub use settings::{
    COUPLING_MAX, COUPLING_MIN, Coupling, DELAY_MAX, Device, HAND_SPEED_MAX_M_PER_S, Passivity,
    StageError, StageSettings, TICK_S, TICKS_MAX,
};
pub use slew::slew_limited;

use crate::number::cell::{add, dot, scale, sub};
use crate::number::clamp::{clamped, finite as finite_number};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::tick::sample::{Flags, TickOutput, ToolSample};
use controller::{Asked, Controller};
use coupling::Proxy;
use delay::Delay;
use nalgebra::Vector3;
use observer::Observer;
use ramp::Ramp;
use watchdog::Watchdog;

/// Share of the force from which on it is said that so much is taken off, in a press that began within
/// the ramp.
const OFF_SAID: f32 = 0.5;
/// Share of the ramp from which on the slew limit's doing is told from the ramp's.
const SHARE_MIN: f32 = 0.01;

/// The output stage of one device: [`Self::sample`], the tissue's tick, [`Self::output`]; or
/// [`Self::missed`] alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    settings: StageSettings,
    /// The tissue's own limit, see [`Self::limit_force`], and what of a raised one is in force \[N\].
    limit_to_n: f32,
    limit_n: f32,
    proxy: Proxy,
    observer: Observer,
    controller: Controller,
    delay: Delay,
    ramp: Ramp,
    watchdog: Watchdog,
    reach: Reach,
    /// The device's last good position and its last motion \[m\].
    device: [f32; 3],
    dx: [f32; 3],
    /// Whether the tool is engaged, as of the last good sample, and in this tick for the first
    /// time.
    engaged: bool,
    begins: bool,
    /// Whether a good sample waits for its answer.
    is_good: bool,
    /// Whether ticks are missing in the ledger.
    has_gap: bool,
    /// Whether the tool has not been out of the tissue since the ramp was at its foot.
    is_early: bool,
    /// Ticks since the last good sample, and those that its motion took.
    ticks: u16,
    took: u16,
    /// The force before ramp and limits, and the last one given \[N\].
    asked: Asked,
    given: [f32; 3],
    /// What the tissue last said.
    energy_j: f32,
    contacts: u32,
}

kept!(Stage {
    proxy: Proxy,
    observer: Observer,
    controller: Controller,
    delay: Delay,
    ramp: Ramp,
    watchdog: Watchdog,
    reach: Reach,
    device: [f32; 3],
    dx: [f32; 3],
    engaged: bool,
    begins: bool,
    is_good: bool,
    has_gap: bool,
    is_early: bool,
    ticks: u16,
    took: u16,
    asked: Asked,
    given: [f32; 3],
    energy_j: f32,
    contacts: u32,
    limit_n: f32,
} but settings: StageSettings::NONE, limit_to_n: f32::INFINITY);

impl Stage {
    /// A stage at rest.
    ///
    /// # Errors
    /// The first setting that is out of range.
    pub fn new(settings: StageSettings) -> Result<Self, StageError> {
        settings.check()?;
        Ok(Self {
            settings,
            limit_to_n: f32::INFINITY,
            limit_n: f32::INFINITY,
            proxy: Proxy::NEW,
            observer: Observer::NEW,
            controller: Controller::NEW,
            delay: Delay::new(settings.passivity.map_or(0, |of| of.delay_ticks)),
            ramp: Ramp::new(settings.ramp_ticks),
            watchdog: Watchdog::NEW,
            reach: Reach::NEW,
            device: [0.0; 3],
            dx: [0.0; 3],
            engaged: false,
            begins: false,
            is_good: false,
            has_gap: false,
            is_early: false,
            ticks: 1,
            took: 1,
            asked: Asked::NONE,
            given: [0.0; 3],
            energy_j: 0.0,
            contacts: 0,
        })
    }

    /// Goes on as another stage stood, within the limits of this one.
    pub(crate) fn go_on_as(&mut self, other: Self) {
        let most = self.settings.max_force_n;
        let is_within = sqrt(dot(other.given, other.given)) <= finite_number(most);
        let given = if is_within { other.given } else { clamped(other.given, most).0 };
        let energy_j = finite_number(other.energy_j);
        let (settings, limit_to_n) = (self.settings, self.limit_to_n);
        let ramp = self.ramp.along(other.ramp);
        *self = Self { settings, limit_to_n, ramp, given, energy_j, ..other };
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &StageSettings {
        &self.settings
    }

    /// An answer takes so many ticks from its sample to the device's pushing with it, as it was
    /// measured: counts above [`DELAY_TICKS_MAX`] are taken as that. Called before [`Self::sample`]. What is shown
    /// follows the mean of the last 256 or so.
    pub fn delayed(&mut self, ticks: u16) {
        self.delay.hear(ticks.min(DELAY_TICKS_MAX).into());
    }

    /// The coupling in force: that of the settings, or what the delay admits of it.
    #[must_use]
    pub fn coupling(&self) -> Option<Coupling> {
        let of = self.settings.coupling.as_ref()?;
        let Some(passivity) = &self.settings.passivity else { return Some(*of) };
        Some(self.delay.admits(of, passivity.device_damping_n_s_per_m, self.settings.tick_s))
    }

    /// The ramp's share of the force, 0 to 1: for a torque that belongs to it.
    #[must_use]
    pub fn share(&self) -> f32 {
        self.ramp.share()
    }

    /// What the tissue is given for what the device has measured: the tool behind the coupling.
    ///
    /// A sample that is bad here (not good, or a coordinate beyond 1 km) is bad for the tissue too.
    pub fn sample(&mut self, device: &ToolSample) -> ToolSample {
        // The answer to the last one has not come.
        self.has_gap |= self.is_good;
        self.is_good = finite::is_good(device);
        if !self.is_good {
            return finite::made_bad(device);
        }
        let position: [f32; 3] = device.position_m.into();
        let reach_m = self.settings.max_speed_m_per_s * self.settings.tick_s;
        let ticks = f32::from(self.ticks.max(1));
        let pose = self.reach.judge(position, device.engaged == 1, reach_m, ticks);
        self.is_good = pose != Pose::Bad;
        if !self.is_good {
            return finite::made_bad(device);
        }
        let engaged = device.engaged == 1 && pose != Pose::Elsewhere;
        if pose == Pose::Unseen {
            self.has_gap = true;
            self.ramp.fall();
            self.observer.lost_sight();
        }
        // Until an answer has come: the first one may get lost.
        self.begins = engaged && (self.begins || !self.engaged);
        self.engaged = engaged;
        self.dx = if self.begins { [0.0; 3] } else { sub(position, self.device) };
        self.device = position;
        (self.took, self.ticks) = (self.ticks.max(1), 0);
        if self.settings.passivity.is_some() {
            self.observer.see(position, self.took);
        }
        let held = engaged.into();
        let Some(coupling) = &self.coupling() else {
            return ToolSample { engaged: held, ..*device };
        };
        if engaged && !self.begins {
            // As if no tick were missing: where the tissue is does not depend on silences.
            self.proxy.step(coupling, self.settings.tick_s, position, self.dx);
        } else {
            self.proxy.follow(position);
        }
        ToolSample { position_m: self.proxy.at().into(), engaged: held }
    }

    /// So many samples in front of the next one got lost: the hand has had the time of them too. Called
    /// before [`Self::sample`].
    pub fn skipped(&mut self, ticks: u16) {
        self.ticks = self.ticks.max(1).saturating_add(ticks);
    }

    /// No force is above this from here on, besides the device's largest: for
    /// [`Settings::max_force_n`](crate::Settings::max_force_n), which shortens the tissue's force alone
    /// while a coupling shows its own. A lower one holds at once, within the slew limit; up to a higher one
    /// the force may grow by the device's largest within [`StageSettings::ramp_ticks`] \[N\].
    pub fn limit_force(&mut self, max_force_n: f32) {
        self.limit_to_n = max_force_n;
        if max_force_n < self.limit_n || max_force_n.is_nan() {
            self.limit_n = max_force_n;
        }
    }

    /// A step of a raised limit.
    fn raise_limit(&mut self) {
        let most = self.settings.max_force_n;
        let raised = self.limit_n + most / f32::from(self.settings.ramp_ticks.max(1));
        let is_there = raised >= self.limit_to_n || raised >= most;
        self.limit_n = if is_there { self.limit_to_n } else { raised };
    }

    /// The largest force \[N\].
    fn most_n(&self) -> f32 {
        let most = self.settings.max_force_n;
        if self.limit_n < most { self.limit_n } else { most }
    }

    /// What the device is given for what the tissue has answered to [`Self::sample`].
    ///
    /// Energy, work, stiffness and contacts are the tissue's. To a late answer
    /// ([`Flags::LATE`]) the device is given the force that it has. After a bad sample, and without one
    /// since the last answer, it is that of [`Self::missed`], with the tissue's flags.
    pub fn output(&mut self, tissue: &TickOutput) -> TickOutput {
        let (mut answer, is_sound) = finite::checked(tissue);
        (self.energy_j, self.contacts) = (answer.energy_j, answer.contacts);
        let is_known = is_sound && !self.is_blind(&answer);
        let is_safe = !is_known || answer.flags.contains(Flags::SAFE_STATE);
        if is_safe {
            self.asked = Asked::NONE;
            self.ramp.fall();
        }
        if !self.is_good {
            answer.flags.insert(Flags::BAD_SAMPLE);
            self.observe(&answer);
            return self.silent(answer);
        }
        self.watchdog.hear();
        if self.begins {
            self.ramp.fall();
        }
        let force: [f32; 3] = answer.force_n.into();
        self.proxy.feel(
            force,
            answer.stiffness_n_per_m,
            answer.flags.contains(Flags::MOTION_CLAMPED),
        );
        self.observe(&answer);
        let mut whole = None;
        if self.engaged && !is_safe {
            // The force of a late answer is an old one: what is given stays.
            if !answer.flags.contains(Flags::LATE) {
                let force = self.before_control(&answer);
                self.asked = self.controlled(&answer, force);
                whole = Some(force);
                self.go_on_ramp(&mut answer);
            }
        } else {
            self.asked = Asked::NONE;
            self.ramp.fall();
        }
        (self.begins, self.is_good, self.ticks) = (false, false, 1);
        let before = self.given;
        self.give(&mut answer);
        if whole.is_some_and(|whole| self.takes_most_of(whole, before)) {
            answer.flags.insert(Flags::FORCE_WITHHELD);
        }
        if is_safe {
            self.mark_safe(&mut answer);
        }
        answer
    }

    /// Whether the tissue is under a current: coupling and passivity control go by a stiffness that it
    /// does not tell. Cells that are held by position have a stiffness wherever they make a force.
    fn is_blind(&self, answer: &TickOutput) -> bool {
        let goes_by_position =
            self.settings.coupling.is_some() || self.settings.passivity.is_some();
        let is_stiff = answer.stiffness_n_per_m > 0.0;
        goes_by_position && answer.contacts > 0 && !is_stiff && answer.force_n != Vector3::zeros()
    }

    /// A step of the ramp: down where L is overdrawn, the delay too long for a stage without a coupling,
    /// or the hand has not paid; none where the hand would get more than it has put in.
    fn go_on_ramp(&mut self, answer: &mut TickOutput) {
        if self.settings.passivity.is_none() {
            return self.ramp.up();
        }
        let push = dot(self.asked.force, self.observer.rate());
        let cannot_hold = if self.delay.is_long() {
            self.settings.coupling.is_none()
        } else {
            self.observer.is_overdrawn()
        };
        let most_n = self.settings.max_slew_n_per_s * self.settings.tick_s;
        let ledger = (&self.observer, &self.delay);
        let unpaid = unpaid::goes_down(ledger, self.is_early, (self.given, most_n));
        let fast = if cannot_hold && unpaid < 0.5 { 0.5 } else { unpaid };
        let is_less = fast > 0.0 && self.ramp.back_off(fast);
        if !is_less && !unpaid::waits(&self.observer) {
            if unpaid::is_in_debt(&self.observer) {
                return self.ramp.creep_up();
            }
            if push <= self.observer.reserve_j(&self.delay) {
                return self.ramp.up();
            }
        }
        if self.ramp.share() < unpaid::SHARE_SAID {
            answer.flags.insert(Flags::FORCE_WITHHELD);
        }
    }

    /// The device did not feel what was computed: the process around let its force fall, or gave none.
    /// The ledger books no force for it, the ramp begins anew, and the next pose is taken wherever it is.
    /// Called before [`Self::sample`].
    pub fn restart_ramp(&mut self) {
        self.has_gap = true;
        self.ramp.fall();
        self.reach.forget();
        (self.asked, self.given) = (Asked::NONE, [0.0; 3]);
        self.observer.felt_nothing();
    }

    /// What the device is given in a tick without a sample; the tissue has no tick then. Flags
    /// [`Flags::STALE`] once the watchdog lets the force fall, [`Flags::SAFE_STATE`] once it is 0.
    pub fn missed(&mut self) -> TickOutput {
        // The answer to the last sample has not come; one that comes late is no longer on time.
        self.has_gap |= self.is_good;
        let (energy_j, contacts) = (self.energy_j, self.contacts);
        self.silent(TickOutput { energy_j, contacts, ..TickOutput::NONE })
    }

    /// The last force, or what the watchdog leaves of it.
    fn silent(&mut self, mut answer: TickOutput) -> TickOutput {
        self.ticks = self.ticks.saturating_add(1);
        if self.watchdog.miss(self.settings.watchdog_ticks) {
            self.has_gap = true;
            self.ramp.down();
            answer.flags.insert(Flags::STALE);
        }
        if !self.engaged {
            // The answer to its release may have got lost.
            self.asked = Asked::NONE;
            self.ramp.fall();
        }
        self.give(&mut answer);
        if answer.flags.contains(Flags::STALE) || answer.flags.contains(Flags::SAFE_STATE) {
            self.mark_safe(&mut answer);
        }
        answer
    }

    /// The safe state is there once the force is.
    fn mark_safe(&self, answer: &mut TickOutput) {
        answer.flags.0 &= !Flags::SAFE_STATE.0;
        if self.given == [0.0; 3] {
            answer.flags.insert(Flags::SAFE_STATE);
        }
    }

    /// Books what the tool has done and what the coupling stores.
    fn observe(&mut self, answer: &TickOutput) {
        let Some(passivity) = &self.settings.passivity else { return };
        let is_free = self.ramp.share() == 1.0 && answer.force_n == Vector3::zeros();
        self.is_early = self.ramp.share() == 0.0 || (self.is_early && !is_free);
        let at = self.observer.at();
        let (shown, stored) = match &self.coupling() {
            Some(coupling) => {
                let spring = scale(coupling.stiffness_n_per_m, sub(self.proxy.at(), at));
                (spring, self.proxy.stored(coupling, at))
            }
            None => (answer.force_n.into(), 0.0),
        };
        if self.begins && self.is_good {
            self.controller = Controller::NEW;
            self.observer.begin(shown);
        } else if self.has_gap && self.is_good {
            self.controller = Controller::NEW;
            self.observer.resume(shown);
        } else if self.engaged {
            let times = (self.settings.tick_s, &self.delay);
            self.observer.book(passivity, times, shown, (answer.energy_j + stored, self.is_early));
        }
        self.has_gap &= !self.is_good;
    }

    /// Time of the last motion \[s\].
    fn time_s(&self) -> f32 {
        f32::from(self.took) * self.settings.tick_s
    }

    /// The force that the coupling shows, or the tissue's \[N\].
    fn before_control(&self, answer: &TickOutput) -> [f32; 3] {
        match &self.coupling() {
            Some(coupling) => self.proxy.force(coupling, self.time_s(), self.device, self.dx),
            None => answer.force_n.into(),
        }
    }

    /// What passivity control leaves of a force.
    fn controlled(&mut self, answer: &TickOutput, force: [f32; 3]) -> Asked {
        if self.settings.passivity.is_none() {
            return Asked::all_of(force);
        }
        let stiffness =
            self.coupling().map_or(answer.stiffness_n_per_m, |coupling| coupling.stiffness_n_per_m);
        let limits = [stiffness, self.most_n()];
        self.controller.control(&self.observer, self.settings.tick_s, &self.delay, limits, force)
    }

    /// Whether passivity control has taken off more than half of a force, and more than half of the one
    /// before is gone, by more than half of what the slew limit admits.
    fn takes_most_of(&self, whole: [f32; 3], before: [f32; 3]) -> bool {
        if self.settings.passivity.is_none() {
            return false;
        }
        let (whole, _) = clamped(whole, self.most_n());
        let taken = sub(whole, sub(self.asked.force, self.asked.off));
        let step = sub(self.given, before);
        let slew = self.settings.max_slew_n_per_s * self.settings.tick_s;
        let is_most = 4.0 * dot(taken, taken) > dot(whole, whole);
        let is_gone = 4.0 * dot(self.given, self.given) < dot(before, before);
        let is_fast = 4.0 * dot(step, step) > slew * slew || slew == f32::INFINITY;
        is_most && is_gone && is_fast
    }

    /// Clamp, share, slew limit; notes what the device gets, and what of it counts for the
    /// observer: the force before clamp and ramp, and the slew's lag.
    fn give(&mut self, answer: &mut TickOutput) {
        self.raise_limit();
        let share = self.ramp.share();
        let Asked { force, off } = self.asked;
        let (asked, is_clamped) = clamped(force, self.most_n());
        if is_clamped {
            answer.flags.insert(Flags::FORCE_CLAMPED);
        }
        if self.is_early && dot(off, off) > OFF_SAID * OFF_SAID * dot(asked, asked) {
            answer.flags.insert(Flags::FORCE_WITHHELD);
        }
        let (asked, _) = clamped(sub(asked, off), self.most_n());
        // From +0.0: -0.0 becomes +0.0.
        let target = on_ramp([0.0; 3], asked, share);
        let most = self.settings.max_slew_n_per_s * self.settings.tick_s;
        let mut given = slew_limited(self.given, target, most);
        if !given.iter().all(|x| x.is_finite()) {
            (self.asked, given) = (Asked::NONE, [0.0; 3]);
            answer.flags.insert(Flags::SAFE_STATE);
        }
        self.given = given;
        if self.settings.passivity.is_some() {
            let mut counts = sub(force, off);
            // Where next to nothing is given there is nothing to tell.
            if share > SHARE_MIN {
                counts = add(counts, scale(1.0 / share, sub(given, target)));
            }
            self.observer.give(counts, given);
        }
        answer.force_n = given.into();
    }
}
