//! Snapshots of sessions at the start of a run: what they were taken from must be what goes on.

use std::path::{Path, PathBuf};

use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::error::{Error, Result};
use crate::files::recording::{Mark, Start, marks, start_mark};
use crate::files::snapshot::{SessionSnapshot, place, start_place};
use chaincell_kernel::trace::Reader;

/// Why a session does not go on in this one.
pub const OTHER: &str =
    "its session was started with another model, other options or another release: take those";

/// Puts a tissue at rest where a snapshot was taken; `begun` is what a trace of it begins with. Gives
/// the snapshot.
///
/// # Errors
/// A file that is none, or of a session that was started otherwise, with its path.
pub fn restore(path: &Path, begun: &[u8], tissue: &mut Staged<'_>) -> Result<SessionSnapshot> {
    let (snapshot, _) = SessionSnapshot::read(path)?;
    if snapshot.begun != begun {
        return Err(Error::file("restore", path, OTHER));
    }
    tissue.restore(&snapshot.saved).map_err(|why| Error::file("restore", path, why))?;
    Ok(snapshot)
}

/// Puts the tissue of a trace where it is to be played from: behind the last snapshot after the tick
/// that was named, behind the one that the trace begins from, or at rest.
///
/// # Errors
/// No snapshot there, with those that are; a file that is not there, or another one.
pub fn start(
    (trace, path): (&Reader<'_>, &Path),
    bytes: &[u8],
    from: Option<u64>,
    tissue: &mut Staged<'_>,
) -> Result<Start> {
    let first = start_mark(trace);
    let named = from.map(|tick| after(trace, path, tick)).transpose()?;
    let Some(mark) = named.or(first) else { return Ok(Start::default()) };
    let (snapshot, file) = match found(path, &mark, first == Some(mark)) {
        // A session that stood at rest was asked for one ahead of all else.
        Err(_) if from.is_none() && mark.state_hash == Some(tissue.state_hash()) => {
            return Ok(Start::default());
        }
        found => found?,
    };
    if !bytes.starts_with(&snapshot.begun) {
        let why = "its session was started otherwise than that of the trace: copy the right one";
        return Err(Error::file("replay", &file, why));
    }
    tissue.restore(&snapshot.saved).map_err(|why| Error::file("replay", &file, why))?;
    Ok(Start::behind(&mark, first, snapshot.is_paused))
}

/// The last snapshot after a tick.
fn after(trace: &Reader<'_>, path: &Path, tick: u64) -> Result<Mark> {
    let marks = marks(trace);
    let mark = marks.iter().rev().find(|mark| mark.tick == tick);
    let none = || format!("--from {tick}: {} has {}", path.display(), told(&marks));
    mark.copied().ok_or_else(|| Error::input(none()))
}

/// The snapshot that a trace names, and its file: of the one that it begins from the copy first.
fn found(trace: &Path, mark: &Mark, is_start: bool) -> Result<(SessionSnapshot, PathBuf)> {
    let copy = Some(start_place(trace)).filter(|file| is_start && file.exists());
    let mut why = None;
    for file in copy.into_iter().chain([place(trace, mark.tick)]) {
        match SessionSnapshot::read(&file) {
            Ok((snapshot, checksum)) if checksum == mark.checksum => return Ok((snapshot, file)),
            Ok(_) => {
                let other = "it is not the one that the trace names: copy that one";
                why.get_or_insert(Error::file("replay", &file, other));
            }
            Err(other) => {
                why.get_or_insert(other);
            }
        }
    }
    Err(why.unwrap_or_else(|| Error::file("replay", trace, "its snapshot is missing")))
}

/// The ticks of the snapshots that there are.
fn told(marks: &[Mark]) -> String {
    if marks.is_empty() {
        return "no snapshot; take some with chaincell command snapshot".into();
    }
    let ticks: Vec<String> = marks.iter().map(|mark| mark.tick.to_string()).collect();
    format!("snapshots after the ticks {}", ticks.join(", "))
}
