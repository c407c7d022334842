//! Forces and torques of several tools as CSV.

use std::fmt::Write as _;

use super::Folder;
use crate::engine::tools::Felt;
use crate::error::Result;

/// Rows of tools, tick by tick.
#[derive(Debug, Default)]
pub struct ToolRows(String);

/// Columns, as the contract defines them.
const HEADER: &str =
    "tick,tool,fx_n,fy_n,fz_n,tx_n_m,ty_n_m,tz_n_m,contacts,flags,force_error_n,torque_error_n_m\n";

impl ToolRows {
    /// Adds the output of a tool in a tick; decimals read back as the same numbers. `flags` are those of the
    /// tick.
    pub fn add(&mut self, tick: u64, tool: usize, felt: &Felt, flags: u32) {
        let _ = write!(self.0, "{tick},{tool}");
        for value in [felt.force_n, felt.torque_n_m].as_flattened() {
            let _ = write!(self.0, ",{value:e}");
        }
        let error_n = felt.force_error_n.unwrap_or(f32::NAN);
        let error_n_m = felt.torque_error_n_m.unwrap_or(f32::NAN);
        let (contacts, flags) = (felt.contacts, felt.all_flags(flags));
        let _ = writeln!(self.0, ",{contacts},{flags},{error_n:e},{error_n_m:e}");
    }

    /// Writes `tools.csv`, if there are tools that are defined by their parts.
    ///
    /// # Errors
    /// As [`Folder::write`].
    pub fn write(&self, folder: &Folder, tools: usize) -> Result<()> {
        match tools {
            0 => Ok(()),
            _ => folder.write("tools.csv", format!("{HEADER}{}", self.0).as_bytes()),
        }
    }
}

#[cfg(test)]
mod tests {
    use chaincell_kernel::Flags;

    use super::*;

    #[test]
    fn a_row_has_a_value_for_each_column() {
        let (force_n, torque_n_m) = ([0.1, -1.0e-30, 0.0], [0.25, 0.5, 2.0]);
        let flags = Flags::FORCE_CLAMPED;
        let (force_error_n, torque_error_n_m) = (Some(0.5), Some(0.25));
        let felt =
            Felt { force_n, torque_n_m, contacts: 7, flags, force_error_n, torque_error_n_m };
        let mut rows = ToolRows::default();
        rows.add(12, 1, &felt, 32);
        // The force limit was reached at another tool.
        rows.add(12, 2, &Felt::default(), 32 + 8);
        assert_eq!(
            rows.0,
            "12,1,1e-1,-1e-30,0e0,2.5e-1,5e-1,2e0,7,40,5e-1,2.5e-1\n\
             12,2,0e0,0e0,0e0,0e0,0e0,0e0,0,32,NaN,NaN\n"
        );
        assert_eq!(HEADER.split(',').count(), 12);
    }
}
