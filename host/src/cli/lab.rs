//! The commands of the laboratory: `chaincell` hands them to the program `chaincell-lab`.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::process;

use clap::Command;

use crate::error::{Error, Result};
use crate::session::supervise::program;

/// Name of the program.
pub const PROGRAM: &str = "chaincell-lab";

/// Its commands, each with its line in `chaincell --help`.
pub const COMMANDS: [(&str, &str); 5] = [
    (
        "report",
        "Measure speed against error on this machine and write one HTML page with pictures, tables and \
         numbers",
    ),
    (
        "paper",
        "Compute the results of the paper anew, beside traditional ChainMail, and write one HTML \
         page with pictures, tables and numbers",
    ),
    (
        "stress",
        "Put bodies into states and under tools that none should come to, and check what must hold",
    ),
    (
        "identify",
        "Find the material of a body, links or nodal shapes, from measured curves and fields",
    ),
    (
        "relaxation",
        "Find the branches of tissue that relaxes from a measured curve of stress or force in time",
    ),
];

/// Commands of `chaincell` that tell more where the laboratory carries them out: about its commands too.
const TOLD_BETTER: [&str; 2] = ["completions", "man"];

/// Returns true if a word names a command of the laboratory.
fn is_known(word: &OsString) -> bool {
    COMMANDS.iter().any(|(name, _)| word == name)
}

/// The command line with the laboratory's commands in its help.
pub(super) fn listed(command: Command) -> Command {
    COMMANDS.iter().fold(command, |command, (name, about)| {
        command.subcommand(Command::new(*name).about(format!("{about} [{PROGRAM}]")))
    })
}

/// Hands the process over where its arguments name a command of the laboratory or one that it reports
/// better, or ask for the help of one. Returns where they do not.
///
/// # Errors
/// No `chaincell-lab`, with how to build it.
pub(super) fn hand_over() -> Result<()> {
    let mut arguments = std::env::args_os();
    let own_name = arguments.next().unwrap_or_default();
    let arguments: Vec<OsString> = arguments.collect();
    let word = match arguments.as_slice() {
        [help, word, ..] if help == "help" => word,
        [word, ..] => word,
        [] => return Ok(()),
    };
    let is_told_better = TOLD_BETTER.iter().any(|name| word == name);
    if !is_known(word) && !is_told_better {
        return Ok(());
    }
    let refused = |why: String| Err(Error::input(format!("{}: {why}", word.display())));
    let Some(program) = program::find(PROGRAM) else {
        if is_told_better {
            return Ok(());
        }
        return refused(format!(
            "this command is part of {PROGRAM}, which is neither beside chaincell nor in PATH; \
             build it in the source tree with cargo build --release -p {PROGRAM}, or install it \
             with cargo install --locked --path host/lab"
        ));
    };
    // The name in usage and messages stays the one that the user typed.
    let why = process::Command::new(&program).arg0(own_name).args(&arguments).exec();
    refused(format!("cannot start {}: {why}", program.display()))
}
