//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::engine::cut::report::CutReport;
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

/// Prints the cut of a body that can be cut, its name in a column of this width.
pub fn tell_cut(width: usize, cut: Option<&CutReport>) -> Result<()> {
    cut.map_or(Ok(()), |cut| terminal::say(format_args!("  {:<width$}{cut}", "cut")))
}

/// Prints the energy that a body has relaxed, its name in a column of this width.
pub fn tell_relaxed(width: usize, relaxed_j: Option<f32>) -> Result<()> {
    relaxed_j.map_or(Ok(()), |relaxed_j| {
        let name = "relaxed";
        terminal::say(format_args!("  {name:<width$}{:.3} mJ of the hand's work", 1e3 * relaxed_j))
    })
}

/// Names the remedy where cells could not split.
pub fn note_cut(cut: Option<&CutReport>) {
    if let Some(remedy) = cut.and_then(CutReport::remedy) {
        terminal::note(format_args!("note: {remedy}"));
    }
}

/// Prints the command that shows a model or a session in a browser, `view` with these arguments, its name in a
/// column of this width.
pub fn tell_view(width: usize, args: &[&Path]) -> Result<()> {
    let args: String = args.iter().map(|arg| format!(" {}", quoted(arg))).collect();
    terminal::say(format_args!("  {:<width$}chaincell view{args}", "view"))
}

/// An argument as a shell takes it.
fn quoted(arg: &Path) -> String {
    let arg = arg.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+=:,@%".contains(c);
    if arg.chars().all(is_plain) { arg } else { format!("'{}'", arg.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_quoted_where_a_shell_needs_it() {
        let said = ["a/b-1.chaincell", "my liver", "it's"].map(|arg| quoted(Path::new(arg)));
        assert_eq!(said, ["a/b-1.chaincell", "'my liver'", r"'it'\''s'"]);
    }
}
