//! Model images; what is accepted is ticked in every scheme and number type.

use chaincell_host::bake::{ImageBytes, Notes};
use chaincell_host::engine::contact;
use chaincell_host::engine::tissue::Node;
use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_kernel::{Choice, Model, Network};
use chaincell_lab::monitor::Monitor;

use super::{bodies, tick};
use crate::forge::resealed;
use crate::graph::sample;

/// Bytes of the image's own length in its header.
const LENGTH: std::ops::Range<usize> = 12..16;

/// An image as it is, then with length and checksum set right, which a fuzzer does not guess.
pub fn model(data: &[u8]) {
    load(data);
    if data.len() < 32 {
        return;
    }
    let mut image = data.to_vec();
    image[LENGTH].copy_from_slice(&(data.len() as u32).to_le_bytes());
    load(resealed(image).as_bytes());
}

fn load(bytes: &[u8]) {
    let image = ImageBytes::copy(bytes);
    let Ok(model) = Model::from_bytes(image.as_bytes()) else { return };
    let _ = Notes::read(&model);
    let node = model.input_id()[0];
    assert!(contact::held(&model, &[node]).is_ok() || model.is_fixed(0) || model.fine_nodes() > 0);
    for &scheme in Scheme::ALL {
        for &numbers in Arithmetic::ALL {
            press(model, scheme, numbers);
        }
    }
}

/// A press and a release.
fn press(model: Model<'_>, scheme: Scheme, numbers: Arithmetic) {
    let network = Network::new(model, scheme.settings(&model, 2)).unwrap();
    let cells = bodies::free_cells(&model, 1, 2);
    let Ok(mut engine) = Engine::in_numbers(network, scheme, numbers, &cells) else { return };
    let mut monitor = Monitor::new(&engine, numbers);
    if model.coarse_functions() > 0 {
        // The kernel takes the coarse level's inverse as the bake computed it.
        monitor = monitor.without_certificate();
    }
    let [x, y, z] = model.centre_m();
    let depth = model.unit_m();
    let down = [x, y, z - 0.7 * depth];
    for (place, engaged) in
        [([x, y, z], 0), ([x, y, z], 1), (down, 1), (down, 1), (down, 0), (down, 0)]
    {
        tick(&mut monitor, &mut engine, &[sample(place, engaged)], None);
    }
    let mut nodes = vec![Node::default(); engine.node_count()];
    engine.read_nodes(&mut nodes);
    assert!(nodes.iter().flat_map(|node| node.position_m).all(f32::is_finite));
}
