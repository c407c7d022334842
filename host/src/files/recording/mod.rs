//! Traces of sessions in memory and in files, in the kernel's format.

mod file;
mod map;
mod room;
#[cfg(test)]
pub(crate) mod tests;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use chaincell_kernel::stage::StageSettings;
use chaincell_kernel::trace::{
    Command, CommandRecord, End, Entry, Header, MAGIC, PartRecord, Reader, Record, RecordedTools,
    ReplayError, TraceError, Writer,
};
use chaincell_kernel::{Budget, Model, TickOutput, ToolPart, ToolPose};

use crate::engine::order::skipped;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::tools::Poses;
use crate::engine::{Arithmetic, Contact, Engine, Scheme};
use crate::error::{Error, Result};
use crate::files::whole::folder_of;
use crate::input;

pub use file::{TraceFile, check_idle};
pub use room::{check as check_room, taken};

/// Largest trace that is read: more than a day at 1 kHz.
const BYTES_MAX: u64 = 1 << 32;
/// Name of the trace in an output folder.
pub const TRACE: &str = "session.trace";
/// Name of the model in the same folder.
pub const MODEL: &str = "model.chaincell";

/// A trace in memory, to which ticks are added.
#[derive(Debug, Clone)]
pub struct Recording {
    writer: Writer,
    bytes: Vec<u8>,
}

impl Recording {
    /// Begins the trace of an engine at rest that uses `scheme` and `numbers`, with an output stage at rest
    /// if there is one.
    ///
    /// # Errors
    /// Contact cells that do not fit into a header.
    pub fn begin(
        engine: &Engine<'_>,
        scheme: Scheme,
        numbers: Arithmetic,
        stage: Option<&StageSettings>,
    ) -> Result<Self> {
        // Collect the input ids of the contact cells, or the tools.
        let network = engine.network();
        let id = |&cell: &u16| network.model().input_id()[usize::from(cell)];
        let ids: Vec<u32> = engine.contacts().iter().map(id).collect();
        let tools = match *engine.contact() {
            Contact::Tools { ref tools, friction } => {
                Some(RecordedTools { count: tools.len() as u32, friction })
            }
            Contact::Cells(_) => None,
        };
        // Write the header, and the parts of the tools after it.
        let header = Header::new(network, scheme, numbers);
        let header = Header { tools, stage: stage.copied(), ..header };
        let mut begun = Self::of(&header, &ids)
            .ok_or_else(|| Error::check("the contact cells do not go into a trace's header"))?;
        if let Contact::Tools { tools, .. } = engine.contact() {
            begun.add_parts(tools);
        }
        Ok(begun)
    }

    /// Adds the parts of all tools.
    fn add_parts(&mut self, tools: &[Vec<ToolPart>]) {
        for (tool, parts) in (0_u8..).zip(tools) {
            for (part, &shape) in (0_u8..).zip(parts) {
                let records = self.writer.part(&PartRecord { tool, part, shape });
                self.bytes.extend(records.as_flattened());
            }
        }
    }

    /// Begins a trace with a header and the input ids of the contact cells, in the model's order. Returns
    /// `None` if they do not fit together.
    #[must_use]
    pub fn of(header: &Header, contacts: &[u32]) -> Option<Self> {
        let mut bytes = vec![0; header.bytes(contacts.len())];
        let (writer, _) = Writer::begin(header, contacts, &mut bytes)?;
        Some(Self { writer, bytes })
    }

    /// Adds an executed tick.
    pub fn add(&mut self, record: &Record) {
        self.bytes.extend(self.writer.record(record));
    }

    /// Returns the bytes of the trace so far.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// The cause of a replay that stopped before the end of the trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The state after an entry differs from the recorded one.
    Differs(ReplayError),
    /// The command of this record cannot be executed.
    Command(u32),
    /// The caller has seen enough.
    Enough,
}

/// Numbers of played entries.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Played {
    /// Ticks, including those that were answered during a pause.
    pub ticks: u32,
    /// Commands.
    pub commands: u32,
    /// Entries whose hash was compared.
    pub compared: u32,
    /// True if the first tool had a contact.
    pub has_touched: bool,
}

/// A record of a trace that refers to a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// Index of the record.
    pub record: u32,
    /// Last tick before the snapshot.
    pub tick: u64,
    /// Checksum of the snapshot.
    pub checksum: u32,
    /// State hash at the snapshot, if one was recorded.
    pub state_hash: Option<u64>,
}

