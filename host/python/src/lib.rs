//! The Python package `chaincell`: its native part, which `python/chaincell` shows to users.
//!
//! Each module uses only those above it:
//!
//! - `errors`, `process`, `numbers`: exceptions; forked children; single arguments in.
//! - `signals`, `turns`: Ctrl-C and long work; what threads share.
//! - `arrays`, `given`: numpy arrays and keyword arguments in.
//! - `mesh`, `bake`, `model`: from arrays, meshio objects and files to a model.
//! - `poses`, `contacts`, `output`: where tools are, what they touch and feel.
//! - `stress`: strain and stress of tissue.
//! - `surface`: the surface of a body as it is cut.
//! - `live`, `tissue`, `run`: ticks without a server.
//! - `answer`, `state`, `session`: the client of `chaincell serve`.
//! - `rate`: a loop at a fixed rate.

#![allow(clippy::doc_lazy_continuation, reason = "docstrings for Python, with its examples")]

mod answer;
mod arrays;
mod bake;
mod contacts;
mod errors;
mod given;
mod live;
mod mesh;
mod model;
mod numbers;
mod output;
mod poses;
mod process;
mod rate;
mod run;
mod session;
mod signals;
mod state;
mod stress;
mod surface;
mod tissue;
mod turns;

use numpy::PyArray1;
use pyo3::prelude::*;

#[pymodule(gil_used = true)]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // Loads numpy now, for a tenth of a second, and not within the first step of a loop.
    module.py().import("numpy")?;
    PyArray1::<f64>::zeros(module.py(), 0, false);
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<tissue::Tissue>()?;
    module.add_class::<output::Output>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<contacts::Contacts>()?;
    module.add_class::<stress::Stress>()?;
    module.add_class::<stress::SessionStress>()?;
    module.add_class::<surface::Surface>()?;
    module.add_class::<session::Session>()?;
    module.add_class::<session::Reply>()?;
    module.add_class::<answer::Answer>()?;
    module.add_class::<state::State>()?;
    module.add_class::<rate::Rate>()?;
    module.add_function(wrap_pyfunction!(run::run, module)?)?;
    module.add_function(wrap_pyfunction!(given::tissue_options, module)?)?;
    module.add_function(wrap_pyfunction!(given::bake_options, module)?)
}
