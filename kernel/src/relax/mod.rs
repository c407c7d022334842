//! Relaxation: the memory of a body whose stress fades, between its ticks.
//!
//! A body that is baked with branches remembers its strain: one of shapes as [`nodal::follow`](crate::energy) says, one
//! of links as [`links::follow`](crate::energy::links). The memory is in the words of the caller
//! ([`CutRoom`](crate::CutRoom)): a clock, the memory of each slice or half-link, and the numbers that a tick takes
//! from it.
//!
//! **Time.** A branch counts the ticks since it last followed the strain, late ticks too. In a tick with sweeps it
//! follows for all of them at once: with m of them it forgets b = 1 - exp(-m dt / tau), and carries c = b tau / (m dt)
//! of its modulus until the next time, so that a late tick leaves no gap in its time. Branches of 10,000 ticks and more
//! follow every 16 ticks.
//!
//! **The level.** What a branch forgets lowers the energy; the change is booked as that of any correction at the start
//! of a tick, and counted as relaxed.
//!
//! - `memory`: the words.
//! - `body`: the clock, and the body as it is in a tick.
//! - `kept`: the words of a snapshot.

pub(crate) mod body;
pub(crate) mod kept;
pub(crate) mod memory;
