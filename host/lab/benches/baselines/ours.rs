//! chaincell's own `track`, one sweep a tick, so that a step of the table is a sweep.

use chaincell_host::engine::{Engine as Body, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{Flags, Network, Settings, ToolPose};
use nalgebra::Vector3;

use super::Engine;
use super::scene::Pressed;

pub struct Ours<'m> {
    body: Body<'m>,
    sample: ToolPose,
    target_m: Vector3<f32>,
    force_n: Vector3<f64>,
}

impl<'m> Ours<'m> {
    pub fn new(scene: &Pressed<'m>) -> Result<Self> {
        // The press comes in one step, however deep.
        let settings =
            Settings { sweeps: 1, max_tool_step_m: 1.0, ..Settings::for_model(&scene.model) };
        let network = Network::new(scene.model, settings).map_err(Error::check)?;
        let mut body = Body::new(network, Scheme::Track, &[scene.press])?;
        let vector = |p: [f64; 3]| Vector3::from(p.map(|x| x as f32));
        let position_m = vector(scene.rest_m[usize::from(scene.press)]);
        let sample = ToolPose::at(position_m, 1);
        body.tick(&sample);
        Ok(Self { body, sample, target_m: vector(scene.target_m), force_n: Vector3::zeros() })
    }
}

impl Engine for Ours<'_> {
    fn press(&mut self) -> Result<()> {
        self.sample.position_m = self.target_m;
        let output = self.body.tick(&self.sample);
        if output.flags.contains(Flags::MOTION_CLAMPED) {
            return Err(Error::check("the press was shortened"));
        }
        self.force_n = output.force_n.map(f64::from);
        Ok(())
    }

    fn step(&mut self) -> Result<()> {
        let output = self.body.tick(&self.sample);
        self.force_n = output.force_n.map(f64::from);
        Ok(())
    }

    fn positions_m(&mut self, out: &mut Vec<[f64; 3]>) -> Result<()> {
        *out = self.body.positions_m();
        Ok(())
    }

    fn force(&mut self) -> Option<Vector3<f64>> {
        Some(self.force_n)
    }
}
