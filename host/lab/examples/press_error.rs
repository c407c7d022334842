//! Error of the force of a scheme on small organs under a straight press, as
//! `tests/firmware/run --fit` puts it beside the instructions of microcontrollers:
//!
//! ```sh
//! cargo run --release -p chaincell-lab --example press_error -- track:500:3.5 predict:500:none
//! ```
//!
//! An argument is a scheme, a number of cells and the spacing of the coarse level in mean link
//! lengths, `auto` as the bake chooses it, or `none`. One JSON object a line, one for each number of
//! sweeps a tick.

use std::process::ExitCode;

use chaincell_host::bake::BasisSpacing;
use chaincell_host::error::{Error, Result};
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::embedded::errors;

/// Sweeps a tick.
const SWEEPS: [u16; 3] = [1, 2, 4];

/// The body that an argument names.
fn body(argument: &str) -> Option<(&str, usize, BasisSpacing)> {
    let (scheme, body) = argument.split_once(':')?;
    let (cells, spacing) = body.split_once(':')?;
    let spacing = match spacing {
        "auto" => BasisSpacing::BySize,
        "none" => BasisSpacing::None,
        links => BasisSpacing::Links(links.parse().ok().filter(|&links| links >= 1.0)?),
    };
    Some((scheme, cells.parse().ok()?, spacing))
}

fn run() -> Result<()> {
    if std::env::args().len() < 2 {
        return Err(Error::input("no body: give SCHEME:CELLS:SPACING, as in track:500:3.5"));
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let wrong = |argument: &str| {
        Error::input(format!(
            "{argument:?}: SCHEME:CELLS:SPACING, with SPACING a number from 1 on, auto or none"
        ))
    };
    let bodies = arguments.iter().map(|argument| body(argument).ok_or_else(|| wrong(argument)));
    for (scheme, cells, spacing) in bodies.collect::<Result<Vec<_>>>()? {
        for row in errors(scheme, cells, spacing, &SWEEPS)? {
            println!("{}", serde_json::to_string(&row).map_err(Error::check)?);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    exit_code(run())
}
