//! The output stage between tissue and hand, in closed loop and in sessions.

mod bodies;
mod deep;
mod delay;
mod events;
mod holds;
mod long;
mod passivity;
mod probe;
mod replayed;
mod softening;
mod tools;
mod walls;
