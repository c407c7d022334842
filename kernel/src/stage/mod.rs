//! The output stage: processes the tissue's force before a haptic device shows it to a hand.
//!
//! The parts are optional and run in a fixed order, one file each; a part that is absent costs a branch:
//!
//! 1. finite check, always present: a bad sample counts as no sample, a bad answer as no force. A pose that
//!    no hand can reach from the last one is a bad sample too (`max_speed_m_per_s`);
//! 2. virtual coupling: the tool in the tissue is a proxy on a spring;
//! 3. passivity observer and controller: they compare the energy from the hand with the energy to it;
//! 4. magnitude clamp;
//! 5. ramp after engaging and after a silence;
//! 6. watchdog: without samples the last force holds for a while, then falls;
//! 7. slew limit.
//!
//! The slew limit comes last, so it bounds the step between any two forces that the device receives: also on
//! release, on a bad answer and in a silence, where the force goes to zero in steps of that size. Without a
//! slew limit the force goes to zero at once.
//!
//! A firmware that does not use the stage links none of it.
//!
//! | part | field of [`StageSettings`] | purpose |
//! |---|---|---|
//! | coupling | `coupling` | the device never shows more stiffness than it can |
//! | passivity | `passivity` | removes the energy that sampling and holding generate |
//! | reach | `max_speed_m_per_s` | a finite but wrong pose makes no force |
//! | clamp | `max_force_n` | no force above the device's largest; the direction stays |
//! | ramp | `ramp_ticks` | the force rises from 0 after engaging and after a silence |
//! | watchdog | `watchdog_ticks` | without samples the force falls to 0 |
//! | slew limit | `max_slew_n_per_s` | largest change of the force from tick to tick |
//!
//! [`StageSettings::for_device`] sets all of them for the Touch, Premium, Falcon, omega and sigma.7;
//! [`StageSettings::NONE`] sets none. The stage depends on samples and answers alone, so a recorded session
//! replays to the same forces. It works with held cells and with tools. Under a current the tissue reports
//! no stiffness: there a stage with coupling or passivity control gives no force and is in the safe state.
//!
//! **Limits.** Passivity is tested in closed loop with models of five handles and of soft and stiff hands
//! (`tests/MEASURED.md`), not proven. Known on models with links of 5000 N/m and more:
//!
//! - In a soft hand on stiff tissue the force hums by up to two encoder counts, 0.02 to 0.08 N. A handle of
//!   50 g in a loose hand hums with couplings above 1000 N/m.
//! - A press that begins during the ramp returns up to 3 mJ more than the hand put in; a tool that engages
//!   inside the tissue up to 8 mJ. Then the force is withheld (flag 1024) and returns as slowly as 0.2 mW
//!   allow: in a stiff hand on stiff links within half a minute. Outside the tissue the debt fades within a
//!   second or two.
//! - A force at the clamp takes the 10 ms of the slew limit to fall to zero.
//! - Without a coupling, on a contact of 10 kN/m and more, the controller cannot compensate the delay. With a
//!   ramp the force is withheld (flag 1024) and returns, again and again: keep the coupling.
//! - A hand that lets go deep in the tissue gets back the energy that it put in.
//! - With [`Passivity::delay_ticks`] of 2 and more the coupling is a soft spring
//!   ([`passive_stiffness_n_per_m`]).
//! - Where the tissue cuts the tool's motion short (flag 1), the hand feels only the coupling's spring.
//!
//! A firmware's tick:
//!
//! ```
//! use chaincell_kernel::stage::{Device, Stage, StageSettings};
//! use chaincell_kernel::{TickOutput, ToolPose};
//! use nalgebra::Vector3;
//!
//! let mut stage = Stage::new(StageSettings::for_device(Device::Falcon))?;
//! let mut tick = |sample: Option<ToolPose>| match sample {
//!     Some(sample) => {
//!         let tool = stage.sample(&sample);
//!         let answer = TickOutput::NONE; // tissue.tick(&network, &[tool], Budget::All)
//!         # let _ = tool;
//!         stage.output(&answer)
//!     }
//!     None => stage.missed(),
//! };
//! let sample = ToolPose::at(Vector3::zeros(), 1);
//! assert_eq!(tick(Some(sample)).force_n + tick(None).force_n, Vector3::zeros());
//! # Ok::<(), chaincell_kernel::stage::StageError>(())
//! ```

