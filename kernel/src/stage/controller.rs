//! Passivity controller: takes back what sampling has made, and keeps what the hand gets back to
//! what it has put in.
//!
//! Both are a damping force -alpha v, together at most `2 (1/2 + delay) k h`, twice what a spring
//! of the stiffness k that is shown makes, and at most 20 N s/m: with a tick's delay and an
//! encoder's counts a stronger damper drives what it should damp. A motion of many counts a tick is
//! no noise, and S may take 20 N s/m then.
//!
//! - L < 0: alpha = -L / (h |v|^2); the rest stays in the ledger. What the last tick has ordered
//!   and the device does not feel yet is not ordered again. Not with a long delay, where nothing is
//!   made ([`delay`](super::delay)).
//! - S: a force that pushes the hand the way it goes does the work that is left of S in the next
//!   tick; what goes beyond is damped. A tool that stands still is given the force as it is, and
//!   the ramp waits while it would push more than that.
//!
//! So S is a bound for motions that the encoder shows well; a slow one may get back somewhat more,
//! and a fast one what the slew limit keeps up of a force that was let go.
//!
//! The damping of motions down to a count a tick goes to half and less: below that a velocity is
//! mostly the encoder's noise.

use crate::number::cell::{dot, scale, sub};
use crate::number::clamp::clamped;
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::stage::delay::Delay;
use crate::stage::observer::Observer;

/// Largest damping, for which a handle of 50 g stays in hand at 1 kHz [N s/m].
const ALPHA_MAX: f32 = 20.0;
/// Counts a tick from which on a velocity is more signal than noise.
pub(super) const SURE_COUNTS: f32 = 4.0;
/// Below this squared motion a tick a tool stands still \[m^2\].
const STILL_M2: f32 = 1.0e-20;

/// The controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Controller {
    /// What the last tick has ordered \[J\].
    ordered: f32,
}

kept!(Controller { ordered: f32 });

/// A force to be shown: clamped first, and then what the hand has no claim to is taken off \[N\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Asked {
    /// With the damping of what sampling has made.
    pub(super) force: [f32; 3],
    /// What is to be taken off.
    pub(super) off: [f32; 3],
}

kept!(Asked { force: [f32; 3], off: [f32; 3] });

impl Asked {
    pub(super) const NONE: Self = Self { force: [0.0; 3], off: [0.0; 3] };

    /// A force as it is.
    pub(super) fn all_of(force: [f32; 3]) -> Self {
        Self { force, ..Self::NONE }
    }
}

/// Largest damping [N s/m]: less of a longer delay, where a damper is a drive.
fn alpha_max(delay: f32) -> f32 {
    let late = if delay > 1.0 { 1.5 / (0.5 + delay) } else { 1.0 };
    late * ALPHA_MAX
}

impl Controller {
    pub(super) const NEW: Self = Self { ordered: 0.0 };

    /// What to ask the device for in place of `force`, `stiffness` being shown and `most_n` the
    /// most that it is given.
    pub(super) fn control(
        &mut self,
        observer: &Observer,
        tick_s: f32,
        delay: &Delay,
        [stiffness, most_n]: [f32; 2],
        force: [f32; 3],
    ) -> Asked {
        let ticks = delay.ticks();
        let under_way = if ticks == 0.0 { 0.0 } else { self.ordered };
        self.ordered = 0.0;
        let rate = observer.rate();
        let squared = dot(rate, rate);
        if squared <= STILL_M2 {
            return Asked::all_of(force);
        }
        let makes = (1.0 + 2.0 * ticks) * stiffness * tick_s;
        let alpha_max = alpha_max(ticks);
        let alpha = if makes < alpha_max { makes } else { alpha_max };
        let most = alpha / tick_s;
        let fast = sqrt(squared);
        let is_motion = fast / (fast + observer.count());
        let damp = |wanted_j: f32, most: f32| {
            let wanted = if wanted_j > 0.0 { wanted_j / squared } else { 0.0 };
            is_motion * if wanted < most { wanted } else { most }
        };
        let made =
            if delay.is_long() { 0.0 } else { damp(-observer.sampling_j() - under_way, most) };
        let force = sub(force, scale(made, rate));
        let unsure = SURE_COUNTS * observer.count();
        let is_sure = squared / (squared + unsure * unsure);
        let most = most + is_sure * (alpha_max / tick_s - most);
        let (given, _) = clamped(force, most_n);
        let over = damp(dot(given, rate) - observer.reserve_j(delay), most - made);
        self.ordered = (made + over) * squared;
        Asked { force, off: scale(over, rate) }
    }
}
