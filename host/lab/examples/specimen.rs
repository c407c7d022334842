//! The report's section on the measured specimen, alone.
//!
//! ```sh
//! CHAINCELL_REFERENCE=DIR cargo run --release -p chaincell-lab --example specimen -- [FOLDER]
//! ```
//!
//! Prints Markdown; with a folder, writes the CSV file and the picture there too. Takes ten seconds.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::specimen::{CSV, PICTURE, chart, markdown, run};
use chaincell_lab::experiments::report::tables::csv;

fn measure(reference: &Path, folder: Option<&Path>) -> Result<()> {
    let rows = run(reference)?;
    if let Some(folder) = folder.filter(|_| !rows.is_empty()) {
        let folder = Folder::open(folder, true)?;
        folder.write(CSV, csv(&rows).as_bytes())?;
        chart(&rows).write(&folder, PICTURE)?;
    }
    print!("{}", markdown(&rows, ""));
    Ok(())
}

fn main() -> ExitCode {
    let folder = std::env::args_os().nth(1).map(PathBuf::from);
    let reference = std::env::var_os("CHAINCELL_REFERENCE").filter(|folder| !folder.is_empty());
    let Some(reference) = reference else {
        println!("SKIPPED measured specimen: CHAINCELL_REFERENCE is not set");
        return ExitCode::SUCCESS;
    };
    exit_code(measure(Path::new(&reference), folder.as_deref()))
}
