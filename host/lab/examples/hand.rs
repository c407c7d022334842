//! The report's table of a hand that moves, alone: speed against error of the force for cells that
//! are held, on the real liver (or the organ without it) and on the organ of 16,500 cells.
//!
//! ```sh
//! CHAINCELL_REFERENCE=DIR cargo run --release -p chaincell-lab --example hand
//! ```
//!
//! Prints Markdown. Takes some minutes, most of them for the minima in double precision.

use std::path::PathBuf;
use std::process::ExitCode;

use chaincell_host::error::Error;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::collect::{Options, hands_alone};
use chaincell_lab::experiments::report::hand::markdown;

fn main() -> ExitCode {
    if std::env::args().len() > 1 {
        let why = "takes no arguments; CHAINCELL_REFERENCE names the folder of the real liver";
        return exit_code(Err(Error::input(why)));
    }
    let reference = std::env::var_os("CHAINCELL_REFERENCE").filter(|folder| !folder.is_empty());
    let reference = reference.map(PathBuf::from);
    if reference.is_none() {
        eprintln!("SKIPPED the liver: CHAINCELL_REFERENCE is not set; the generated organ instead");
    }
    let rows = hands_alone(&Options { quick: false, reference });
    exit_code(rows.map(|rows| print!("{}", markdown(&rows, ""))))
}
