//! The plain loops of this crate; a step of the table is a pass over the links.

use chaincell_host::error::Result;
use chaincell_lab::baseline::Baseline;

use super::Engine;
use super::scene::Pressed;

pub struct Plain<'p, B> {
    scene: &'p Pressed<'p>,
    body: B,
}

impl<'p, B: Baseline> Plain<'p, B> {
    pub fn new(scene: &'p Pressed<'p>) -> Self {
        Self { scene, body: B::new(&scene.model) }
    }

    fn unit_and_centre_m(&self) -> (f64, [f64; 3]) {
        let model = &self.scene.model;
        (model.unit_m().into(), model.centre_m().map(f64::from))
    }
}

impl<B: Baseline> Engine for Plain<'_, B> {
    fn press(&mut self) -> Result<()> {
        let (unit_m, centre_m) = self.unit_and_centre_m();
        let to = |axis: usize| ((self.scene.target_m[axis] - centre_m[axis]) / unit_m) as f32;
        self.body.hold(self.scene.press.into(), [to(0), to(1), to(2)]);
        self.step()
    }

    fn step(&mut self) -> Result<()> {
        self.body.step();
        Ok(())
    }

    fn positions_m(&mut self, out: &mut Vec<[f64; 3]>) -> Result<()> {
        let (unit_m, centre_m) = self.unit_and_centre_m();
        let place = |at: &[f32; 3]| [0, 1, 2].map(|x| centre_m[x] + unit_m * f64::from(at[x]));
        *out = self.body.positions().iter().map(place).collect();
        Ok(())
    }
}
