//! rapier's soft body: edges with soft constraints, one substep a millisecond, one thread.
//!
//! Stiffness is given as a frequency of the edge's own masses, so an edge with a held end would be
//! twice as stiff as the others: its frequency is lower by the root of two. Tried were 30, 100,
//! 300 and 1000 Hz, damping ratios of 0.3, 1 and 3, particle dampings of 0 and 60 a second, 1 and
//! 4 substeps (4 is rapier's default, at three times the cost). Faster ones than these settle on
//! a field that is farther from the links' own.

use std::f32::consts::FRAC_1_SQRT_2;

use chaincell_host::error::{Error, Result};
use rapier3d::prelude::{
    PhysicsWorld, SoftBody, SoftBodyBuilder, SoftBodyHandle, SpringCoefficients, Vector,
};

use super::Engine;
use super::scene::Pressed;

const STEP_S: f32 = 1e-3;
const SUBSTEPS: usize = 1;
const MASS_KG: f32 = 1e-3;
const FREQUENCY_HZ: f32 = 300.0;
const DAMPING_RATIO: f32 = 0.3;
const DAMPING_PER_S: f32 = 60.0;

pub struct Rapier {
    world: PhysicsWorld,
    body: SoftBodyHandle,
    press: usize,
    target: Vector,
}

impl Rapier {
    pub fn new(scene: &Pressed<'_>) -> Result<Self> {
        let softness = |hz: f32| SpringCoefficients::new(hz, DAMPING_RATIO);
        let vector = |p: [f64; 3]| Vector::new(p[0] as f32, p[1] as f32, p[2] as f32);
        let cells = 0..scene.rest_m.len() as u16;
        let held = cells.filter(|&cell| scene.is_held(cell)).map(u32::from);
        let positions = scene.rest_m.iter().map(|&p| vector(p)).collect();
        let mut body = SoftBodyBuilder::new(positions)
            .edges(scene.links.clone())
            .pinned_particles(held)
            .particle_mass(MASS_KG)
            .softness(softness(FREQUENCY_HZ))
            .linear_damping(DAMPING_PER_S)
            .gravity_scale(0.0)
            .can_sleep(false)
            .no_surface_collider();
        body.edge_softness = (0..)
            .zip(&scene.links)
            .filter(|(_, ends)| ends.iter().any(|&end| scene.is_held(end as u16)))
            .map(|(edge, _)| (edge, softness(FREQUENCY_HZ * FRAC_1_SQRT_2)))
            .collect();
        let mut world = PhysicsWorld { gravity: Vector::ZERO, ..PhysicsWorld::default() };
        world.integration_parameters.dt = STEP_S;
        world.integration_parameters.num_solver_iterations = SUBSTEPS;
        let body = world.insert_soft_body(body);
        let (press, target) = (usize::from(scene.press), vector(scene.target_m));
        let mut rapier = Self { world, body, press, target };
        if rapier.body_mut()?.edges().len() != scene.links.len() {
            return Err(Error::check("rapier dropped edges"));
        }
        Ok(rapier)
    }

    fn body_mut(&mut self) -> Result<&mut SoftBody> {
        let body = self.world.soft_bodies.get_mut(self.body);
        body.ok_or_else(|| Error::check("rapier lost the body"))
    }
}

impl Engine for Rapier {
    fn press(&mut self) -> Result<()> {
        let (press, target) = (self.press, self.target);
        self.body_mut()?.set_particle_kinematic_target(press, target);
        self.step()
    }

    fn step(&mut self) -> Result<()> {
        self.world.step();
        Ok(())
    }

    fn positions_m(&mut self, out: &mut Vec<[f64; 3]>) -> Result<()> {
        let body = self.body_mut()?;
        out.clear();
        out.extend(body.particle_positions().map(|p| p.to_array().map(f64::from)));
        Ok(())
    }
}
