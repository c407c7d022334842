//! What must hold on any body, whatever the tool does: random bodies of 4 to 40 cells, stiffness over six
//! decades, alpha from 0 to 0.99, pushed, torn, let go and left alone, and from any state at all. The checks of
//! every tick are the monitor's, as in `chaincell stress`.
//!
//! `CHAINCELL_SLOW=1 cargo test --release -p chaincell-tests --test kernel properties` takes a hundred times as
//! many states.
//!
//! - `contact`: tools on surfaces that slide, jump, turn and grip.
//! - `time`: sleep, rest, bad samples and late ticks.
//! - `tool`: whatever a tool does to cells that it holds.
//! - `state`: from any state, and to the ends of the range of fixed point.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod contact;
mod state;
mod time;
mod tool;
