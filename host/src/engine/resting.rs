//! A body at rest under a press: its force and its displacements, with as many sweeps as it takes.

use chaincell_kernel::{Flags, Model, Network, TickOutput, ToolPose};
use nalgebra::Vector3;

use super::convergence::MANY;
use super::place::Place;
use super::{Arithmetic, Contact, Engine, Scheme, rest_m};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::words::length;

/// Ticks in which the tool goes to its depth, and most of the wait that follows.
const STEPS: u16 = 40;
const WAIT_TICKS: usize = 200;
/// The body is at rest if the force changes by less than this share in each of some ticks.
const SETTLED: f32 = 2e-5;
const SETTLED_TICKS: usize = 5;

/// The tissue after a press.
#[derive(Debug, Clone, PartialEq)]
pub struct Resting {
    /// Force on the tool \[N\].
    pub force_n: Vector3<f64>,
    /// Displacement of each input node \[m\]; 0 of one that is no cell.
    pub displacements_m: Vec<Vector3<f64>>,
}

/// Presses a body at a place to a depth \[m\], and waits until it is at rest.
///
/// Cost: at most 240 ticks of 64 sweeps.
///
/// # Errors
/// A contact that the kernel refuses; a tool that is held back, or that touches nothing at its depth; Ctrl-C.
pub fn resting(
    model: &Model<'_>,
    contact: &Contact,
    place: &Place,
    depth_m: f64,
) -> Result<Resting> {
    let settings = Scheme::Predict.settings(model, MANY);
    let network = Network::new(*model, settings).map_err(Error::check)?;
    let mut engine =
        Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact.clone())?;
    let (touch_m, direction) = (Vector3::from(place.touch_m), Vector3::from(place.direction));
    let pose = |share: f64| {
        let position_m = touch_m + direction * (share * depth_m);
        ToolPose::at(position_m.map(|x| x as f32), 1)
    };
    // Go in, then wait.
    for step in 0..STEPS {
        interrupt::check()?;
        engine.tick(&pose(f64::from(step) / f64::from(STEPS)));
    }
    let output = settle(&mut engine, &pose(1.0))?;
    let is_held = output.flags.contains(Flags::MOTION_CLAMPED);
    if is_held || output.force_n.norm() <= 0.0 {
        let place = place.touch_m.map(length).join(", ");
        let why = if is_held {
            "the body holds the tool back; press less deep, or bake with a larger energy bound (`--energy-max-j`)"
        } else {
            "nothing touches the tool: it slid off, the body turned away from it, or the triangles are too large for \
             it; fix more of the body, press deeper, or take a larger tool"
        };
        return Err(Error::input(format!("pressed {} deep at ({place}), {why}", length(depth_m))));
    }
    // The displacements by input node.
    let mut displacements_m = vec![Vector3::zeros(); model.input_nodes() as usize];
    let positions_m = engine.positions_m();
    for (cell, (&node, position_m)) in model.input_id().iter().zip(positions_m).enumerate() {
        if let Some(to) = displacements_m.get_mut(node as usize) {
            *to = Vector3::from(position_m) - Vector3::from(rest_m(model, cell));
        }
    }
    Ok(Resting { force_n: output.force_n.cast(), displacements_m })
}

/// Waits until the force stays.
fn settle(engine: &mut Engine<'_>, pose: &ToolPose) -> Result<TickOutput> {
    let mut last = engine.tick(pose);
    let mut still = 0;
    for _ in 0..WAIT_TICKS {
        interrupt::check()?;
        let next = engine.tick(pose);
        let change_n = (next.force_n - last.force_n).norm();
        still = if change_n <= SETTLED * next.force_n.norm() { still + 1 } else { 0 };
        last = next;
        if still >= SETTLED_TICKS {
            break;
        }
    }
    Ok(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::tissue::Tissue;
    use crate::bake::{BakeOptions, PerCell, bake};
    use crate::engine::place::places;
    use crate::mesh::{MeshOptions, load};

    #[test]
    fn a_block_under_a_flat_press_has_the_force_of_its_modulus() {
        // The whole upper side is held: between a bar without and one with blocked sides.
        let mesh = load("box:5x5x4x0.01", &MeshOptions::default()).unwrap();
        let of = PerCell::Uniform;
        let tissue = Tissue { stretch_min: None, ..Tissue::new(of(5000.0), of(0.0)) };
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let top = mesh.nodes_m.iter().map(|at| at[2]).fold(f64::MIN, f64::max);
        let nodes =
            (0..mesh.nodes_m.len() as u32).filter(|&of| mesh.nodes_m[of as usize][2] == top);
        let cells: Vec<u32> = nodes.collect();
        let contact = Contact::Cells(crate::engine::contact::held(&model, &cells).unwrap());
        let place = places(&model, &contact, Some([0.0, 0.0, -1.0]), 3).unwrap();
        assert_eq!(place.len(), 1);
        let pressed = resting(&model, &contact, &place[0], 3e-4).unwrap();
        // E A d / H, without a Poisson's ratio exactly.
        let expected_n = 5000.0 * 0.04 * 0.04 * 3e-4 / 0.03;
        let error = (pressed.force_n.norm() / expected_n - 1.0).abs();
        assert!(error < 0.02, "{} N for {expected_n} N", pressed.force_n.norm());
        for (at, moved) in mesh.nodes_m.iter().zip(&pressed.displacements_m) {
            let share = 1.0 - (top - at[2]) / 0.03;
            assert!((moved.z + share * 3e-4).abs() < 1e-6, "{at:?}: {moved:?}");
        }
    }
}
