//! The settled force of the engine under a sphere.

use super::{HEIGHT_M, slab::Slab};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{Flags, Model, Network, Settings, ToolPose, Unloading};

/// Sweeps a tick.
const SWEEPS: u16 = 32;
/// The force settles when it changes by less than [`STILL`] of itself in so many ticks.
const LOOK: usize = 10;
const STILL: f64 = 5e-4;
/// Most looks at a depth.
const LOOKS: usize = 60;
/// Slots for cells, which a surface does not need.
const CAPACITY: usize = 64;

/// Force \[N\] along the way back at each of the depths, which rise, with the sphere over a place of
/// the top.
///
/// # Errors
/// A force that does not settle; a sphere that stops short of a depth.
pub fn forces(slab: &Slab, radius_m: f64, [x, y]: [f64; 2], depths_m: &[f64]) -> Result<Vec<f64>> {
    let model = Model::from_bytes(slab.image.as_bytes()).map_err(Error::check)?;
    let (unloading, max_tool_step_m) = (Unloading::Off, radius_m as f32);
    let settings =
        Settings { sweeps: SWEEPS, unloading, max_tool_step_m, ..Settings::for_model(&model) };
    let network = Network::new(model, settings).map_err(Error::check)?;
    let contact = Contact::Probe { radius_m: radius_m as f32, capacity: CAPACITY };
    let mut engine = Engine::with_contact(network, Scheme::Track, Arithmetic::F32, contact)?;
    let mut tick = |depth_m: f64| {
        let position_m = [x, y, HEIGHT_M + radius_m - depth_m].map(|x| x as f32).into();
        engine.tick(&ToolPose::at(position_m, 1))
    };
    tick(-radius_m);
    let mut at_depth = |&depth_m: &f64| {
        let mut before = f64::INFINITY;
        for _ in 0..LOOKS {
            let output = (1..LOOK).fold(tick(depth_m), |_, _| tick(depth_m));
            let force = f64::from(output.force_n.z);
            let clamped = output.flags.contains(Flags::MOTION_CLAMPED);
            if !clamped && (force - before).abs() <= STILL * force.abs() {
                return Ok(force);
            }
            before = force;
        }
        Err(Error::check(format!("no settled force at {depth_m} m under a sphere of {radius_m} m")))
    };
    depths_m.iter().map(&mut at_depth).collect()
}
