//! What comes from outside, byte by byte: the bodies of the fuzz targets in `tests/fuzz`.
//!
//! Each takes any bytes at all and panics where a promise is broken. `tests/fuzz/run` feeds them
//! what a fuzzer finds; `tests/tests/kernel/corpus.rs` feeds them the committed corpora.

mod bodies;
mod canary;
mod mesh;
mod model;
mod path;
mod payload;
mod ticks;
mod tools;
mod trace;
mod twins;
mod words;

use chaincell_host::engine::Engine;
use chaincell_kernel::{TickOutput, ToolPose};
use chaincell_lab::monitor::Monitor;

pub use canary::canary;
pub use mesh::{gmsh, meshes, surface, vtk};
pub use model::model;
pub use path::path;
pub use payload::payload;
pub use ticks::ticks;
pub use tools::tools;
pub use trace::trace;
pub use words::words;

/// A tick that must keep every promise, with this number of sweeps, 0 for a late one, `None` for all.
fn tick<'m>(
    monitor: &mut Monitor<'m>,
    engine: &mut Engine<'m>,
    poses: &[ToolPose],
    sweeps: Option<u16>,
) -> TickOutput {
    let output = monitor.tick(engine, poses, sweeps);
    assert!(monitor.failures().is_empty(), "{:?}", monitor.failures());
    output
}

/// A target: its name, which is its corpus' too, and its body.
pub type Target = (&'static str, fn(&[u8]));

/// All targets but the canary, whose body is broken on purpose.
pub const TARGETS: [Target; 11] = [
    ("model", model),
    ("gmsh", gmsh),
    ("vtk", vtk),
    ("meshes", meshes),
    ("surface", surface),
    ("path", path),
    ("words", words),
    ("trace", trace),
    ("payload", payload),
    ("ticks", ticks),
    ("tools", tools),
];
