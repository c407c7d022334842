//! The output stage between tissue and hand, in closed loop and in sessions.

mod bodies;
mod deep;
mod delay;
mod estimate;
mod events;
mod holds;
mod long;
mod overload;
mod passivity;
mod replayed;
mod served;
mod tools;
mod walls;
