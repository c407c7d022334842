//! A sphere on the surface of a block of liver, which it presses and slides over.
//!
//! ```sh
//! cargo run --release -p chaincell-lab --example contact -- [MESH] [NU|links|links:ALPHA]
//! ```
//!
//! The block is `box:20x17x9x0.005` of 5 kPa and Poisson's ratio 0.45 unless given, held at its
//! ground; of links of 20 N/m with `links`, and half-width ALPHA of their bands. Prints, for spheres of
//! 12 and 4 mm:
//!
//! - the force at 3 mm beside Hertz's of an elastic half space, and the work of a slow press and of a
//!   closed cycle beside the energy of the body; how far 4 sweeps a tick are off that press with 256;
//! - the largest change of the force in a tick of a slide of 40 mm at 3 mm depth and 0.1 m/s;
//! - how far 4 sweeps a tick are off that slide with 256 sweeps, as vectors.
//!
//! Takes a minute.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, Equivalent, ImageBytes, PerCell, ProbeContact, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{Model, Network, Settings, ToolPose, Unloading};
use nalgebra::Vector3;

const YOUNG_PA: f64 = 5000.0;
const DEPTH_M: f64 = 0.003;
/// Ticks of a press by the depth and of a slide of 40 mm at 0.1 m/s.
const PRESS: u32 = 600;
const SLIDE: u32 = 400;

/// What the body is made of.
enum Made {
    Tissue(f64),
    Links(f64),
}

/// The body's image and mesh.
fn body(mesh: &str, made: &Made) -> (ImageBytes, Mesh) {
    let mesh = load(mesh, &MeshOptions::default()).unwrap();
    let lowest = mesh.nodes_m.iter().map(|x| x[2]).fold(f64::MAX, f64::min);
    let nodes = mesh.nodes_m.iter().enumerate();
    let ground = nodes.filter(|(_, x)| x[2] < lowest + 1e-9).map(|(node, _)| node as u32);
    let fixed = match &mesh.default_fixed[..] {
        [] => ground.collect(),
        fixed => fixed.to_vec(),
    };
    let (probe_contact, of) = (ProbeContact::Surface, PerCell::Uniform);
    let options = BakeOptions { probe_contact, ..BakeOptions::default() };
    let options = match *made {
        Made::Tissue(nu) => {
            BakeOptions { tissue: Some(Tissue::new(of(YOUNG_PA), of(nu))), ..options }
        }
        Made::Links(alpha) => BakeOptions { alpha: of(alpha), ..options },
    };
    (bake(&mesh, &fixed, &options).unwrap(), mesh)
}

/// Height of the surface at a place of the x axis \[m\].
fn top_m(mesh: &Mesh, x_m: f64) -> f64 {
    let heights = mesh.triangles.iter().filter_map(|nodes| {
        let [a, b, c] = nodes.map(|node| Vector3::from(mesh.nodes_m[node as usize]));
        let (u, v, way) = (b - a, c - a, Vector3::new(x_m, 1.0e-9, 0.0) - a);
        let whole = u.x * v.y - u.y * v.x;
        let s = (way.x * v.y - way.y * v.x) / whole;
        let t = (u.x * way.y - u.y * way.x) / whole;
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| a.z + s * u.z + t * v.z)
    });
    heights.fold(f64::MIN, f64::max)
}

/// A sphere over the body.
struct Scene<'m> {
    engine: Engine<'m>,
    mesh: &'m Mesh,
    radius_m: f64,
}

impl<'m> Scene<'m> {
    fn new(model: Model<'m>, (mesh, radius_m): (&'m Mesh, f64), sweeps: u16) -> Self {
        let (unloading, max_tool_step_m) = (Unloading::Off, 0.01);
        let settings = Settings::for_model(&model);
        let settings = Settings { sweeps, unloading, max_tool_step_m, ..settings };
        let contact = Contact::Probe { radius_m: radius_m as f32, capacity: 64 };
        let network = Network::new(model, settings).unwrap();
        let engine = Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact);
        Self { engine: engine.unwrap(), mesh, radius_m }
    }

    /// Force, energy and work of a tick with the sphere so far aside and so deep.
    fn tick(&mut self, x_m: f64, depth_m: f64) -> (Vector3<f64>, f64, f64) {
        let z_m = top_m(self.mesh, x_m) + self.radius_m - depth_m;
        let position_m = [x_m, 0.0, z_m].map(|x| x as f32).into();
        let output = self.engine.tick(&ToolPose::at(position_m, 1));
        (output.force_n.cast(), output.energy_j.into(), output.work_j.into())
    }
}

