//! The output stage between tissue and hand, in closed loop and in sessions.

mod holds;
mod passivity;
mod probe;
mod walls;
