//! Passivity controller: dissipates the energy that sampling generates, and limits the energy returned to the
//! hand to the energy that it put in.
//!
//! Both act as a damping force -alpha v, together at most `2 (1/2 + delay) k h`, twice what a spring of the
//! shown stiffness k generates, and at most 20 N s/m: with a delay of a tick and encoder counts, a stronger
//! damper would drive the motion. A motion of many counts per tick is no noise; there S may use the full 20 N
//! s/m.
//!
//! - L < 0: alpha = -L / (h |v|^2); the rest stays in the ledger. Energy ordered in the last tick, which the
//!   device does not apply yet, is not ordered again. With a long delay this part is off, since nothing is
//!   generated there ([`delay`](super::delay)).
//! - S: a force that pushes along the motion may do work up to the rest of S in the next tick; the excess is
//!   damped. A tool at rest gets the full force, and the ramp holds while the force would return more than S.
//!
//! So S is a bound for motions that the encoder resolves well. A slow motion may regain a little more, and a
//! fast one may regain energy while the slew limit lowers a withheld force.
//!
//! For motions of down to a count per tick the damping falls to a half and below: such a velocity is mostly
//! encoder noise.

use crate::number::cell::{dot, scale, sub};
use crate::number::clamp::clamped;
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::stage::delay::Delay;
use crate::stage::observer::Observer;

/// Largest damping: a handle of 50 g stays stable with it at 1 kHz [N s/m].
const ALPHA_MAX: f32 = 20.0;
/// Counts per tick from which on a velocity is more signal than noise.
pub(super) const SURE_COUNTS: f32 = 4.0;
/// Squared motion per tick below which a tool is at rest \[m^2\].
const STILL_M2: f32 = 1.0e-20;

kept! {
    /// The controller.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(super) struct Controller {
        /// Energy that the last tick ordered to dissipate \[J\].
        ordered: f32,
    }
}

kept! {
    /// A force to show: it is clamped first, then the part that the hand has no claim to is taken off \[N\].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(super) struct Asked {
        /// The force, including the damping of the energy that sampling generated.
        pub(super) force: [f32; 3],
        /// The part to take off.
        pub(super) off: [f32; 3],
    }
}

impl Asked {
    pub(super) const NONE: Self = Self { force: [0.0; 3], off: [0.0; 3] };

    /// A force with nothing to take off.
    pub(super) fn all_of(force: [f32; 3]) -> Self {
        Self { force, ..Self::NONE }
    }
}

/// Largest damping [N s/m]; it falls with a longer delay, where a damper drives the motion.
fn alpha_max(delay: f32) -> f32 {
    let late = if delay > 1.0 { 1.5 / (0.5 + delay) } else { 1.0 };
    late * ALPHA_MAX
}

impl Controller {
    pub(super) const NEW: Self = Self { ordered: 0.0 };

    /// Returns the force to show in place of `force`. `stiffness` is the shown stiffness, `most_n` the
    /// largest force.
    pub(super) fn control(
        &mut self,
        observer: &Observer,
        tick_s: f32,
        delay: &Delay,
        [stiffness, most_n]: [f32; 2],
        force: [f32; 3],
    ) -> Asked {
        // Dissipation that was ordered and is not applied yet.
        let ticks = delay.ticks();
        let under_way = if ticks == 0.0 { 0.0 } else { self.ordered };
        self.ordered = 0.0;
        let rate = observer.rate();
        let squared = dot(rate, rate);
        if squared <= STILL_M2 {
            return Asked::all_of(force);
        }
        // The largest damping that the shown stiffness justifies.
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
        // Dissipate the energy that sampling generated.
        let made =
            if delay.is_long() { 0.0 } else { damp(-observer.sampling_j() - under_way, most) };
        let force = sub(force, scale(made, rate));
        // Damp the work beyond the hand's reserve, more strongly where the velocity is well resolved.
        let unsure = SURE_COUNTS * observer.count();
        let is_sure = squared / (squared + unsure * unsure);
        let most = most + is_sure * (alpha_max / tick_s - most);
        let (given, _) = clamped(force, most_n);
        let over = damp(dot(given, rate) - observer.reserve_j(delay), most - made);
        self.ordered = (made + over) * squared;
        Asked { force, off: scale(over, rate) }
    }
}
