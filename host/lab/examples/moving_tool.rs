//! How far the force of a moving tool is off at few sweeps a tick, beside 48 of them.
//!
//! ```sh
//! cargo run --release -p chaincell-lab --example moving_tool -- [links] organ:1000 organ:5783
//! ```
//!
//! An argument is a body as `bake` generates it (without one: `organ:1000`), of 5 kPa and Poisson's
//! ratio 0.45, or of links behind the word `links`. Tools are pressed into it by the built-in press and slide while it holds. Prints a
//! table, errors in percent of the largest force of the row's reference. A minute for each thousand
//! cells.

use std::process::ExitCode;

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, PerCell, ProbeContact, bake};
use chaincell_host::engine::Contact;
use chaincell_host::error::Result;
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::ToolPart;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::moving::{Moving, POISSON, YOUNG_PA};

/// Sweeps a tick that are measured, and those of the reference.
const SWEEPS: [u16; 4] = [1, 2, 4, 8];
const REFERENCE_SWEEPS: u16 = 48;

/// Name, tool, depth and way aside \[m\], and ticks.
type Case = (&'static str, Vec<ToolPart>, f64, f64, u64);

fn cases() -> Vec<Case> {
    let ball = |radius_m| vec![ToolPart::sphere(radius_m)];
    vec![
        ("ball of 12 mm, 43 mm deep in 1 s", ball(0.012), 0.043, 0.0, 1000),
        ("the same to 10 mm", ball(0.012), 0.010, 0.0, 1000),
        ("23 mm in 0.3 s", ball(0.012), 0.023, 0.0, 300),
        ("ball of 4 mm, 6 mm deep", ball(0.004), 0.006, 0.0, 1000),
        ("ball of 12 mm, slides by 30 mm, 6 mm deep", ball(0.012), 0.006, 0.03, 1000),
        ("ball of 4 mm, slides by 20 mm, 4 mm deep", ball(0.004), 0.004, 0.02, 1000),
        ("capsule, 10 mm deep", vec![ToolPart::capsule(0.01, 0.006)], 0.010, 0.0, 1000),
        ("box, 8 mm deep", vec![ToolPart::rounded_box([0.006; 3], 0.004)], 0.008, 0.0, 1000),
    ]
}

fn measure() -> Result<()> {
    let mut given: Vec<String> = std::env::args().skip(1).collect();
    let of_links = given.first().is_some_and(|first| first == "links");
    if of_links {
        given.remove(0);
    }
    let bodies = if given.is_empty() { vec!["organ:1000".to_owned()] } else { given };
    for body in bodies {
        let mesh = load(&body, &MeshOptions::default())?;
        let shapes = Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(POISSON));
        let tissue = Some(shapes).filter(|_| !of_links);
        let probe_contact = ProbeContact::Surface;
        let options = BakeOptions { tissue, probe_contact, ..BakeOptions::default() };
        let image = bake(&mesh, &mesh.default_fixed, &options)?;
        println!("| {body} | sweeps | median | p90 | largest | discarded |\n|-|-|-|-|-|-|");
        for (name, parts, depth_m, aside_m, ticks) in cases() {
            let contact = Contact::Tools { tools: vec![parts], friction: 0.0 };
            let way = (depth_m, aside_m, ticks);
            let moving = Moving::press(&image, contact, way, REFERENCE_SWEEPS)?;
            for sweeps in SWEEPS {
                let row = moving.row(sweeps)?;
                let [median, p90, largest] =
                    [row.median, row.p90, row.largest].map(|error| 100.0 * error);
                println!(
                    "| {name} | {sweeps} | {median:.2} | {p90:.2} | {largest:.1} | {} |",
                    row.rolled_back
                );
            }
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    exit_code(measure())
}
