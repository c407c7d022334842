//! The laboratory around chaincell: what the paper and the report show, measured.
//!
//! Each module uses only those above it:
//!
//! - [`mod@reference`]: the static minimum in double precision, and published data.
//! - [`bodies`]: the bodies of experiments and tests, and the ways to compute them.
//! - [`states`]: states that no tool brings a body to.
//! - [`monitor`]: what must hold in every tick.
//! - `chainmail`: the method that the paper improves on.
//! - `charts`: curves and bodies as pictures.
//! - [`experiments`]: report, paper, stress and identification.
//! - [`cli`]: the command line of `chaincell-lab`.

pub mod bodies;
mod chainmail;
mod charts;
pub mod cli;
pub mod experiments;
pub mod monitor;
pub mod reference;
pub mod states;
