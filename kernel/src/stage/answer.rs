//! What the device is given: the tissue's answer behind coupling, passivity control, clamp, ramp and slew
//! limit.

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
/// Below this ramp share slew lag is ignored.
const SHARE_MIN: f32 = 0.01;

impl Stage {
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
        if self.engaged && !is_safe {
            // The force of a late answer is an old one: what is given stays.
            if !answer.flags.contains(Flags::LATE) {
                let force = self.before_control(&answer);
                self.asked = self.controlled(&answer, force);
                self.go_on_ramp(&mut answer);
            }
        } else {
            self.asked = Asked::NONE;
            self.ramp.fall();
        }
        (self.begins, self.is_good, self.ticks) = (false, false, 1);
        self.give(&mut answer);
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

    /// The last force, or what the watchdog leaves of it.
    pub(super) fn silent(&mut self, mut answer: TickOutput) -> TickOutput {
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

    /// Clamp, share, slew limit; notes what the device gets, and what of it counts for the
    /// observer: the force before clamp and ramp, and the slew's lag.
    fn give(&mut self, answer: &mut TickOutput) {
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
