//! Traces of sessions in memory and in files, in the kernel's format.

mod file;
mod map;
mod play;
mod room;
mod tail;
#[cfg(test)]
pub(crate) mod tests;

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use chaincell_kernel::stage::StageSettings;
use chaincell_kernel::trace::{
    Command, CommandRecord, Entry, Header, MAGIC, PartRecord, Reader, Record, RecordedTools,
    TraceError, Writer,
};
use chaincell_kernel::{Model, ToolPart};

use crate::engine::staged::Staged;
use crate::engine::{Arithmetic, Contact, Engine, Scheme};
use crate::error::{Error, Result};
use crate::files::whole::folder_of;
use crate::input;

pub use file::{TraceFile, check_idle};
pub use play::{Played, Player, Start, Step, Stop, play, play_by};
pub use room::{check as check_room, taken};
pub use tail::{Tail, seal_of, seal_of_begun};

/// Largest trace that is read: more than a day at 1 kHz.
const BYTES_MAX: u64 = 1 << 32;
/// Name of the trace in an output folder.
pub const TRACE: &str = "session.trace";
/// Name of the model in the same folder.
pub const MODEL: &str = "model.chaincell";

/// The trace of a session that is named by its trace or by the folder of its run.
#[must_use]
pub fn trace_of(session: &Path) -> PathBuf {
    if session.is_dir() { session.join(TRACE) } else { session.to_owned() }
}

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
                self.add_part(&PartRecord { tool, part, shape });
            }
        }
    }

    fn add_part(&mut self, part: &PartRecord) {
        self.bytes.extend(self.writer.part(part).as_flattened());
    }

    /// Begins a trace with a header and the input ids of the contact cells, in the model's order. Returns
    /// `None` if they do not fit together.
    #[must_use]
    pub fn of(header: &Header, contacts: &[u32]) -> Option<Self> {
        let mut bytes = vec![0; header.bytes(contacts.len())];
        let (writer, _) = Writer::begin(header, contacts, &mut bytes)?;
        Some(Self { writer, bytes })
    }

    /// Begins a trace like another one: with its header and the parts of its tools. Returns `None` if they do
    /// not fit together.
    #[must_use]
    pub fn again(trace: &Reader<'_>) -> Option<Self> {
        let ids: Vec<u32> = trace.contacts().collect();
        let mut begun = Self::of(trace.header(), &ids)?;
        let _ = trace.entries(|_, entry| match entry {
            Entry::Part(part) => {
                begun.add_part(part);
                Ok(())
            }
            _ => Err(()),
        });
        Some(begun)
    }

    /// Adds an executed command.
    pub fn add_command(&mut self, record: &CommandRecord) {
        self.bytes.extend(self.writer.command(record));
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
    /// Returns the last tick of the trace before it; `None` where there is none, as behind the snapshot `first`
    /// from which the trace begins.
    #[must_use]
    pub fn last_tick(&self, first: Option<Self>) -> Option<u64> {
        let before = first.map_or(0, |first| first.tick);
        Some(self.tick).filter(|&tick| tick != before)
    }

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

/// Refuses a path for a new trace if its file has content, except an earlier trace if `force` is set; `option`
/// names it in errors.
///
/// # Errors
/// An existing file, with the remedy; a folder that cannot be written.
pub fn check_place(option: &str, path: &Path, force: bool) -> Result<()> {
    file::check_kind(option, path)?;
    input::keep(path)?;
    if path.is_file() {
        let file = File::open(path).map_err(|why| Error::file("read", path, why))?;
        file::check_content(option, path, &file, force)?;
    }
    let folder = folder_of(path);
    tempfile::tempfile_in(folder).map_err(|why| Error::file("write", path, why))?;
    check_idle(option, path)
}

/// Returns true if a regular file begins like a trace.
#[must_use]
pub fn begins_like_a_trace(path: &Path) -> bool {
    let mut front = Vec::new();
    let read = |file: File| file.take(MAGIC.len() as u64).read_to_end(&mut front).is_ok();
    path.is_file() && File::open(path).is_ok_and(read) && front == MAGIC
}

/// Stands for a trace that is not there.
const NO_TRACE: &str = "there is no such file; name a trace, or a folder that `serve --out` or `run --out` has written";

/// Returns the bytes of a trace file. Stops reading a file that does not begin like a trace.
///
/// # Errors
/// The system's error, or that it is no trace, with the path.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let failed = |why: std::io::Error| Error::file("read trace", path, why);
    let file = input::open(path).map_err(|why| match why.kind() {
        ErrorKind::NotFound => Error::file("read trace", path, NO_TRACE),
        _ => failed(why),
    })?;
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
