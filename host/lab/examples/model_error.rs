//! The report's section on the error of the model, alone: exact equilibria of links and of nodal
//! tissue against quadratic finite elements on the same meshes.
//!
//! ```sh
//! CHAINCELL_REFERENCE=DIR cargo run --release -p chaincell-lab --example model_error -- [FOLDER]
//! ```
//!
//! Prints Markdown; with a folder, writes the CSV file and the pictures there too. Takes some
//! minutes. The exit code says whether every bar of the section holds.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::model::{
    CSV, PICTURE, RUNNING_CSV, bars, charts, markdown, run,
};
use chaincell_lab::experiments::report::tables::csv;

fn measure(reference: &Path, folder: Option<&Path>) -> Result<()> {
    let folder = folder.map(|folder| Folder::open(folder, true)).transpose()?;
    let measured = run(reference, false, || {
        eprint!(".");
        Ok(())
    })?;
    eprintln!();
    if let Some(folder) = &folder {
        folder.write(CSV, csv(&measured.rows).as_bytes())?;
        folder.write(RUNNING_CSV, csv(&measured.running).as_bytes())?;
        for (number, (chart, _)) in charts(&measured).into_iter().enumerate() {
            chart.write(folder, &format!("{PICTURE}{}", number + 1))?;
        }
    }
    print!("{}", markdown(&measured, ""));
    match bars(&measured.rows).iter().filter(|bar| !bar.holds()).count() {
        0 => Ok(()),
        short => Err(Error::check(format!("{short} of the bars do not hold"))),
    }
}

fn main() -> ExitCode {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    if arguments.len() > 1 {
        return exit_code(Err(Error::input("takes one argument at most: a folder to write to")));
    }
    let reference = std::env::var_os("CHAINCELL_REFERENCE").filter(|folder| !folder.is_empty());
    let Some(reference) = reference else {
        println!("SKIPPED model error: CHAINCELL_REFERENCE is not set");
        return ExitCode::SUCCESS;
    };
    exit_code(measure(Path::new(&reference), arguments.first().map(PathBuf::as_path)))
}
