//! The device's output: the tissue's answer after coupling, passivity control, clamp, ramp and slew limit.

use nalgebra::Vector3;

use super::controller::Asked;
use super::ramp::on_ramp;
use super::slew::slew_limited;
use super::{Stage, finite, unpaid};
use crate::number::cell::{add, dot, scale, sub};
use crate::number::clamp::clamped;
use crate::stage::controller::Controller;
use crate::tick::sample::{Flags, TickOutput};

/// Raises [`Flags::FORCE_WITHHELD`] above this removed share, in presses that began inside the ramp.
const OFF_SAID: f32 = 0.5;
/// Largest energy of a spring that counts as slack: about that of a micrometre at 2 kN/m \[J\].
const SLACK_J: f32 = 1.0e-9;
/// Below this ramp share slew lag is ignored.
const SHARE_MIN: f32 = 0.01;

impl Stage {
    /// Returns the device's output for the tissue's answer to [`Self::sample`].
    ///
    /// Energy, work, stiffness and contacts are the tissue's. After a late answer ([`Flags::LATE`]) the
    /// device keeps the force that it has. After a bad sample, or without a sample since the last answer, the
    /// force is that of [`Self::missed`], with the tissue's flags.
    pub fn output(&mut self, tissue: &TickOutput) -> TickOutput {
        // A bad answer, or one without the stiffness that the stage needs, takes the force away.
        let (mut answer, is_sound) = finite::checked(tissue);
        (self.energy_j, self.contacts) = (answer.energy_j, answer.contacts);
        let is_known = is_sound && !self.is_blind(&answer);
        let is_safe = !is_known || answer.flags.contains(Flags::SAFE_STATE);
        if is_safe {
            self.asked = Asked::NONE;
            self.ramp.fall();
        }
        // Without a good sample the stage is silent.
        if !self.is_good {
            answer.flags.insert(Flags::BAD_SAMPLE);
            self.observe(&answer);
            return self.silent(answer);
        }
        self.watchdog.hear();
        if self.begins {
            self.ramp.fall();
        }
        // Update the coupling and the energy ledger.
        let force: [f32; 3] = answer.force_n.into();
        self.proxy.feel(
            force,
            answer.stiffness_n_per_m,
            answer.flags.contains(Flags::MOTION_CLAMPED),
        );
        self.observe(&answer);
        if force == [0.0; 3] && self.is_slack() {
            self.delay.release();
        }
        if self.engaged && !is_safe {
            // A late answer's force is old: keep the present one.
            if !answer.flags.contains(Flags::LATE) {
                let force = self.before_control(&answer);
                self.asked = self.controlled(&answer, force);
                self.go_on_ramp(&mut answer);
            }
        } else {
            self.asked = Asked::NONE;
            self.ramp.fall();
        }
        // Apply the limits and mark the safe state.
        (self.begins, self.is_good, self.ticks) = (false, false, 1);
        self.give(&mut answer);
        if is_safe {
            self.mark_safe(&mut answer);
        }
        answer
    }

    /// Returns true if even the stiffest coupling would store no energy.
    fn is_slack(&self) -> bool {
        let stored = |of| self.proxy.stored(of, self.device);
        self.settings.coupling.as_ref().is_none_or(|of| stored(of) <= SLACK_J)
    }

    /// Returns true if coupling or passivity control need a stiffness that the answer does not report: the
    /// tissue is under a current. Cells that are held by position report a stiffness whenever they make a
    /// force.
    fn is_blind(&self, answer: &TickOutput) -> bool {
        let goes_by_position =
            self.settings.coupling.is_some() || self.settings.passivity.is_some();
        let is_stiff = answer.stiffness_n_per_m > 0.0;
        goes_by_position && answer.contacts > 0 && !is_stiff && answer.force_n != Vector3::zeros()
    }

