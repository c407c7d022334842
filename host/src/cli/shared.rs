//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::terminal;

/// How results are printed.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct PrintArgs {
    /// Print JSON, one object a line: the report is the last one
    #[arg(long)]
    pub json: bool,
}

/// The depth of the built-in press.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct DepthArgs {
    /// Depth of the press [m] [default: 3 mean link lengths]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    pub depth_m: Option<f64>,
}

/// The folder of a session.
#[derive(Debug, Clone, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct FolderArgs {
    /// Folder for the model, the poses as received, the forces, a trace and a summary
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite earlier results
    #[arg(long)]
    pub force: bool,
}

/// Handling of the force in a silence of the other side.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct SilenceArgs {
    /// Silence of the other side after which the force falls to 0, 0 for never [ms]
    #[arg(long, default_value_t = 20, value_name = "MS", allow_negative_numbers = true)]
    pub watchdog_ms: u32,
    /// Time in which the force falls in a silence, and rises after it; 0 for at once [ms]
    #[arg(long, default_value_t = 20, value_name = "MS", allow_negative_numbers = true)]
    pub ramp_ms: u32,
}

/// Prints the command that shows a model or a session in a browser, its name in a column of this width.
pub fn tell_view(width: usize, path: &Path) -> Result<()> {
    terminal::say(format_args!("  {:<width$}chaincell view {}", "view", path.display()))
}
