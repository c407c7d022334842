//! Where `serve` records a session.

use std::fs;
use std::path::{Path, PathBuf};

use chaincell_kernel::trace::{Command, CommandRecord};
use serde::{Deserialize, Serialize};

use super::shared::FolderArgs;
use crate::bake::ImageBytes;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::error::{Error, Result};
use crate::files::output::Folder;
use crate::files::recording::{self, Recording, TraceFile};
use crate::files::snapshot::{self, SessionSnapshot};
use crate::files::whole::write_whole;
use crate::input;
use crate::session::loops::record::Recorder;
use crate::session::loops::serve::{Resumed, ServeReport, Server, SnapshotPlace};
use crate::terminal;

/// Ticks that are recorded unless the run's length is known: ten minutes.
const RECORD_TICKS: usize = 600_000;
/// Most ticks that are recorded unless asked for by number: an hour.
const KNOWN_TICKS_MAX: usize = 6 * RECORD_TICKS;
/// Most ticks that are recorded at all: two thirds of a day.
const RECORD_TICKS_MAX: usize = 100 * RECORD_TICKS;

/// Options of the record.
#[derive(Debug, Clone, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct RecordArgs {
    #[command(flatten)]
    pub folder: FolderArgs,
    /// Only a trace, in this file, for `chaincell replay`
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    pub record: Option<PathBuf>,
    /// Ticks that --out and --record have room for, 48 bytes of the disk each, and as many for each
    /// --tool
    /// [default: --ticks or --seconds at 1 kHz, at most an hour; else ten minutes]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub record_ticks: Option<usize>,
}

/// Where a session is recorded.
pub struct Recorded {
    /// The folder of --out.
    pub folder: Option<Folder>,
    /// The recorder of the loop.
    pub recorder: Recorder,
    trace: Option<PathBuf>,
    /// Where the trace stands while nothing is recorded, so that nobody takes it for one of a session.
    waiting: Option<PathBuf>,
}

/// The session to record.
pub struct Begun<'a> {
    /// The trace's header.
    pub recording: Recording,
    /// The model.
    pub image: &'a ImageBytes,
    /// Number of tools.
    pub tools: usize,
    /// Ticks of the run, if they are known.
    pub ticks: Option<usize>,
    /// True if the trace waits for another server to die.
    pub stands_by: bool,
}

impl RecordArgs {
    /// Returns true if something is recorded.
    pub fn is_given(&self) -> bool {
        self.record.is_some() || self.folder.out.is_some()
    }

    /// Makes room for the session's trace; nothing that is an input is replaced.
    ///
    /// # Errors
    /// A place that cannot be written, or that holds an earlier session; too many ticks.
    pub fn begin(&self, begun: Begun<'_>) -> Result<Recorded> {
        let of_folder = self.folder.out.as_ref().map(|out| out.join(recording::TRACE));
        let places = [self.record.clone(), of_folder];
        places.iter().flatten().try_for_each(|trace| input::keep(&snapshot::start_place(trace)))?;
        let (folder, recorder, waiting) = self.recorder(begun)?;
        let of_folder = folder.as_ref().map(|folder| folder.file(recording::TRACE));
        let trace = self.record.clone().or(of_folder);
        Ok(Recorded { folder, recorder, trace, waiting })
    }

