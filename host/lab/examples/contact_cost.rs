//! What contact on a surface adds to a tick, in instructions by callgrind.
//!
//! ```sh
//! CHAINCELL_REFERENCE=... cargo run --release -p chaincell-lab --example contact_cost -- [links]
//! ```
//!
//! A sphere slides by 40 mm over the reference liver, 3 mm deep at 0.1 m/s, four sweeps a tick under
//! `predict`; the body is nodal, of 5 kPa and Poisson's ratio 0.45, or with `links` of links of 20 N/m.
//! Counted are 8 ticks at each of nine
//! places of the slide, and 8 ticks of the same body just let go, which still moves. Prints the share that
//! contact adds at the worst place, for spheres of 12 and 4 mm and with friction, and what it consists
//! of at most: triangles and samples in reach.
//!
//! Needs valgrind. Takes some minutes.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, ProbeContact, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{Model, Network, Settings, ToolPart, ToolSample, Unloading};
use nalgebra::Vector3;

/// Depth, way of a tick and length of the slide \[m\].
const DEPTH_M: f64 = 0.003;
const STEP_M: f64 = 1.0e-4;
const LENGTH_M: f64 = 0.04;
/// Places of the slide, and counted ticks at each.
const PLACES: usize = 9;
const TICKS: usize = 8;
const CASES: [(f64, f32); 3] = [(0.012, 0.0), (0.004, 0.0), (0.012, 0.3)];

/// The liver and where it is pressed.
struct Body {
    image: ImageBytes,
    mesh: Mesh,
    start_m: Vector3<f64>,
    inward: Vector3<f64>,
}

fn body(folder: &Path, of_links: bool) -> Body {
    let mesh =
        load(folder.join("meshes/liver_5762.vtk").to_str().unwrap(), &MeshOptions::default());
    let mesh = mesh.unwrap();
    let sets = std::fs::read_to_string(folder.join("meshes/liver_5762.sets.json")).unwrap();
    let sets: serde_json::Value = serde_json::from_str(&sets).unwrap();
    let list = |name: &str| -> Vec<f64> {
        sets[name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let fixed: Vec<u32> = list("fixed").into_iter().map(|node| node as u32).collect();
    let node = list("node")[0] as usize;
    let inward = Vector3::from_vec(list("dirn")).normalize();
    let start_m = Vector3::from(mesh.nodes_m[node]);
    let tissue = Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45));
    let tissue = Some(tissue).filter(|_| !of_links);
    let probe_contact = ProbeContact::Surface;
    let options = BakeOptions { tissue, probe_contact, ..BakeOptions::default() };
    let image = bake(&mesh, &fixed, &options).unwrap();
    Body { image, mesh, start_m, inward }
}

impl Body {
    /// Across the push: the way of the slide, as level as the axes allow.
    fn along(&self) -> Vector3<f64> {
        let axis = Vector3::ith(self.inward.iamin(), 1.0);
        self.inward.cross(&axis).normalize()
    }

    /// How far along the push the surface lies below a point \[m\].
    fn surface_m(&self, from: Vector3<f64>) -> Option<f64> {
        let hits = self.mesh.triangles.iter().filter_map(|nodes| {
            let [a, b, c] = nodes.map(|node| Vector3::from(self.mesh.nodes_m[node as usize]));
            let (u, v, way) = (b - a, c - a, from - a);
            let across = self.inward.cross(&v);
            let whole = u.dot(&across);
            let s = way.dot(&across) / whole;
            let turned = way.cross(&u);
            let t = self.inward.dot(&turned) / whole;
            (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| v.dot(&turned) / whole)
        });
        hits.filter(|m| m.is_finite()).reduce(f64::min)
    }

    /// The sphere's centre at a share of the slide, pressed in by so much.
    fn centre_m(&self, aside_m: f64, radius_m: f64, depth_m: f64) -> Vector3<f64> {
        let high = self.start_m + aside_m * self.along() - 0.1 * self.inward;
        let below_m = self.surface_m(high).unwrap_or(0.1);
        high + (below_m - radius_m + depth_m) * self.inward
    }
}