mod answer;
mod controller;
mod coupling;
mod delay;
mod device;
mod finite;
mod limit;
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
pub use device::Device;
pub use ramp::{on_ramp, ramp_share};
pub use reach::{Pose, Reach};
pub use settings::{
    COUPLING_MAX, COUPLING_MIN, Coupling, DELAY_MAX, HAND_SPEED_MAX_M_PER_S, Passivity,
    PlainStageSettings, StageError, StageSettings, TICK_S, TICKS_MAX,
};
pub use slew::slew_limited;

use crate::contact::pose::ToolPose;
use crate::number::cell::{dot, sub};
use crate::number::clamp::{clamped, finite as finite_number};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::tick::sample::TickOutput;
use controller::{Asked, Controller};
use coupling::Proxy;
use delay::Delay;
use limit::Limit;
use observer::Observer;
use ramp::Ramp;
use watchdog::Watchdog;

kept! {
    /// The output stage of one device. Each tick calls [`Self::sample`], the tissue's tick and [`Self::output`],
    /// or [`Self::missed`] alone.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Stage {
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
        /// `engaged`: the tool is engaged, as of the last good sample. `begins`: it engaged with this sample, or
        /// no answer has come since it did.
        engaged: bool,
        begins: bool,
        /// True while a good sample has no answer yet.
        is_good: bool,
        /// True if ticks are missing in the energy ledger.
        has_gap: bool,
        /// True from the foot of the ramp until the tool is out of contact at the full ramp.
        is_early: bool,
        /// Ticks since the last good sample, and ticks that its motion took.
        ticks: u16,
        took: u16,
        /// The force before ramp and limits, and the last force that the device received \[N\].
        asked: Asked,
        given: [f32; 3],
        /// Energy and contacts in the tissue's last answer.
        energy_j: f32,
        contacts: u32,
        /// The tissue's force limit, see [`Self::limit_force`].
        limit: Limit,
    } not stored {
        settings: StageSettings = StageSettings::NONE,
    }
}

