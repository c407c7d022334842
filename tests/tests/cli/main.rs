//! The command from outside: its files, its refusals, its traces, and the pages that describe it.

mod bad_input;
mod latency;
mod output;
mod path_files;
mod place;
mod run;
mod safety;
mod trace;
