//! `chaincell man`: the manual pages.

use std::fs;
use std::path::PathBuf;

use clap::Command;

use crate::error::{Error, Result};
use crate::terminal;

/// Write the manual pages, one a command; with `chaincell-lab` installed, those of its commands too.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell man ~/.local/share/man/man1")]
pub struct Args {
    /// Folder that the pages go to; made where it is not there
    folder: PathBuf,
}

/// Writes the pages of a command line.
///
/// # Errors
/// The folder cannot be made, or a page not be written.
pub fn execute(command: Command, args: &Args) -> Result<()> {
    let folder = &args.folder;
    fs::create_dir_all(folder).map_err(|why| Error::file("create folder", folder, why))?;
    clap_mangen::generate_to(command.disable_help_subcommand(true), folder)
        .map_err(|why| Error::file("write the pages to", folder, why))?;
    terminal::say(format_args!("manual pages are in {}", folder.display()))
}
