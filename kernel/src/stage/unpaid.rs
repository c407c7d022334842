//! Energy debt of the hand: when the ramp holds and when it backs off.
//!
//! A hand whose tool engages inside a tissue, or moves faster than the ramp, has put in less energy than the
//! tissue's force can return. The observer's H is the energy balance of the hand. At the earliest time at
//! which the force can be gone, H will be
//!
//! ```text
//! H - F . r (4 + n / 2) - the work of the forces on their way
//! ```
//!
//! r is the motion per tick, F the given force and n the ticks that the slew limit needs to bring it to 0. If
//! this is below -[`FREE_J`] and the force pushes along the motion, the ramp goes down, faster the more is
//! missing. It goes up again once H is above -[`WAIT_J`]: the hand has paid, or the debt has faded. A debt
//! fades within a second if the tool has been out of the tissue since the ramp was at its foot, otherwise by
//! at most 0.2 mW. While the debt exceeds half of [`WAIT_J`], the ramp rises slowly.

use crate::number::cell::{dot, scale};
use crate::number::sqrt::sqrt;
use crate::stage::controller::SURE_COUNTS;
use crate::stage::delay::Delay;
use crate::stage::observer::Observer;

/// Debt of H up to which the ramp stays, in a press that began outside the ramp \[J\].
const FREE_J: f32 = 1.2e-3;
/// The same for a press that began inside the ramp \[J\].
const FREE_EARLY_J: f32 = 0.8e-3;
/// Debt beyond that at which the ramp goes down at its fastest \[J\].
const WIDTH_J: f32 = 0.6e-3;
/// Debt of H from which on the ramp does not rise \[J\].
const WAIT_J: f32 = 0.2e-3;
/// Ramp share below which the force is reported as withheld.
pub(super) const SHARE_SAID: f32 = 0.95;
/// Ticks for which a force continues before it falls.
const STARTS: f32 = 4.0;

/// Returns true if the ramp has to hold until the hand has paid.
pub(super) fn waits(observer: &Observer) -> bool {
    observer.hand_j() <= -WAIT_J
}

/// Returns true if the ramp may only rise slowly: a faster rise makes the hand oscillate, and returns more
/// energy to it than the ledger shows in time.
pub(super) fn is_in_debt(observer: &Observer) -> bool {
    observer.hand_j() <= -0.5 * WAIT_J
}

/// Rate at which the ramp goes down, 0 to 1 of the fastest. `given` is the device's force, `most_n` the slew
/// limit per tick \[N\].
pub(super) fn goes_down(
    (observer, delay): (&Observer, &Delay),
    is_early: bool,
    (given, most_n): ([f32; 3], f32),
) -> f32 {
    let rate = observer.rate();
    let fast = sqrt(dot(rate, rate));
    if fast == 0.0 {
        return 0.0;
    }
    // A motion of a few counts per tick is half noise.
    let sure = scale(fast / (fast + SURE_COUNTS * observer.count()), rate);
    // The balance expected at the earliest time at which the force can be gone.
    let push = dot(given, sure);
    let ticks = STARTS + 0.5 * sqrt(dot(given, given)) / most_n;
    let ahead = observer.hand_j() - push * ticks - observer.coming_j(delay, sure);
    let free = if is_early { FREE_EARLY_J } else { FREE_J };
    let over = -(ahead + free) / WIDTH_J;
    if push <= 0.0 || over <= 0.0 {
        0.0
    } else if over < 1.0 {
        over
    } else {
        1.0
    }
}
