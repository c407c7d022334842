//! Closed loops of the tests: a modelled device in a hand, behind the output stage.
//!
//! A package of its own: its loops take millions of ticks, so they are optimised, which the tests that
//! call them are not.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing helper fails its test")]

pub mod closed_loop;
pub mod handle;
pub mod late;
