//! Figures of emulated microcontrollers, as `tests/firmware/run --json` prints them.

use std::path::Path;

use serde::{Deserialize, Serialize};

use chaincell_host::error::{Error, Result};
use chaincell_host::input;

/// An image with a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FirmwareRow {
    /// Core, and whether it has a floating-point unit.
    pub target: String,
    /// Scene.
    pub scene: String,
    /// Number type.
    pub tier: String,
    /// Links of the body.
    pub links: u64,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// Worst sweep.
    pub instructions_per_sweep_worst: u64,
    /// Worst tick.
    pub instructions_per_tick_worst: u64,
}

impl FirmwareRow {
    /// Instructions of the worst sweep for each link.
    #[must_use]
    pub fn per_link(&self) -> f64 {
        self.instructions_per_sweep_worst as f64 / self.links.max(1) as f64
    }
}

/// Reads one object a line.
///
/// # Errors
/// A file that cannot be read, the first line that is no such object, a file without any.
pub fn read(file: &Path) -> Result<Vec<FirmwareRow>> {
    let name = file.display();
    let text = input::open(file)
        .and_then(std::io::read_to_string)
        .map_err(|why| Error::input(format!("--firmware {name}: {why}")))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let rows = lines.map(|(at, line)| {
        serde_json::from_str(line).map_err(|why| {
            Error::input(format!(
                "--firmware {name}, line {}: {why}; write it with `tests/firmware/run --json`",
                at + 1
            ))
        })
    });
    let rows: Vec<FirmwareRow> = rows.collect::<Result<_>>()?;
    if rows.is_empty() {
        return Err(Error::input(format!(
            "--firmware {name}: no figures; write it with `tests/firmware/run --json`"
        )));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_and_named() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("firmware.json");
        let object = r#"{"target":"m7","scene":"plane8_track","tier":"f32","links":1640,"sweeps":4,
            "instructions_per_sweep_worst":3280,"instructions_per_tick_worst":9,"more":[1]}"#
            .replace('\n', "");
        std::fs::write(&file, format!("{object}\n\n{object}\n")).unwrap();
        let rows = read(&file).unwrap();
        assert_eq!((rows.len(), rows[1].per_link()), (2, 2.0));
        std::fs::write(&file, format!("{object}\nnothing\n")).unwrap();
        let why = read(&file).unwrap_err().to_string();
        assert!(why.contains("line 2") && why.contains("--json"), "{why}");
        std::fs::write(&file, "\n").unwrap();
        assert!(read(&file).unwrap_err().to_string().contains("no figures"));
    }
}
