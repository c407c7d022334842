//! A run as text, for a target whose runs are compared on a workstation.
//!
//! ```text
//! scene NAME TIER
//! tick TICK STATE_HASH DIGEST          a line a tick, hexadecimal
//! end TICKS DIGEST BYTES
//! cells TICK                           where asked for: the state after that tick
//! cell CELL X Y Z                      bits of the published position, hexadecimal
//! ```
//!
//! `cargo run --release -p chaincell-scenes --example golden -- check` reads it and names the
//! first tick and cell that differ from the workstation's own.

use core::fmt::{Result, Write};

use crate::{Stepper, Tier};

/// Plays a run that has just begun for `ticks` ticks and writes its report, with the cells after
/// the ticks in `cells`.
///
/// # Errors
/// Those of the writer.
pub fn write(
    to: &mut dyn Write,
    run: &mut dyn Stepper,
    tier: Tier,
    ticks: u32,
    cells_after: Option<u32>,
) -> Result {
    writeln!(to, "scene {} {}", run.scene().name, tier.name())?;
    for tick in 0..ticks {
        let state_hash = run.step();
        writeln!(to, "tick {tick} {state_hash:016x} {:016x}", run.digest())?;
        if cells_after == Some(tick) {
            write_cells(to, run, tick)?;
        }
    }
    writeln!(to, "end {ticks} {:016x} {}", run.digest(), run.bytes())
}

/// The cells of a run as it stands, after `tick`.
fn write_cells(to: &mut dyn Write, run: &dyn Stepper, tick: u32) -> Result {
    writeln!(to, "cells {tick}")?;
    for cell in 0..run.scene().cells {
        if let Some([x, y, z]) = run.cell_bits(cell) {
            writeln!(to, "cell {cell} {x:08x} {y:08x} {z:08x}")?;
        }
    }
    Ok(())
}
