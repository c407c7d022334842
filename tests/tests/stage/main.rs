//! The output stage between tissue and hand, in closed loop and in sessions.

mod delay;
mod holds;
mod passivity;
mod probe;
mod softening;
mod walls;
