//! What the pages say is true where a machine can tell: links lead somewhere, shell lines run,
//! commands, options, test targets and JSON keys exist, and the reference's tables are the program's.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod commands;
mod keys;
mod links;
mod page;
mod reference;
mod shell;
