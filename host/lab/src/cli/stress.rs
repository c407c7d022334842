//! `chaincell stress`: the hard cases in one command.

use std::path::PathBuf;

use crate::experiments::stress::{Options, Scale, Suite, run, selected};
use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_host::terminal::{self, Progress};

/// Put bodies into states and under tools that none should come to, and check what must hold.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell stress --quick\n  \
    chaincell stress --only teleport --only nyquist --json\n\n\
    Every case runs in every scheme and number type, on bodies of links and of nodal shapes where its\n\
    mesh has elements. Seeds are fixed: the figures are the same on every machine. Exit code 1 names the cases that failed. Single thread.")]
pub struct Args {
    /// Smaller bodies, fewer ticks and seeds
    #[arg(long)]
    quick: bool,
    /// The drift over 10^8 ticks: an hour
    #[arg(long, conflicts_with = "quick")]
    slow: bool,
    /// Only cases with this in their names; may be given again
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// List the cases and what they check
    #[arg(long)]
    list: bool,
    /// Folder for stress.json and stress.txt
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite an earlier run in --out
    #[arg(long)]
    force: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn execute(args: &Args) -> Result<()> {
    if std::env::var_os("CHAINCELL_LOG").is_none() {
        // What the kernel warns of is what the cases are made of.
        log::set_max_level(log::LevelFilter::Error);
    }
    let scale = Scale { quick: args.quick, slow: args.slow };
    let options = Options { scale, only: args.only.clone() };
    let cases = selected(&options);
    if cases.is_empty() {
        return Err(Error::input(format!(
            "--only {}: no case has that in its name; see --list",
            args.only.join(" --only ")
        )));
    }
    if args.list {
        return cases
            .iter()
            .try_for_each(|case| terminal::say(format_args!("{:<20} {}", case.name, case.checks)));
    }
    let folder = args.out.as_deref().map(|out| Folder::open(out, args.force)).transpose()?;
    let bar = Progress::new(cases.len() as u64, "cases");
    let mut suite = Suite::default();
    let ended = run(&options, &mut suite, |_| bar.step());
    drop(bar);
    if !matches!(ended, Ok(()) | Err(Error::Interrupted)) {
        return ended;
    }
    if let Some(folder) = &folder {
        folder.write_json("stress.json", &suite)?;
        folder.write("stress.txt", suite.table().as_bytes())?;
    }
    if args.json {
        terminal::say_json(&suite)?;
    } else {
        terminal::say(suite.table())?;
    }
    ended?;
    let failed: Vec<&str> =
        suite.cases.iter().filter(|case| !case.ok).map(|case| case.name).collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(Error::check(format!("failed: {}", failed.join(", "))))
    }
}
