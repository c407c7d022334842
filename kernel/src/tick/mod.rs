//! The tick: its inputs, its outputs and its steps.
//!
//! A caller resets a [`Tissue`](crate::Tissue) to a [`Network`](crate::Network), chooses contact
//! cells or tools while the tool is released, and then ticks once for each sample of its poses:
//!
//! | step of a tick | what it does | file |
//! |---|---|---|
//! | sample | a bad one is replaced by the last good one for 10 ticks, then the safe state answers | `sample` |
//! | cuts | cells of opened faces split, and the corrections of the terms follow | [`cut`](crate::cut) |
//! | memory | that of a body that relaxes follows its strain | `relax` |
//! | contact | held cells follow the tool, tools touch the surface, or a current loads the cells | [`contact`](crate::contact) |
//! | bands | unloading closes or reopens them | `unloading` |
//! | sweeps | [`Settings::sweeps`](crate::Settings::sweeps) link passes under the scheme | [`solver`](crate::solver) |
//! | output | force, energy, work, stiffness, contacts, flags | `tick` |
//!
//! A tick cannot fail, panic or allocate, and makes no system call. The number of link passes is
//! bounded for any input. The state hash is a separate call, outside the tick. The settings may change between two
//! ticks. Contact cells can be chosen only while the tool is released, and another drive takes effect when
//! the tool next engages. The rules of each step are those of "One tick" in `host/REFERENCE.md`.
//!
//! - [`choice`], [`choices`]: a choice among named values, and the choices of a run.
//! - [`tables`]: tables of flags and codes.
//! - [`settings`], [`budget`], [`sample`]: parameters of a run, sweeps of a tick, its output.
//! - [`tissue`], [`fit`], `error`: the state in RAM, the check that a model fits it, and its errors.
//! - [`mod@tick`]: one tick; `unloading`: the rule of its bands.
//! - `body`: the body as it is now; `relax`: the memory of its strain.
//! - [`cut`]: opened faces and the cells that split.
//! - `force_error`: how far a force is from that of the body in equilibrium.
//! - [`tools`]: tools on a model with a contact surface; `pins`: what is held to the world.
//! - [`hash`]: the state hash.
//! - [`handover`]: samples from an interrupt to the tick.

mod body;
pub mod budget;
pub mod choice;
pub mod choices;
pub mod cut;
pub mod error;
pub mod fit;
mod force_error;
pub mod handover;
pub mod hash;
mod pins;
#[cfg(feature = "relax")]
mod relax;
pub mod sample;
pub mod settings;
mod stress;
pub mod tables;
#[cfg(test)]
mod tests;
#[expect(clippy::module_inception, reason = "the file of this room's verb")]
pub mod tick;
pub mod tissue;
pub mod tools;
mod unloading;