impl Mark {
    fn of(record: u32, entry: &Entry) -> Option<Self> {
        let Entry::Command(CommandRecord { tick, command, state_hash }) = *entry else {
            return None;
        };
        let Command::Snapshot { checksum } = command else { return None };
        Some(Self { record, tick, checksum, state_hash })
    }
}

/// Returns the snapshots to which a trace refers, in order. Replay reports how the trace ends.
#[must_use]
pub fn marks(trace: &Reader<'_>) -> Vec<Mark> {
    let mut marks = Vec::new();
    let _ = trace.entries(|record, entry| {
        marks.extend(Mark::of(record, entry));
        Ok::<(), std::convert::Infallible>(())
    });
    marks
}

/// Returns the snapshot of the first record after the tools' parts, from which a trace may begin. Reads no
/// further.
#[must_use]
pub fn start_mark(trace: &Reader<'_>) -> Option<Mark> {
    let mut mark = None;
    let _ = trace.entries(|record, entry| match entry {
        Entry::Part(_) => Ok(()),
        other => {
            mark = Mark::of(record, other);
            Err(())
        }
    });
    mark
}

/// Point from which a trace is played.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Start {
    /// The replay starts after this record; `None` for the beginning.
    pub behind: Option<u32>,
    /// True if the session was paused there.
    pub is_paused: bool,
}

/// Plays a trace with its commands and pauses, and compares the states. The tissue has to be in the recorded
/// state of the start. During a pause neither tissue nor stage ticks; a reset resets both.
///
/// # Errors
/// The cause of the stop; `played` then counts the entries before it.
pub fn play(
    trace: &Reader<'_>,
    tissue: &mut Staged<'_>,
    start: Start,
    played: &mut Played,
) -> std::result::Result<End, Stop> {
    play_by(trace, tissue, start, played, |tissue, poses, budget| tissue.tick_by(poses, budget))
}

/// As [`play`], with `tick` in place of [`TissueEngine::tick_by`]: it leaves the same state.
///
/// # Errors
/// As [`play`].
pub fn play_by<'m>(
    trace: &Reader<'_>,
    tissue: &mut Staged<'m>,
    start: Start,
    played: &mut Played,
    tick: impl FnMut(&mut Staged<'m>, &[ToolPose], Budget<'_>) -> TickOutput,
) -> std::result::Result<End, Stop> {
    play_steps(trace, tissue, start, played, tick, |_, _| true)
}

/// A tick or command that has been played.
#[derive(Debug, Clone, Copy)]
pub enum Step<'a> {
    /// A tick.
    Tick {
        /// Its record.
        record: &'a Record,
        /// The device's poses of all tools.
        poses: &'a [ToolPose],
        /// Its output; `None` in a pause, where nothing ticks.
        output: Option<TickOutput>,
    },
    /// A command.
    Command(&'a CommandRecord),
}

/// As [`play_by`], with a call of `after` after every step; it returns false to end there, with
/// [`Stop::Enough`].
///
/// # Errors
/// As [`play`].
pub fn play_steps<'m>(
    trace: &Reader<'_>,
    tissue: &mut Staged<'m>,
    start: Start,
    played: &mut Played,
    mut tick: impl FnMut(&mut Staged<'m>, &[ToolPose], Budget<'_>) -> TickOutput,
    mut after: impl FnMut(&mut Staged<'m>, Step<'_>) -> bool,
) -> std::result::Result<End, Stop> {
    let mut paused = start.is_paused;
    let mut poses = Poses::away(tissue.tools());
    let mut last = None;
    trace.entries(|index, entry| {
        // Skip the entries before the start.
        if start.behind.is_some_and(|behind| index <= behind) {
            return Ok(());
        }
        let one;
        let step = match entry {
            // The tissue already has its parts.
            Entry::Part(_) => return Ok(()),
            // Poses of tools precede their tick.
            Entry::Pose(record) => {
                if let Some(place) = poses.each_mut().get_mut(usize::from(record.tool)) {
                    *place = record.pose;
                }
                return Ok(());
            }
            Entry::Tick(record) => {
                one = [record.sample];
                let poses = if tissue.tools() > 0 { poses.each() } else { &one };
                let mut output = None;
                if !paused {
                    // Repeat the tick with all that the clock decided.
                    if record.ramp_restarted {
                        tissue.restart_ramp();
                    }
                    tissue.skipped(last.map_or(0, |last| skipped(last, record.tick)));
                    if let Some(ticks) = record.delay_ticks {
                        tissue.delayed(ticks);
                    }
                    let answer = tick(tissue, poses, Budget::again(record.sweeps));
                    played.has_touched |= answer.contacts > 0;
                    output = Some(answer);
                }
                last = Some(record.tick);
                played.ticks += 1;
                Step::Tick { record, poses, output }
            }
            Entry::Command(record) => {
                match record.command {
                    Command::Pause => paused = true,
                    Command::Resume => paused = false,
                    Command::Snapshot { .. } => {}
                    command => tissue.command(&command).map_err(|_| Stop::Command(index))?,
                }
                played.commands += 1;
                Step::Command(record)
            }
        };
        // Compare the state with the recorded hash.
        let found = entry.compare(index, tissue.state_hash()).map_err(Stop::Differs)?;
        played.compared += u32::from(found);
        if after(tissue, step) { Ok(()) } else { Err(Stop::Enough) }
    })
}

