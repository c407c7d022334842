//! Server, controller, clients and others over shared memory: real processes, faults, permissions.

mod client;
mod commands;
mod contacts;
mod cosim;
mod cut;
mod delay;
mod faults;
mod grip;
mod inject;
mod judgement;
mod kill;
mod killed_at_start;
mod load;
mod messages;
mod mirror;
mod motion;
mod permissions;
mod poses;
mod printed;
mod processes;
mod replayed;
mod snapshot;
mod stage;
mod stand_by;
mod tools;
mod view;
