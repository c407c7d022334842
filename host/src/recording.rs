//! Traces of sessions in memory and from files; the format is the kernel's.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use chaincell_kernel::Model;
use chaincell_kernel::trace::{
    Header, MAGIC, Reader, Record, RecordedProbe, TraceError, Writer, header_bytes,
};
use clap::ValueEnum;

use crate::engine::{Arithmetic, Contact, Engine, Scheme};
use crate::error::{Error, Result};
use crate::output;

/// Largest trace that is read: half a day at 1 kHz.
const BYTES_MAX: u64 = 1 << 31;

/// A trace that grows with every tick.
#[derive(Debug, Clone)]
pub struct Recording {
    writer: Writer,
    bytes: Vec<u8>,
}

/// Name of a scheme or number type, which the kernel's is too.
fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl Recording {
    /// Begins the trace of an engine that stands at rest under `scheme` in `numbers`.
    ///
    /// # Errors
    /// A scheme or number type without a code in the format.
    pub fn begin(engine: &Engine<'_>, scheme: Scheme, numbers: Arithmetic) -> Result<Self> {
        let network = engine.network();
        let id = |&cell: &u16| network.model().input_id()[usize::from(cell)];
        let ids: Vec<u32> = engine.contacts().iter().map(id).collect();
        let mut bytes = vec![0; header_bytes(ids.len())];
        let probe = match *engine.contact() {
            Contact::Cells(_) => None,
            Contact::Probe { radius_m, capacity } => {
                Some(RecordedProbe { radius_m, capacity: capacity as u32 })
            }
        };
        let header = Header::named(network, &name(&scheme), &name(&numbers));
        let header = header.map(|header| Header { probe, ..header });
        let begun = header.and_then(|header| Writer::begin(&header, &ids, &mut bytes));
        match begun {
            Some((writer, _)) => Ok(Self { writer, bytes }),
            None => Err(Error::check(format!(
                "{scheme:?} in {numbers:?} has no code in the trace's format"
            ))),
        }
    }

    /// Adds an executed tick.
    pub fn add(&mut self, record: &Record) {
        self.bytes.extend(self.writer.record(record));
    }

    /// The trace so far.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// Refuses a place for a new trace that holds something: with `force` an earlier trace may go,
/// anything else stays.
///
/// # Errors
/// A file that is there, with what to do; a folder that cannot be written.
pub fn check_place(path: &Path, force: bool) -> Result<()> {
    let refused = |why| Err(Error::input(format!("--trace {}: {why}", path.display())));
    if path.exists() && !path.is_file() {
        return refused("it is there and no file: name another one");
    }
    if path.is_file() {
        let mut front = Vec::new();
        let file = File::open(path).and_then(|file| file.take(8).read_to_end(&mut front));
        file.map_err(|why| Error::file("read", path, why))?;
        if !front.is_empty() && front != MAGIC {
            return refused("the file is there and is no trace: name another one");
        }
        if !force {
            return refused("the file is there: name another one, or pass --force to overwrite it");
        }
    }
    let folder = output::folder_of(path);
    tempfile::tempfile_in(folder).map_err(|why| Error::file("write", path, why))?;
    Ok(())
}

/// The bytes of a trace file.
///
/// # Errors
/// What the system says, with the path.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let failed = |why: std::io::Error| Error::file("read trace", path, why);
    let mut bytes = Vec::new();
    File::open(path)
        .map_err(failed)?
        .take(BYTES_MAX + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(Error::file("read trace", path, format_args!("more than {BYTES_MAX} bytes")));
    }
    Ok(bytes)
}

/// An engine as the recording's began, its scheme and its numbers.
///
/// # Errors
/// What the trace has that cannot be played here, with its path.
pub fn engine<'m>(
    trace: &Reader<'_>,
    path: &Path,
    model: Model<'m>,
) -> Result<(Engine<'m>, Scheme, Arithmetic)> {
    let refused = |why| Error::file("replay", path, why);
    let (scheme, number) = trace.header().names().map_err(refused)?;
    let scheme = Scheme::value_variants().iter().copied().find(|value| name(value) == scheme);
    let numbers = Arithmetic::value_variants().iter().copied().find(|value| name(value) == number);
    let (scheme, numbers) = scheme.zip(numbers).ok_or_else(|| {
        let Header { scheme, number, .. } = *trace.header();
        refused(TraceError::Scheme(scheme, number))
    })?;
    let network = trace.header().network(model).map_err(refused)?;
    let contact = match trace.header().probe {
        Some(RecordedProbe { radius_m, capacity }) => {
            Contact::Probe { radius_m, capacity: capacity as usize }
        }
        None => {
            let mut cells = vec![0; trace.contacts().len()];
            trace.contact_cells(&model, &mut cells).map_err(refused)?;
            Contact::Cells(cells)
        }
    };
    let engine = Engine::with_contact(network, scheme, numbers, contact);
    let engine = engine.map_err(|why| Error::file("replay", path, why))?;
    Ok((engine, scheme, numbers))
}