/// Depth of a press at a tick \[m\].
fn depth_m(tick: u32) -> f64 {
    DEPTH_M * (1.2 * f64::from(tick) / f64::from(PRESS) - 0.2)
}

fn press(model: Model<'_>, place: (&Mesh, f64), [young_pa, poisson]: [f64; 2]) {
    let mut scene = Scene::new(model, place, 8);
    let pressed = (0..=PRESS).fold(0.0, |sum, tick| sum + scene.tick(0.0, depth_m(tick)).2);
    let (force, energy, _) = scene.tick(0.0, DEPTH_M);
    let cycle = (0..=PRESS).rev().fold(pressed, |sum, tick| sum + scene.tick(0.0, depth_m(tick)).2);
    let hertz =
        4.0 / 3.0 * young_pa / (1.0 - poisson * poisson) * place.1.sqrt() * DEPTH_M.powf(1.5);
    println!(
        "  press: {:.4} N (Hertz {hertz:.4}), work {:.2} % of the energy, cycle {:.2} % of the work",
        force.norm(),
        100.0 * pressed / energy,
        100.0 * cycle / pressed
    );
    let [settled, running] = [256, 4].map(|sweeps| {
        let mut scene = Scene::new(model, place, sweeps);
        let forces = (0..=PRESS).map(|tick| scene.tick(0.0, depth_m(tick)).0);
        forces.skip(PRESS as usize / 3).collect::<Vec<_>>()
    });
    let peak = settled.iter().map(Vector3::norm).fold(0.0, f64::max);
    let off = settled.iter().zip(&running).map(|(a, b)| 100.0 * (a - b).norm() / peak);
    let [median, largest] = spread(off.collect());
    println!(
        "  press: 4 sweeps off by {median:.2} % of the peak (median), {largest:.2} % (largest)"
    );
}

/// Median and largest.
fn spread(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[values.len() - 1]]
}

/// Forces of the slide.
fn slide(model: Model<'_>, place: (&Mesh, f64), sweeps: u16) -> Vec<Vector3<f64>> {
    let mut scene = Scene::new(model, place, sweeps);
    for tick in 0..160 {
        scene.tick(-0.02, DEPTH_M * f64::from(tick).min(60.0) / 60.0);
    }
    (0..SLIDE).map(|tick| scene.tick(-0.02 + 1.0e-4 * f64::from(tick), DEPTH_M).0).collect()
}

fn compare(model: Model<'_>, place: (&Mesh, f64)) {
    let [settled, running] = [256, 4].map(|sweeps| slide(model, place, sweeps));
    let mean = settled.iter().map(Vector3::norm).sum::<f64>() / f64::from(SLIDE);
    let change = |forces: &[Vector3<f64>]| {
        let changes = forces.windows(2).skip(30).map(|two| (two[1] - two[0]).norm() / mean);
        100.0 * changes.fold(0.0, f64::max)
    };
    let pairs = settled.iter().zip(&running).skip(30);
    let [median, largest] = spread(pairs.map(|(a, b)| 100.0 * (a - b).norm() / a.norm()).collect());
    println!(
        "  slide: mean {mean:.4} N, largest change in a tick {:.2} % settled, {:.2} % with 4 sweeps; \
         4 sweeps off by {median:.2} % (median), {largest:.2} % (largest)",
        change(&settled),
        change(&running),
    );
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mesh = arguments.next().unwrap_or_else(|| "box:20x17x9x0.005".to_owned());
    let kind = arguments.next().unwrap_or_else(|| "0.45".to_owned());
    let made = match kind.split_once(':').unwrap_or((&kind, "0")) {
        ("links", alpha) => Made::Links(alpha.parse().unwrap()),
        (nu, _) => Made::Tissue(nu.parse().unwrap()),
    };
    let (image, nodes) = body(&mesh, &made);
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    println!(
        "{mesh}, {kind}: {} cells, {} basis functions",
        model.cells(),
        model.coarse_functions()
    );
    let like = match made {
        Made::Tissue(nu) => [YOUNG_PA, nu],
        Made::Links(_) => [Equivalent::of_model(&model).unwrap().body_pa, 0.25],
    };
    println!("{:.0} Pa, Poisson's ratio {}", like[0], like[1]);
    for radius_m in [0.012, 0.004] {
        println!("sphere of {} mm", 1000.0 * radius_m);
        press(model, (&nodes, radius_m), like);
        compare(model, (&nodes, radius_m));
    }
}