fn engine<'m>(model: Model<'m>, radius_m: f64, friction: f32) -> Engine<'m> {
    let (unloading, max_tool_step_m) = (Unloading::Off, 0.01);
    let settings = Settings { unloading, max_tool_step_m, ..Settings::for_model(&model) };
    let network = Network::new(model, Settings { sweeps: 4, ..settings }).unwrap();
    let tools = vec![vec![ToolPart::sphere(radius_m as f32)]];
    let contact = Contact::Tools { tools, friction };
    Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact).unwrap()
}

/// The run that is counted: up to a place of the slide, and `ticks` further ones.
fn slide(body: &Body, (radius_m, friction): (f64, f32), place: usize, ticks: usize) {
    let model = Model::from_bytes(body.image.as_bytes()).unwrap();
    let mut engine = engine(model, radius_m, friction);
    let from_m = LENGTH_M * (place as f64 / (PLACES - 1) as f64 - 0.5);
    let mut tick = |aside_m: f64, depth_m: f64| {
        let position_m = body.centre_m(aside_m, radius_m, depth_m).cast::<f32>();
        engine.tick(&ToolSample { position_m, engaged: 1 })
    };
    for step in 0..=30 {
        tick(from_m, DEPTH_M * f64::from(step) / 30.0);
    }
    for step in 0..20 + ticks {
        tick(from_m + STEP_M * step as f64, DEPTH_M);
    }
}

/// As many ticks of the same body from which the tool has let go: it still moves.
fn free(body: &Body, ticks: usize) {
    let model = Model::from_bytes(body.image.as_bytes()).unwrap();
    let mut engine = engine(model, 0.012, 0.0);
    for step in 0..=30 {
        let position_m = body.centre_m(0.0, 0.012, DEPTH_M * f64::from(step) / 30.0).cast::<f32>();
        engine.tick(&ToolSample { position_m, engaged: 1 });
    }
    let sample = ToolSample { position_m: Vector3::zeros(), engaged: 0 };
    for _ in 0..4 + ticks {
        engine.tick(&sample);
    }
}

/// Instructions of this program with these arguments.
fn instructions(arguments: &[String]) -> f64 {
    let program = std::env::current_exe().unwrap();
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(arguments)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().find_map(|line| line.split_once("Collected :")?.1.trim().parse().ok());
    count.unwrap()
}

fn a_tick(of_links: bool, arguments: &[&str]) -> f64 {
    let with = |ticks: usize| {
        let own = ["links"].iter().take(of_links.into()).chain(arguments).map(ToString::to_string);
        instructions(&own.chain([ticks.to_string()]).collect::<Vec<_>>())
    };
    (with(TICKS) - with(0)) / TICKS as f64
}

fn main() {
    let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE") else {
        println!("SKIPPED: CHAINCELL_REFERENCE is not set; the liver is read from there");
        return;
    };
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let of_links = arguments.first().is_some_and(|first| first == "links");
    let body = body(Path::new(&folder), of_links);
    arguments.drain(..usize::from(of_links));
    let number = |at: usize| arguments.get(at).map_or(0, |text| text.parse::<usize>().unwrap());
    match arguments.first().map(String::as_str) {
        Some("free") => return free(&body, number(1)),
        Some("slide") => return slide(&body, CASES[number(1)], number(2), number(3)),
        _ => {}
    }
    let free = a_tick(of_links, &["free"]);
    println!("liver, four sweeps without a tool: {free:.0} instructions a tick");
    for (case, (radius_m, friction)) in CASES.into_iter().enumerate() {
        let places = (0..PLACES).map(|place| {
            a_tick(of_links, &["slide", &case.to_string(), &place.to_string()]) / free - 1.0
        });
        let places: Vec<f64> = places.collect();
        let worst = places.iter().copied().fold(f64::MIN, f64::max);
        let mean = places.iter().sum::<f64>() / PLACES as f64;
        println!(
            "sphere of {} mm, friction {friction}: contact adds {:.1} % at most, {:.1} % on average",
            1000.0 * radius_m,
            100.0 * worst,
            100.0 * mean
        );
    }
}
