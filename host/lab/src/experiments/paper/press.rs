//! A body pressed by a spherical probe at 1 kHz: by the network, and by generalised `ChainMail`.

use std::time::Instant;

use chaincell_kernel::{Settings, ToolPose, Unloading};
use nalgebra::Vector3;

use crate::bodies::Variant;
use crate::chainmail::{ChainMail, Limits};
use crate::experiments::report::scene::Scene;
use crate::reference::profile::in_input_order;
use crate::reference::vectors::{dot, minus, norm, plus};
use chaincell_host::engine::motion::{Pose, Press};
use chaincell_host::engine::{Arithmetic, Contact, Scheme, rest_m};
use chaincell_host::error::Result;
use chaincell_host::interrupt;

/// Sweeps a tick of the network.
pub const SWEEPS: u16 = 4;
/// Part of the ticks at which the pictures are taken: late in the hold.
const SHOWN: f64 = 0.7;

/// A sphere on its way into a body.
pub struct Probe {
    /// Radius \[m\].
    pub radius_m: f64,
    /// Its centre, tick by tick; engaged from the touch on.
    pub poses: Vec<Pose>,
    /// Tick of the pictures.
    pub shown: usize,
}

impl Probe {
    /// The built-in press of a sphere along the axis of a scene, from where it first touches to
    /// `depth_m` below.
    pub fn new(scene: &Scene, radius_m: f64, depth_m: f64, ticks: u64) -> Result<Self> {
        let model = scene.model()?;
        let at = |&cell: &u16| Vector3::from(rest_m(&model, cell.into()));
        let foot = scene.contacts.iter().map(at).sum::<Vector3<f64>>();
        let foot = (foot / scene.contacts.len() as f64).into();
        let inward = scene.direction;
        let surface = model.surface().iter().map(|&cell| rest_m(&model, cell.into()));
        // How far back along the axis the centre stands when the sphere touches a cell.
        let back = surface.filter_map(|p| {
            let off = minus(p, foot);
            let along = -dot(off, inward);
            let aside = dot(off, off) - along * along;
            let room = radius_m * radius_m - aside;
            (room > 0.0).then(|| along + room.sqrt())
        });
        let back = back.fold(f64::NEG_INFINITY, f64::max);
        let touch = plus(foot, -back, inward);
        let poses = Press::new(touch, inward, depth_m, ticks)?.poses();
        Ok(Self { radius_m, poses, shown: (SHOWN * ticks as f64) as usize })
    }

    /// Its centre when the pictures are taken, and when it first touches \[m\].
    pub fn centres_m(&self) -> [[f64; 3]; 2] {
        let at = |pose: Option<&Pose>| pose.map_or([0.0; 3], |pose| pose.position_m.map(f64::from));
        let first = self.poses.iter().find(|pose| pose.engaged == 1);
        [at(self.poses.get(self.shown)), at(first)]
    }
}

/// What a method makes of the press.
#[derive(Default)]
pub struct Pressed {
    /// Positions when the pictures are taken, in input order \[m\].
    pub shown_m: Vec<[f64; 3]>,
    /// Force on the probe by tick \[N\]; empty for a method without forces.
    pub force_n: Vec<f64>,
    /// Cells in contact by tick.
    pub contacts: Vec<u32>,
    /// Duration of each tick \[ns\].
    pub step_ns: Vec<u64>,
}

/// The network under the probe.
pub fn network(scene: &Scene, probe: &Probe) -> Result<Pressed> {
    let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
    let contact = Contact::sphere(probe.radius_m as f32, 0.0);
    let mut engine = variant.engine(scene.model()?, contact, SWEEPS, |settings| Settings {
        unloading: Unloading::Off,
        ..settings
    })?;
    let mut pressed = Pressed::default();
    for (tick, pose) in probe.poses.iter().enumerate() {
        interrupt::check()?;
        let sample = ToolPose::from(*pose);
        let start = Instant::now();
        let output = engine.tick(&sample);
        pressed.step_ns.push(start.elapsed().as_nanos() as u64);
        pressed.force_n.push(norm(output.force_n.map(f64::from).into()));
        pressed.contacts.push(output.contacts);
        if tick == probe.shown {
            let positions_m = engine.positions_m();
            pressed.shown_m = in_input_order(engine.network().model(), &positions_m);
        }
    }
    Ok(pressed)
}

/// Generalised `ChainMail` under the probe: surface elements inside it are put on it, the chain
/// follows.
pub fn chainmail(scene: &Scene, probe: &Probe, alpha: f64) -> Result<Pressed> {
    let model = scene.model()?;
    let mut chain = ChainMail::of_model(&model, Limits::of_alpha(alpha)?)?;
    let free = |cell: &&u16| !model.is_fixed(**cell);
    let surface: Vec<usize> =
        model.surface().iter().filter(free).map(|&cell| usize::from(cell)).collect();
    let mut pressed = Pressed::default();
    for (tick, pose) in probe.poses.iter().enumerate() {
        interrupt::check()?;
        let centre = pose.position_m.map(f64::from);
        let start = Instant::now();
        let positions = chain.positions_m();
        let inside = surface.iter().filter(|_| pose.engaged == 1).filter_map(|&element| {
            let off = minus(positions[element], centre);
            let apart = norm(off);
            let scale = probe.radius_m / apart;
            (apart > 0.0 && scale > 1.0).then(|| (element, plus(centre, scale, off)))
        });
        let held: Vec<(usize, [f64; 3])> = inside.collect();
        if !held.is_empty() {
            chain.move_to(&held)?;
        }
        pressed.step_ns.push(start.elapsed().as_nanos() as u64);
        pressed.contacts.push(held.len() as u32);
        if tick == probe.shown {
            pressed.shown_m = in_input_order(&model, chain.positions_m());
        }
    }
    Ok(pressed)
}
