//! Jolt's soft body through `oxijolt`: XPBD edges, one iteration a millisecond, one thread.
//!
//! Jolt refuses a vertex below 1 g, so every one weighs that; only compliance times mass over the
//! squared step matters. Tried were compliances from 0 to 2e-2 m/N with dampings from 3 to 200 a
//! second (Jolt's own default, 0.1, settles the block in 461 steps). Two settings stand here: the
//! soonest at rest, whose field is not that of the links since one pass in a fixed order with
//! nearly rigid edges does not solve them, and the soonest whose field is (within 7 %).

use chaincell_host::error::{Error, Result};
use oxijolt::{
    BodyId, PhysicsWorld, RVec3, SoftBodyEdge, SoftBodyMut, SoftBodySettings,
    SoftBodySharedSettings, SoftBodyVertex, SoftBodyVertexState, Vec3, WorldSettings,
};

use super::Engine;
use super::scene::Pressed;

const STEP_S: f32 = 1e-3;
const ITERATIONS: u32 = 1;
const INVERSE_MASS_PER_KG: f32 = 1000.0;

/// What is tuned.
#[derive(Clone, Copy)]
pub struct Tuning {
    compliance_m_per_n: f32,
    damping_per_s: f32,
}

pub const SOONEST: Tuning = Tuning { compliance_m_per_n: 1e-4, damping_per_s: 100.0 };
pub const ELASTIC: Tuning = Tuning { compliance_m_per_n: 5e-3, damping_per_s: 80.0 };

pub struct Jolt {
    world: PhysicsWorld,
    body: BodyId,
    press: u32,
    target: RVec3,
    vertices: Vec<SoftBodyVertexState>,
}

impl Jolt {
    pub fn new(scene: &Pressed<'_>, tuning: Tuning) -> Result<Self> {
        let vertices = (0_u16..).zip(&scene.rest_m).map(|(cell, p)| SoftBodyVertex {
            position: Vec3::new(p[0] as f32, p[1] as f32, p[2] as f32),
            velocity: Vec3::ZERO,
            inverse_mass: if scene.is_held(cell) { 0.0 } else { INVERSE_MASS_PER_KG },
        });
        let mut shared = SoftBodySharedSettings::builder(vertices.collect(), Vec::new());
        for &vertices in &scene.links {
            shared = shared.edge(SoftBodyEdge { vertices, compliance: tuning.compliance_m_per_n });
        }
        let shared = shared.build().map_err(Error::check)?;
        if shared.edge_constraint_count() != scene.links.len() {
            return Err(Error::check("Jolt dropped edges"));
        }
        let settings = WorldSettings::default().gravity(Vec3::ZERO).single_threaded();
        let mut world = PhysicsWorld::new(settings).map_err(Error::check)?;
        let settings = SoftBodySettings::default()
            .num_iterations(ITERATIONS)
            .linear_damping(tuning.damping_per_s)
            .gravity_factor(0.0)
            .update_position(false)
            .allow_sleeping(false);
        let body = world.create_soft_body(&shared, &settings).map_err(Error::check)?;
        let [x, y, z] = scene.target_m.map(|x| x as f32);
        let (press, target) = (u32::from(scene.press), RVec3::new(x, y, z));
        Ok(Self { world, body, press, target, vertices: Vec::new() })
    }

    fn body_mut(&mut self) -> Result<SoftBodyMut<'_>> {
        self.world.soft_body_mut(self.body).map_err(Error::check)
    }
}

impl Engine for Jolt {
    fn press(&mut self) -> Result<()> {
        let (press, target) = (self.press, self.target);
        self.body_mut()?.move_kinematic_vertex(press, target, STEP_S).map_err(Error::check)?;
        self.step()?;
        // A kinematic vertex keeps its velocity until it is told otherwise.
        self.body_mut()?.set_vertex_velocity(press, Vec3::ZERO).map_err(Error::check)
    }

    fn step(&mut self) -> Result<()> {
        self.world.step(STEP_S).map(drop).map_err(Error::check)
    }

    fn positions_m(&mut self, out: &mut Vec<[f64; 3]>) -> Result<()> {
        let body = self.world.soft_body(self.body).map_err(Error::check)?;
        body.vertices_into(&mut self.vertices);
        out.clear();
        out.extend(self.vertices.iter().map(|vertex| {
            let p = vertex.position;
            [f64::from(p.x), f64::from(p.y), f64::from(p.z)]
        }));
        Ok(())
    }
}
