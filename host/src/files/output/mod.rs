//! Output of a run: a folder of files that appear whole or not at all.

mod cells;
mod contacts;
mod force;
mod pins;
mod pressure;
mod series;
mod tools;
mod vtu;

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::files::recording::{self, check_idle};
use crate::files::whole::{UNFINISHED, write_whole};
use crate::input;

pub use cells::cells_csv;
pub use contacts::ContactRows;
pub use force::{Answer, force_csv};
pub use pins::{PinCourse, PinRows};
pub use series::{SERIES, pvd, state_name};
pub use tools::ToolRows;
pub use vtu::vtu;

/// Name of the file that says which job of a batch fills a folder.
pub const JOB: &str = "job.json";

/// The file of that name.
#[derive(Debug, Serialize, Deserialize)]
pub struct Job {
    /// Hash of all that the job's results depend on.
    pub inputs_hash: String,
}

impl Job {
    /// Reads it from a folder; `None` where it is missing or damaged.
    #[must_use]
    pub fn of_folder(path: &Path) -> Option<Self> {
        serde_json::from_slice(&fs::read(path.join(JOB)).ok()?).ok()
    }
}

/// An output folder.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Creates the folder, or accepts one that is empty, files aside that a killed run did not finish. A folder with
    /// content is accepted only with `force`; the files of an earlier run in it are then removed, everything else
    /// stays.
    ///
    /// # Errors
    /// A folder that cannot be created or written, that has content or an input of this command, or to which
    /// a run is recording.
    pub fn open(path: &Path, force: bool) -> Result<Self> {
        if path.is_file() {
            return Err(Error::file("create folder", path, "a file is there: name a folder"));
        }
        fs::create_dir_all(path).map_err(|why| Error::file("create folder", path, why))?;
        check_idle("`out`", &path.join(recording::TRACE))?;
        let entries = fs::read_dir(path).map_err(|why| Error::file("read folder", path, why))?;
        let mut earlier = Vec::new();
        for entry in entries {
            let entry = entry.map_err(|why| Error::file("read folder", path, why))?;
            let is_leftover = entry.file_name().to_string_lossy().starts_with(UNFINISHED);
            if !force && !is_leftover {
                return Err(Error::input(format!(
                    "`out` {}: the folder is not empty (it has {}): name another one, or pass \
                     `force` to overwrite the files of an earlier run",
                    path.display(),
                    entry.file_name().to_string_lossy()
                )));
            }
            if is_ours(&entry.file_name().to_string_lossy()) {
                input::keep_there(&entry.path())?;
                earlier.push(entry.path());
            }
        }
        for file in earlier {
            fs::remove_file(&file).map_err(|why| Error::file("remove", &file, why))?;
        }
        let folder = Self { path: path.to_owned() };
        // Report a folder that cannot be written before the run, not after it.
        tempfile::tempfile_in(path).map_err(|why| Error::file("write in folder", path, why))?;
        Ok(folder)
    }

    /// Refuses a run if the disk is too small for its trace of `records` records. Call it before
    /// [`Self::open`], which removes files.
    ///
    /// # Errors
    /// Too little disk space, with the remedy.
    pub fn check_room(path: &Path, records: usize) -> Result<()> {
        let entries = fs::read_dir(path).into_iter().flatten().flatten();
        let ours = entries.filter(|entry| is_ours(&entry.file_name().to_string_lossy()));
        let given_up = ours.map(|entry| recording::taken(&entry.path())).sum();
        recording::check_room("`out`", &path.join(recording::TRACE), records, given_up)
    }

    /// Path of a file in the folder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a file: under another name first, so that it appears whole or not at all.
    ///
    /// # Errors
    /// A full disk, a folder that has gone.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<()> {
        write_whole(&self.file(name), content)
    }

    /// Writes a value as indented JSON.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<()> {
        let mut text = serde_json::to_string_pretty(value)
            .map_err(|why| Error::file("write", &self.file(name), why))?;
        text.push('\n');
        self.write(name, text.as_bytes())
    }
}

/// Returns true if a run writes files of that name.
fn is_ours(name: &str) -> bool {
    let is = |front: &str, end: &str| name.starts_with(front) && name.ends_with(end);
    let snapshot = is("cells_", ".csv") || is("state_", ".vtu") || name == SERIES;
    let report = ["report.html", "report.json"].contains(&name) || name.starts_with("report_");
    let paper = ["paper.html", "paper.json"].contains(&name) || name.starts_with("paper_");
    let chart = is("target", ".svg") || is("target", ".png") || is("picture_", ".png");
    let fixed = [
        "force.csv",
        "force.svg",
        "force_depth.svg",
        "picture.png",
        "contacts.csv",
        "tools.csv",
        "pins.csv",
        "path.csv",
        recording::TRACE,
        "final.vtu",
        "summary.json",
        JOB,
        recording::MODEL,
        "identified.json",
        "residuals.csv",
        "histogram.csv",
        "stress.json",
        "stress.txt",
    ];
    // States of a session whose trace is replaced belong to no session any more.
    let beside = [".snapshot", ".waiting"].iter().any(|end| is(recording::TRACE, end));
    let is_leftover = name.starts_with(UNFINISHED);
    snapshot || beside || report || paper || chart || is_leftover || fixed.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_with_content_needs_force_and_keeps_what_is_not_ours() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a/b");
        let folder = Folder::open(&path, false).unwrap();
        folder.write("cells_9.csv", b"old").unwrap();
        folder.write("paper_plane.svg", b"old").unwrap();
        folder.write("state_9.vtu", b"old").unwrap();
        folder.write(SERIES, b"old").unwrap();
        folder.write("session.trace.40.snapshot", b"old").unwrap();
        folder.write("notes.txt", b"mine").unwrap();
        let refused = Folder::open(&path, false).unwrap_err().to_string();
        assert!(refused.contains("not empty") && refused.contains("`force`"), "{refused}");
        Folder::open(&path, true).unwrap();
        assert!(!path.join("cells_9.csv").exists() && !path.join("paper_plane.svg").exists());
        assert!(!path.join("state_9.vtu").exists() && !path.join(SERIES).exists());
        assert!(!path.join("session.trace.40.snapshot").exists());
        assert_eq!(fs::read(path.join("notes.txt")).unwrap(), b"mine");
    }
}