impl Stage {
    /// A stage at rest.
    ///
    /// # Errors
    /// The first setting that is out of range.
    pub fn new(settings: StageSettings) -> Result<Self, StageError> {
        settings.check()?;
        Ok(Self {
            settings,
            limit: Limit::NONE,
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

    /// Takes over `other`'s state, clamped to this stage's limits.
    pub(crate) fn go_on_as(&mut self, other: Self) {
        let most = self.settings.max_force_n;
        let is_within = sqrt(dot(other.given, other.given)) <= finite_number(most);
        let given = if is_within { other.given } else { clamped(other.given, most).0 };
        let energy_j = finite_number(other.energy_j);
        let (settings, ramp) = (self.settings, self.ramp.along(other.ramp));
        *self = Self { settings, ramp, given, energy_j, ..other };
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &StageSettings {
        &self.settings
    }

    /// Reports a measured delay: the ticks from a sample until the device applies the force computed for it,
    /// clamped to [`DELAY_TICKS_MAX`]. Call it before [`Self::sample`]. The stage uses a running mean over
    /// about 256 ticks. A longer one softens the coupling at once, a shorter one stiffens it out of contact alone.
    pub fn delayed(&mut self, ticks: u16) {
        self.delay.hear(ticks.min(DELAY_TICKS_MAX).into());
    }

    /// The coupling in use: that of the settings, softened if the delay requires it.
    #[must_use]
    pub fn coupling(&self) -> Option<Coupling> {
        let of = self.settings.coupling.as_ref()?;
        let Some(passivity) = &self.settings.passivity else { return Some(*of) };
        Some(self.delay.admits(of, passivity.device_damping_n_s_per_m, self.settings.tick_s))
    }

    /// The ramp's share of the force, 0 to 1. Scale a torque that belongs to the force by it.
    #[must_use]
    pub fn share(&self) -> f32 {
        self.ramp.share()
    }

    /// Returns the tool pose for the tissue, the proxy of the coupling, from the device's pose.
    ///
    /// A sample that is bad here (not good, or a coordinate beyond 1 km) is bad for the tissue too.
    pub fn sample(&mut self, device: &ToolPose) -> ToolPose {
        // The last sample got no answer.
        self.has_gap |= self.is_good;
        self.is_good = finite::is_good(device);
        if !self.is_good {
            return finite::made_bad(device);
        }
        // Reject a pose out of reach of a hand; a device that is elsewhere counts as released.
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
        // Stays set until an answer comes: the first one may be lost.
        // Note the motion, for the ledger and the coupling.
        self.begins = engaged && (self.begins || !self.engaged);
        self.engaged = engaged;
        self.dx = if self.begins { [0.0; 3] } else { sub(position, self.device) };
        self.device = position;
        (self.took, self.ticks) = (self.ticks.max(1), 0);
        if self.settings.passivity.is_some() {
            self.observer.see(position, self.took);
        }
        // Step the proxy, or put it at the device when the tool is not engaged.
        let held = engaged.into();
        let Some(coupling) = &self.coupling() else {
            return ToolPose { engaged: held, ..*device };
        };
        if engaged && !self.begins {
            // Steps as if no tick were missing: the tissue's position does not depend on silences.
            self.proxy.step(coupling, self.settings.tick_s, position, self.dx);
        } else {
            self.proxy.follow(position);
        }
        ToolPose { position_m: self.proxy.at().into(), engaged: held, ..*device }
    }

    /// Reports that `ticks` samples before the next one were lost, so the hand had that much more time to
    /// move. Call it before [`Self::sample`].
    pub fn skipped(&mut self, ticks: u16) {
        self.ticks = self.ticks.max(1).saturating_add(ticks);
    }

    /// Limits the force from now on, in addition to the device's largest force. It serves
    /// [`Settings::max_force_n`](crate::Settings::max_force_n), which limits only the tissue's force, not the
    /// coupling's. A lower limit holds at once, within the slew limit; towards a higher one the limit rises
    /// by the device's largest force per [`StageSettings::ramp_ticks`] \[N\].
    pub fn limit_force(&mut self, max_force_n: f32) {
        self.limit.set(max_force_n);
    }

    /// The largest force now \[N\].
    fn most_n(&self) -> f32 {
        self.limit.of(self.settings.max_force_n)
    }

    /// Reports that the device did not apply the computed force, because the calling process lowered it or
    /// gave none. The ledger books no force for it, the ramp starts anew, and the next pose is accepted at
    /// any place. Call it before [`Self::sample`].
    pub fn restart_ramp(&mut self) {
        self.has_gap = true;
        self.ramp.fall();
        self.reach.forget();
        (self.asked, self.given) = (Asked::NONE, [0.0; 3]);
        self.observer.felt_nothing();
    }

    /// Returns the device's output in a tick without a sample; the tissue has no tick then. Sets
    /// [`STALE`](crate::Flags::STALE) once the watchdog lowers the force,
    /// [`SAFE_STATE`](crate::Flags::SAFE_STATE) once it is 0.
    pub fn missed(&mut self) -> TickOutput {
        // The last sample got no answer; one that comes now is late.
        self.has_gap |= self.is_good;
        let (energy_j, contacts) = (self.energy_j, self.contacts);
        self.silent(TickOutput { energy_j, contacts, ..TickOutput::NONE })
    }
}
