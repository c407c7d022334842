//! From a mesh to a model image: formats that are read, meshes and images that are refused.

mod bad_mesh;
mod cells;
mod check;
mod convert;
mod crafted_models;
mod cuttable;
mod mesh_options;
mod notes;
mod readers;
mod relaxation;
mod scenes;
mod selectors;
mod surfaces;
mod tissues;
