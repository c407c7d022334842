//! Measured tissue, fitted by `identify`.
//!
//! ```sh
//! CHAINCELL_REFERENCE=DIR cargo run --release -p chaincell-lab --example tissue -- [FOLDER] [FIT]
//! ```
//!
//! A porcine liver under a ball, brain cortex in three modes, a muscle that relaxes: all of them, or
//! `liver`, `brain` or `muscle` alone. Prints Markdown; with a folder, writes the numbers and the
//! pictures there too. Takes minutes, nearly all of them for the liver.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::tissue::{FITS, run};

fn fit(names: &[String], reference: &Path, folder: Option<&Path>) -> Result<()> {
    let folder = folder.map(|folder| Folder::open(folder, true)).transpose()?;
    for name in names {
        match run(name, reference)? {
            Err(skipped) => println!("{skipped}"),
            Ok(section) => {
                print!("{}", section.text);
                if let Some(folder) = &folder {
                    section.write(folder)?;
                }
            }
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let folder = arguments.next().map(PathBuf::from);
    let name = arguments.next().map(|name| name.to_string_lossy().into_owned());
    let names =
        name.map_or_else(|| FITS.map(|(name, _)| name.to_owned()).to_vec(), |name| vec![name]);
    let reference = std::env::var_os("CHAINCELL_REFERENCE").filter(|folder| !folder.is_empty());
    let Some(reference) = reference else {
        println!("SKIPPED measured tissue: CHAINCELL_REFERENCE is not set");
        return ExitCode::SUCCESS;
    };
    exit_code(fit(&names, Path::new(&reference), folder.as_deref()))
}
