//! What nobody has paid for: where the ramp waits, and where it goes down.
//!
//! A tool that engages inside a tissue, or that is faster than the ramp, has paid for less than the
//! tissue pushes with. The observer's H says what the hand has still to its credit. What H will be when
//! the force can be let go at the earliest is
//!
//! ```text
//! H - F . r (4 + n / 2) - the work of the forces on their way
//! ```
//!
//! with r the motion a tick, F the force given and n the ticks that the slew limit takes to bring it to
//! 0. Below -[`FREE_J`] the ramp goes down while the force pushes the hand the way it goes, the faster
//! the more is missing. It goes up again once H is above -[`WAIT_J`]: when the hand has paid, or as the
//! debt fades: within a second where the tool has been out of the tissue since the ramp was at its foot,
//! else by at most 0.2 mW. Below half of that it creeps.

use crate::number::cell::{dot, scale};
use crate::number::sqrt::sqrt;
use crate::stage::controller::SURE_COUNTS;
use crate::stage::delay::Delay;
use crate::stage::observer::Observer;

/// Debt of H down to which the ramp stays, in a press that began outside the ramp \[J\].
const FREE_J: f32 = 1.2e-3;
/// And in one that began within it \[J\].
const FREE_EARLY_J: f32 = 0.8e-3;
/// Debt of H beyond that at which the ramp goes down as fast as it can \[J\].
const WIDTH_J: f32 = 0.6e-3;
/// Debt of H from which on the ramp does not go up \[J\].
const WAIT_J: f32 = 0.2e-3;
/// Share of the force below which it is said to be withheld.
pub(super) const SHARE_SAID: f32 = 0.95;
/// Ticks in which a force goes on before it falls.
const STARTS: f32 = 4.0;

/// Whether the ramp has to wait until the hand has paid.
pub(super) fn waits(observer: &Observer) -> bool {
    observer.hand_j() <= -WAIT_J
}

/// Whether the ramp may only creep up: a force that rises faster makes the hand swing, and gives it more
/// than the ledger shows in time.
pub(super) fn is_in_debt(observer: &Observer) -> bool {
    observer.hand_j() <= -0.5 * WAIT_J
}

/// How fast the ramp goes down, 0 to 1 of the fastest, in an `early` press or another; `given` is the force
/// that the device has, `most_n` what the slew limit admits in a tick \[N\].
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
    // A motion of a few counts a tick is half noise.
    let sure = scale(fast / (fast + SURE_COUNTS * observer.count()), rate);
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
