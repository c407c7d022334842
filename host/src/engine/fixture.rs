//! The body of the unit tests.

use std::fs;

use chaincell_kernel::{Model, Network, Settings};

use super::{Engine, Scheme};
use crate::bake::ImageBytes;

/// The plane of 81 cells.
pub(crate) fn plane() -> ImageBytes {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/plane9.chaincell");
    ImageBytes::copy(&fs::read(path).unwrap())
}

/// A plane at rest with its middle cell held.
pub(crate) fn engine(image: &ImageBytes) -> Engine<'_> {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let network = Network::new(model, Settings { sweeps: 3, ..Settings::for_model(&model) });
    let middle = model.cell_of_input(40).unwrap();
    Engine::new(network.unwrap(), Scheme::Track, &[middle]).unwrap()
}