    /// Advances the ramp by a tick. Down if the sampling ledger is at its limit, the delay too long without a
    /// coupling, or the hand owes energy. Hold if the force would return more than the hand put in.
    fn go_on_ramp(&mut self, answer: &mut TickOutput) {
        if self.settings.passivity.is_none() {
            return self.ramp.up();
        }
        // Rate of going down, 0 to 1.
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
        // Up if the hand owes nothing and has energy left for the push.
        if !is_less && !unpaid::waits(&self.observer) {
            if unpaid::is_in_debt(&self.observer) {
                return self.ramp.creep_up();
            }
            if push <= self.observer.reserve_j(&self.delay) {
                return self.ramp.up();
            }
        }
        // Neither: report the withheld force.
        if self.ramp.share() < unpaid::SHARE_SAID {
            answer.flags.insert(Flags::FORCE_WITHHELD);
        }
    }

    /// The last force, or less of it once the watchdog has expired.
    pub(super) fn silent(&mut self, mut answer: TickOutput) -> TickOutput {
        self.ticks = self.ticks.saturating_add(1);
        if self.watchdog.miss(self.settings.watchdog_ticks) {
            self.has_gap = true;
            self.ramp.down();
            answer.flags.insert(Flags::STALE);
        }
        if !self.engaged {
            // The answer to the release may be lost.
            self.asked = Asked::NONE;
            self.ramp.fall();
        }
        self.give(&mut answer);
        if answer.flags.contains(Flags::STALE) || answer.flags.contains(Flags::SAFE_STATE) {
            self.mark_safe(&mut answer);
        }
        answer
    }

    /// Sets [`Flags::SAFE_STATE`] only once the force is 0.
    fn mark_safe(&self, answer: &mut TickOutput) {
        answer.flags.0 &= !Flags::SAFE_STATE.0;
        if self.given == [0.0; 3] {
            answer.flags.insert(Flags::SAFE_STATE);
        }
    }

    /// Books the tool's motion and the energy that the coupling stores.
    fn observe(&mut self, answer: &TickOutput) {
        let Some(passivity) = &self.settings.passivity else { return };
        // Note the phase of the press and the force at the counted position.
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
        // Start the ledger, resume it after missing ticks, or book this tick.
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

    /// Duration of the last motion \[s\].
    fn time_s(&self) -> f32 {
        f32::from(self.took) * self.settings.tick_s
    }

    /// The coupling's force, or without one the tissue's \[N\].
    fn before_control(&self, answer: &TickOutput) -> [f32; 3] {
        match &self.coupling() {
            Some(coupling) => self.proxy.force(coupling, self.time_s(), self.device, self.dx),
            None => answer.force_n.into(),
        }
    }

    /// The force after passivity control.
    fn controlled(&mut self, answer: &TickOutput, force: [f32; 3]) -> Asked {
        if self.settings.passivity.is_none() {
            return Asked::all_of(force);
        }
        let stiffness =
            self.coupling().map_or(answer.stiffness_n_per_m, |coupling| coupling.stiffness_n_per_m);
        let limits = [stiffness, self.most_n()];
        self.controller.control(&self.observer, self.settings.tick_s, &self.delay, limits, force)
    }

    /// Applies clamp, ramp and slew limit. Notes the given force, and for the observer the force before clamp
    /// and ramp with the slew limit's lag.
    fn give(&mut self, answer: &mut TickOutput) {
        // Clamp, and take off the part that the hand has no claim to.
        self.limit.rise(self.settings.max_force_n, self.settings.ramp_ticks);
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
        // Starting from +0.0 turns -0.0 into +0.0.
        let target = on_ramp([0.0; 3], asked, share);
        let most = self.settings.max_slew_n_per_s * self.settings.tick_s;
        let mut given = slew_limited(self.given, target, most);
        // A force that is not finite becomes 0 and the safe state.
        if !given.iter().all(|x| x.is_finite()) {
            (self.asked, given) = (Asked::NONE, [0.0; 3]);
            answer.flags.insert(Flags::SAFE_STATE);
        }
        self.given = given;
        // Note the force for the ledgers.
        if self.settings.passivity.is_some() {
            let mut counts = sub(force, off);
            // At a small ramp share the slew lag is ignored.
            if share > SHARE_MIN {
                counts = add(counts, scale(1.0 / share, sub(given, target)));
            }
            self.observer.give(counts, given);
        }
        answer.force_n = given.into();
    }
}
