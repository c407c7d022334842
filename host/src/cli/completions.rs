//! `chaincell completions`: what a shell needs to complete command lines.

use clap::Command;
use clap_complete::Shell;

use crate::error::Result;
use crate::terminal;

/// Print the completions of a shell; with `chaincell-lab` installed, those of its commands too.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  source <(chaincell completions bash)\n  \
    chaincell completions fish > ~/.config/fish/completions/chaincell.fish")]
pub struct Args {
    /// Shell to write for
    shell: Shell,
}

/// Prints the completions of a command line.
///
/// # Errors
/// Standard output cannot be written.
pub fn execute(mut command: Command, args: &Args) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "chaincell", &mut text);
    terminal::say(String::from_utf8_lossy(&text).trim_end())
}
