//! Tools around the chaincell kernel: the library behind the `chaincell` command.
//!
//! Each module uses only those above it:
//!
//! - [`words`], [`error`], [`terminal`], [`interrupt`]: counts in words, errors with exit codes,
//!   printing, Ctrl-C.
//! - [`input`]: what a command reads, and so neither removes nor replaces.
//! - [`text`]: reads text files that users write.
//! - `checksum`: CRC-32 of files.
//! - [`choice`]: the kernel's choices in JSON and in sentences.
//! - [`mesh`]: reads, generates and checks meshes.
//! - [`mod@bake`]: turns a mesh into a model image.
//! - [`engine`]: a tissue on the heap, its contact, its output stage, the built-in press.
//! - [`picture`]: bodies as PNG, curves as SVG.
//! - [`files`]: traces, path files and output folders.
//! - [`session`]: the 1 kHz loop over shared memory, both sides and their supervisor.
//! - [`remote`]: a session in another place, from its records.
//! - [`view`]: the page that shows a body, its server, and the bridge to a running scene.
//! - [`cli`]: the command line.

pub mod bake;
mod checksum;
pub mod choice;
pub mod cli;
pub mod engine;
pub mod error;
pub mod files;
pub mod input;
pub mod interrupt;
pub mod mesh;
pub mod picture;
pub mod remote;
pub mod session;
pub mod terminal;
pub mod text;
pub mod view;
pub mod words;
