//! The command from outside: its files, its refusals, its traces, and the pages that describe it.

mod bad_input;
mod batch;
mod cut;
mod docs;
mod far;
mod force_error;
mod graded;
mod handout;
mod inputs;
mod judgement;
mod latency;
mod motion;
mod output;
mod path_files;
mod pins;
mod place;
mod pressure;
mod probe;
mod run;
mod safety;
mod series;
mod stress;
mod tools;
mod trace;
mod version;
