//! A sphere on the surface of a block of liver, which it presses and slides over.
//!
//! ```sh
//! cargo run --release -p chaincell-lab --example contact -- [MESH] [NU]
//! ```
//!
//! The block is `box:20x17x9x0.005` of 5 kPa and Poisson's ratio 0.45 unless given, held at its
//! ground. Prints, for spheres of 12 and 4 mm:
//!
//! - the force at 3 mm beside Hertz's of an elastic half space, and the work of a slow press and of a
//!   closed cycle beside the energy of the body;
//! - the largest change of the force in a tick of a slide of 40 mm at 3 mm depth and 0.1 m/s;
//! - how far 4 sweeps a tick are off that slide with 256 sweeps, as vectors.
//!
//! Takes a minute.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, ProbeContact, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Model, Network, Settings, ToolSample, Unloading};
use nalgebra::Vector3;

const YOUNG_PA: f64 = 5000.0;
const DEPTH_M: f64 = 0.003;
/// Ticks of a press by the depth and of a slide of 40 mm at 0.1 m/s.
const PRESS: u32 = 600;
const SLIDE: u32 = 400;

/// The block's image and the height of its top.
fn block(mesh: &str, poisson: f64) -> (ImageBytes, f64) {
    let mesh = load(mesh, &MeshOptions::default()).unwrap();
    let heights = || mesh.nodes_m.iter().map(|x| x[2]);
    let (low, high) = heights().fold((f64::MAX, f64::MIN), |(a, b), z| (a.min(z), b.max(z)));
    let ground = heights().enumerate().filter(|(_, z)| *z < low + 1e-9);
    let fixed: Vec<u32> = ground.map(|(node, _)| node as u32).collect();
    let tissue = Some(Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(poisson)));
    let probe_contact = ProbeContact::Surface;
    let options = BakeOptions { tissue, probe_contact, ..BakeOptions::default() };
    (bake(&mesh, &fixed, &options).unwrap(), high)
}

/// A sphere over the block.
struct Scene<'m> {
    engine: Engine<'m>,
    top_m: f64,
    radius_m: f64,
}

impl<'m> Scene<'m> {
    fn new(model: Model<'m>, (top_m, radius_m): (f64, f64), sweeps: u16) -> Self {
        let (unloading, max_tool_step_m) = (Unloading::Off, 0.01);
        let settings = Settings::for_model(&model);
        let settings = Settings { sweeps, unloading, max_tool_step_m, ..settings };
        let contact = Contact::Probe { radius_m: radius_m as f32, capacity: 64 };
        let network = Network::new(model, settings).unwrap();
        let engine = Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact);
        Self { engine: engine.unwrap(), top_m, radius_m }
    }

    /// Force, energy and work of a tick with the sphere so far aside and so deep.
    fn tick(&mut self, x_m: f64, depth_m: f64) -> (Vector3<f64>, f64, f64) {
        let position_m = [x_m, 0.0, self.top_m + self.radius_m - depth_m].map(|x| x as f32).into();
        let output = self.engine.tick(&ToolSample { position_m, engaged: 1 });
        (output.force_n.cast(), output.energy_j.into(), output.work_j.into())
    }
}

fn press(model: Model<'_>, place: (f64, f64), poisson: f64) {
    let mut scene = Scene::new(model, place, 8);
    let depth = |tick: u32| DEPTH_M * (1.2 * f64::from(tick) / f64::from(PRESS) - 0.2);
    let pressed = (0..=PRESS).fold(0.0, |sum, tick| sum + scene.tick(0.0, depth(tick)).2);
    let (force, energy, _) = scene.tick(0.0, DEPTH_M);
    let cycle = (0..=PRESS).rev().fold(pressed, |sum, tick| sum + scene.tick(0.0, depth(tick)).2);
    let hertz =
        4.0 / 3.0 * YOUNG_PA / (1.0 - poisson * poisson) * place.1.sqrt() * DEPTH_M.powf(1.5);
    println!(
        "  press: {:.4} N (Hertz {hertz:.4}), work {:.2} % of the energy, cycle {:.2} % of the work",
        force.z,
        100.0 * pressed / energy,
        100.0 * cycle / pressed
    );
}

/// Forces of the slide.
fn slide(model: Model<'_>, place: (f64, f64), sweeps: u16) -> Vec<Vector3<f64>> {
    let mut scene = Scene::new(model, place, sweeps);
    for tick in 0..160 {
        scene.tick(-0.02, DEPTH_M * f64::from(tick).min(60.0) / 60.0);
    }
    (0..SLIDE).map(|tick| scene.tick(-0.02 + 1.0e-4 * f64::from(tick), DEPTH_M).0).collect()
}

fn compare(model: Model<'_>, place: (f64, f64)) {
    let [settled, running] = [256, 4].map(|sweeps| slide(model, place, sweeps));
    let mean = settled.iter().map(Vector3::norm).sum::<f64>() / f64::from(SLIDE);
    let change = |forces: &[Vector3<f64>]| {
        let changes = forces.windows(2).skip(30).map(|two| (two[1] - two[0]).norm() / mean);
        100.0 * changes.fold(0.0, f64::max)
    };
    let pairs = settled.iter().zip(&running).skip(30);
    let mut off: Vec<f64> = pairs.map(|(a, b)| 100.0 * (a - b).norm() / a.norm()).collect();
    off.sort_by(f64::total_cmp);
    println!(
        "  slide: mean {mean:.4} N, largest change in a tick {:.2} % settled, {:.2} % with 4 sweeps; \
         4 sweeps off by {:.2} % (median), {:.2} % (largest)",
        change(&settled),
        change(&running),
        off[off.len() / 2],
        off[off.len() - 1]
    );
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mesh = arguments.next().unwrap_or_else(|| "box:20x17x9x0.005".to_owned());
    let poisson = arguments.next().map_or(0.45, |nu| nu.parse().unwrap());
    let (image, top_m) = block(&mesh, poisson);
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    println!("{mesh}, nu {poisson}: {} cells, {} basis functions", model.cells(), model.hats());
    for radius_m in [0.012, 0.004] {
        println!("sphere of {} mm", 1000.0 * radius_m);
        press(model, (top_m, radius_m), poisson);
        compare(model, (top_m, radius_m));
    }
}