    /// Folder, recorder, and where the trace waits; a killed session leaves the trace and the model beside it.
    fn recorder(&self, begun: Begun<'_>) -> Result<(Option<Folder>, Recorder, Option<PathBuf>)> {
        let Begun { recording: header, image, tools, ticks, stands_by } = begun;
        let ticks = self.ticks(ticks)?;
        let records = Recorder::trace_records(ticks, tools);
        let waiting = |trace: &Path| stands_by.then(|| waiting_place(trace));
        let force = self.folder.force;
        if let Some(path) = &self.record {
            recording::check_place("--record", path, force)?;
            let waiting = waiting(path);
            let place = waiting.as_ref().unwrap_or(path);
            let trace = TraceFile::create("--record", place, force, header, records)?;
            return Ok((None, Recorder::on_disk(ticks, trace), waiting));
        }
        let Some(out) = &self.folder.out else { return Ok((None, Recorder::default(), None)) };
        // Earlier results are not removed for a session that has no room.
        Folder::check_room(out, records)?;
        let folder = Folder::open(out, force)?;
        let place = folder.file(recording::TRACE);
        let waiting = waiting(&place);
        let trace =
            TraceFile::create("--out", waiting.as_ref().unwrap_or(&place), force, header, records)?;
        folder.write(recording::MODEL, image.as_bytes())?;
        let recorder = Recorder::with_capacity(ticks).with_tools(tools).with_trace(trace);
        Ok((Some(folder), recorder, waiting))
    }

    /// Ticks that there is room for.
    fn ticks(&self, known: Option<usize>) -> Result<usize> {
        if let Some(asked) = self.record_ticks {
            if !self.is_given() {
                return Err(Error::input(format!(
                    "--record-ticks {asked}: nothing is recorded: give --record or --out, or leave it out"
                )));
            }
            let remedy = format!("--record-ticks {asked}: must be at most {RECORD_TICKS_MAX}");
            return if asked <= RECORD_TICKS_MAX { Ok(asked) } else { Err(Error::input(remedy)) };
        }
        Ok(known.unwrap_or(RECORD_TICKS).min(KNOWN_TICKS_MAX))
    }
}

impl Recorded {
    /// Removes what was made for a session that does not come.
    pub fn forget(self) {
        drop(self.recorder);
        // A file that cannot be removed stays, and is named where it is in the way.
        let _ = self.waiting.or(self.trace).map(fs::remove_file);
        if let Some(folder) = &self.folder {
            let _ = fs::remove_file(folder.file(recording::MODEL));
        }
    }

    /// Lets a server go on from a snapshot, if there is one: the trace then begins with it, and a copy stands
    /// beside. `header` is what the trace begins with.
    ///
    /// # Errors
    /// A file that cannot be written; what was made is then to be forgotten.
    pub fn go_on(
        &mut self,
        mut server: Server,
        from: Option<SessionSnapshot>,
        header: &[u8],
        tissue: &mut Staged<'_>,
    ) -> Result<Server> {
        if let Some(snapshot) = from {
            let SessionSnapshot { tick, publisher, released, is_paused, .. } = snapshot;
            let (bytes, checksum) = snapshot.to_bytes();
            if let Some(trace) = &self.trace {
                write_whole(&snapshot::start_place(trace), &bytes)?;
            }
            if let Some((waiting, trace)) = self.waiting.as_ref().zip(self.trace.as_ref()) {
                fs::rename(waiting, trace).map_err(|why| {
                    let _ = fs::remove_file(snapshot::start_place(trace));
                    Error::file("write", trace, why)
                })?;
                self.waiting = None;
            }
            let (command, hash) = (Command::Snapshot { checksum }, tissue.state_hash());
            self.recorder.command(CommandRecord { tick, command, state_hash: Some(hash) });
            server = server.resuming(Resumed { tick, publisher, released, is_paused });
        }
        Ok(match self.trace.clone() {
            Some(trace) => server.with_snapshots(SnapshotPlace { trace, begun: header.to_vec() }),
            None => server,
        })
    }
}

/// The place of a trace while its server stands by.
fn waiting_place(trace: &Path) -> PathBuf {
    let mut name = trace.as_os_str().to_owned();
    name.push(".waiting");
    name.into()
}

/// Warns of ticks that did not fit the record.
pub fn tell_unrecorded(report: &ServeReport) {
    if report.ticks_unrecorded > 0 {
        terminal::note(format_args!(
            "WARNING: the last {} of {} ticks are NOT recorded, the record was full: raise \
             --record-ticks",
            report.ticks_unrecorded, report.ticks_executed
        ));
    }
}