/// Refuses a path for a new trace if its file has content, except an earlier trace if `force` is set.
///
/// # Errors
/// An existing file, with the remedy; a folder that cannot be written.
pub fn check_place(path: &Path, force: bool) -> Result<()> {
    file::check_kind("`trace`", path)?;
    input::keep(path)?;
    if path.is_file() {
        let file = File::open(path).map_err(|why| Error::file("read", path, why))?;
        file::check_content("`trace`", path, &file, force)?;
    }
    let folder = folder_of(path);
    tempfile::tempfile_in(folder).map_err(|why| Error::file("write", path, why))?;
    check_idle("`trace`", path)
}

/// Returns true if a regular file begins like a trace.
#[must_use]
pub fn begins_like_a_trace(path: &Path) -> bool {
    let mut front = Vec::new();
    let read = |file: File| file.take(MAGIC.len() as u64).read_to_end(&mut front).is_ok();
    path.is_file() && File::open(path).is_ok_and(read) && front == MAGIC
}

/// Returns the bytes of a trace file. Stops reading a file that does not begin like a trace.
///
/// # Errors
/// The system's error, or that it is no trace, with the path.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let failed = |why: std::io::Error| Error::file("read trace", path, why);
    let file = input::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    let magic_bytes = MAGIC.len() as u64;
    (&file).take(magic_bytes).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.is_empty() || !MAGIC.starts_with(&bytes) {
        return Err(Error::file("read trace", path, TraceError::Magic));
    }
    (&file).take(BYTES_MAX + 1 - magic_bytes).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(Error::file("read trace", path, format_args!("more than {BYTES_MAX} bytes")));
    }
    Ok(bytes)
}

/// Creates a tissue at rest like the recorded one. Returns it with its scheme and its arithmetic.
///
/// # Errors
/// The reason why the trace cannot be played here, with its path.
pub fn tissue<'m>(
    trace: &Reader<'_>,
    path: &Path,
    model: Model<'m>,
) -> Result<(Staged<'m>, Scheme, Arithmetic)> {
    let refused = |why| Error::file("replay", path, why);
    let Header { scheme, number: numbers, .. } = *trace.header();
    let network = trace.header().network(model).map_err(refused)?;
    trace.header().output_stage().map_err(refused)?;
    let contact = match trace.header().tools {
        Some(RecordedTools { count, friction }) => {
            Contact::Tools { tools: parts(trace, count as usize, path)?, friction }
        }
        None => {
            let mut cells = vec![0; trace.contacts().len()];
            trace.contact_cells(&model, &mut cells).map_err(refused)?;
            Contact::Cells(cells)
        }
    };
    let engine = Engine::with_contact(network, scheme, numbers, contact);
    let engine = engine.map_err(|why| Error::file("replay", path, why))?;
    Ok((Staged::new(engine, trace.header().stage)?, scheme, numbers))
}

/// Returns the parts of all tools of a trace.
fn parts(trace: &Reader<'_>, tools: usize, path: &Path) -> Result<Vec<Vec<ToolPart>>> {
    let mut parts = vec![Vec::new(); tools];
    let mut is_in_order = true;
    let end = trace.entries(|_, entry| match entry {
        Entry::Part(PartRecord { tool, part, shape }) => {
            let of_tool = parts.get_mut(usize::from(*tool));
            is_in_order &= of_tool.is_some_and(|parts| {
                parts.push(*shape);
                parts.len() == usize::from(*part) + 1
            });
            Ok(())
        }
        _ => Err(()),
    });
    if is_in_order && parts.iter().all(|parts| !parts.is_empty()) {
        return Ok(parts);
    }
    let why = match end {
        Ok(end) => format!("the parts of its tools are not all there ({end}): copy it again"),
        Err(()) => "the parts of its tools are not all there: record again".to_owned(),
    };
    Err(Error::file("replay", path, why))
}
