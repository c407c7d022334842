//! The force of spheres on slabs of liver beside quadratic finite elements.
//!
//! ```sh
//! cargo run --release -p chaincell-lab --example contact_force
//! ```
//!
//! Round slabs of 50 mm in radius and 40 mm in height, 5 kPa and Poisson's ratio 0.45, held at their
//! bottom, with edges of about 8, 5 and 3.5 mm; spheres of 2 to 16 mm pressed by a tenth to a half of
//! their radius, over nodes, an edge and a triangle. Prints Markdown; takes some minutes. The exit code
//! says whether every bar holds.

use std::process::ExitCode;

use chaincell_host::error::{Error, Result};
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::contact::{
    EDGES_M, Reference, Row, SEED, SPHERES_M, Slab, bars, markdown,
};

fn measure() -> Result<()> {
    let references: Vec<Reference> =
        SPHERES_M.iter().map(|&sphere_m| Reference::new(sphere_m)).collect::<Result<_>>()?;
    let mut rows = Vec::new();
    for edge_m in EDGES_M {
        let slab = Slab::new(edge_m, SEED)?;
        eprintln!("edges of {:.2} mm: {} cells", 1000.0 * slab.edge_m, slab.cells);
        for reference in &references {
            rows.push(Row::new(&slab, reference)?);
        }
    }
    print!("{}", markdown(&references, &rows));
    match bars(&rows).iter().filter(|bar| !bar.holds()).count() {
        0 => Ok(()),
        missed => Err(Error::check(format!("{missed} of the bars are missed"))),
    }
}

fn main() -> ExitCode {
    if std::env::args().len() > 1 {
        return exit_code(Err(Error::input("takes no argument")));
    }
    exit_code(measure())
}
