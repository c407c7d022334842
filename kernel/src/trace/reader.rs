//! Reading and replay of a trace.

use core::fmt;

use super::error::TraceError;
use super::header::{Header, Read};
use super::order::Order;
use super::record::{
    Entry, RAMP_RESTARTED, Record, ReplayError, WITH_DELAY, WITH_HASH, WITH_SWEEPS, WORDS,
    checksum, sample,
};
use super::{KIND_COMMAND, KIND_PART, KIND_POSE, KIND_SAMPLE, KIND_TOOL_COMMAND, RECORD_BYTES};
use crate::model::Model;
use crate::stage::DELAY_TICKS_MAX;

/// The end of the records of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The records end with the trace.
    Complete,
    /// The trace ends within this record: it was cut, or its writer was stopped.
    Cut(u32),
    /// This record's bytes were changed, or belong to another trace.
    Damaged(u32),
    /// This record is of a kind that is not known here.
    Kind(u32, u16),
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Complete => f.write_str("complete"),
            Self::Cut(record) => write!(f, "cut within record {record}"),
            Self::Damaged(record) => {
                write!(f, "record {record} is damaged (its checksum does not match): copy it again")
            }
            Self::Kind(record, KIND_COMMAND | KIND_TOOL_COMMAND) => {
                write!(f, "record {record} is a command, which only a host's replay carries out")
            }
            Self::Kind(record, KIND_PART | KIND_POSE) => write!(
                f,
                "record {record} is of tools that were chosen by their parts: it stands in no order \
                 that is known here, or is for a host's replay alone"
            ),
            Self::Kind(record, kind) => write!(
                f,
                "record {record} of kind {kind} holds what is unknown here: take the release that \
                 wrote it"
            ),
        }
    }
}

/// The result of a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Played {
    /// Number of ticks.
    pub ticks: u32,
    /// Number of ticks whose hash was compared.
    pub compared: u32,
    /// The end of the records.
    pub end: End,
}

/// Reads a trace in place, from memory of any alignment.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'t> {
    header: Header,
    contacts: &'t [u8],
    records: &'t [u8],
    seed: u32,
}

impl<'t> Reader<'t> {
    /// Opens a trace and checks its header. Cost: the header's checksum; no memory.
    ///
    /// # Errors
    /// The first fault of the header.
    pub fn open(trace: &'t [u8]) -> Result<Self, TraceError> {
        let Read { header, contacts, bytes, checksum: seed } = Header::read(trace)?;
        let records = trace.get(bytes..).unwrap_or(&[]);
        Ok(Self { header, contacts, records, seed })
    }

    /// Returns model, scheme, settings and tools of the recording.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Returns the input ids of the contact cells, in the order of the model's cells.
    pub fn contacts(&self) -> impl ExactSizeIterator<Item = u32> + use<'t> {
        let ids = self.contacts.chunks_exact(4);
        ids.map(|id| id.first_chunk().map_or(0, |id| u32::from_le_bytes(*id)))
    }

    /// Writes the contact cells in the model to the front of `room`, and returns them.
    ///
    /// # Errors
    /// An id that is no cell, a `room` that is too short, or a trace that was recorded with tools.
    pub fn contact_cells<'r>(
        &self,
        model: &Model<'_>,
        room: &'r mut [u16],
    ) -> Result<&'r [u16], TraceError> {
        if let Some(tools) = self.header.tools {
            return Err(TraceError::Tools(tools.count));
        }
        let (needed, given) = (self.contacts().len(), room.len());
        let cells = room.get_mut(..needed);
        let cells = cells.ok_or(TraceError::Contacts { needed, room: given })?;
        for (cell, id) in cells.iter_mut().zip(self.contacts()) {
            *cell = model.cell_of_input(id).ok_or(TraceError::Contact(id))?;
        }
        Ok(cells)
    }

    /// Calls `each` with the index of each sound record, in order, and the record; an error of `each` stops
    /// the loop. Returns the end of the records. A command ends them, see [`Self::entries`].
    ///
    /// # Errors
    /// The error of `each`.
    pub fn records<E>(
        &self,
        mut each: impl FnMut(u32, &Record) -> Result<(), E>,
    ) -> Result<End, E> {
        self.walk(|index, bytes| match self.sound(index, bytes)? {
            (KIND_SAMPLE, words) => Ok(each(index, &sample(&words))),
            (kind, _) => Err(End::Kind(index, kind)),
        })
    }

    /// As [`Self::records`], with the commands between the ticks and, in a trace with tools, the tools' parts
    /// and poses: all poses of a tick come before it.
    ///
    /// # Errors
    /// The error of `each`.
    pub fn entries<E>(&self, mut each: impl FnMut(u32, &Entry) -> Result<(), E>) -> Result<End, E> {
        let (mut order, mut records) = (Order::new(self.header.tools), 0);
        let end = self.walk(|index, bytes| {
            let (kind, words) = self.sound(index, bytes)?;
            records = index.saturating_add(1);
            match order.entry(kind, &words).ok_or(End::Kind(index, kind))? {
                Some(entry) => Ok(each(index, &entry)),
                None => Ok(Ok(())),
            }
        })?;
        // Poses without their tick, or half of a part, count as a cut.
        Ok(if end == End::Complete && order.is_within() { End::Cut(records) } else { end })
    }

    fn walk<E>(
        &self,
        mut each: impl FnMut(u32, &[u8]) -> Result<Result<(), E>, End>,
    ) -> Result<End, E> {
        let mut rest = self.records;
        for index in 0_u32.. {
            if rest.iter().all(|&byte| byte == 0) {
                break;
            }
            let Some((bytes, behind)) = rest.split_at_checked(RECORD_BYTES) else {
                return Ok(End::Cut(index));
            };
            match each(index, bytes) {
                Ok(told) => told?,
                Err(End::Damaged(_)) if is_unfinished(bytes, behind) => {
                    return Ok(End::Cut(index));
                }
                Err(end) => return Ok(end),
            }
            rest = behind;
        }
        Ok(End::Complete)
    }

    /// Returns kind and words of a record whose checksum matches.
    fn sound(&self, index: u32, bytes: &[u8]) -> Result<(u16, [u32; WORDS]), End> {
        let (body, stored) = bytes.split_last_chunk().ok_or(End::Cut(index))?;
        if checksum(self.seed, index, body) != u32::from_le_bytes(*stored) {
            return Err(End::Damaged(index));
        }
        let mut words = [0; WORDS];
        for (word, bytes) in words.iter_mut().zip(body.chunks_exact(4)) {
            *word = bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        }
        let [.., kind, more, last] = words;
        let [kind, bits]: [u16; 2] = bytemuck::cast(kind);
        let [sweeps, delay]: [u16; 2] = bytemuck::cast(more);
        let known = match kind {
            KIND_SAMPLE => WITH_HASH | WITH_SWEEPS | RAMP_RESTARTED | WITH_DELAY,
            KIND_COMMAND | KIND_TOOL_COMMAND => WITH_HASH,
            KIND_PART | KIND_POSE if self.header.tools.is_some() => return Ok((kind, words)),
            _ => return Err(End::Kind(index, kind)),
        };
        let counted = sweeps == 0 || bits & WITH_SWEEPS != 0;
        let delayed = delay == 0 || (bits & WITH_DELAY != 0 && delay <= DELAY_TICKS_MAX);
        if bits & !known == 0 && counted && delayed && last == 0 {
            Ok((kind, words))
        } else {
            Err(End::Kind(index, kind))
        }
    }

    /// Replays the trace: `tick` plays each record in a tissue that begins as that of the recording, reset
    /// and with its contact cells or its tools chosen, and returns the hash of the state after the record.
    ///
    /// ```
    /// # use chaincell_kernel::{Budget, Model, Tissue, Track, trace::Reader};
    /// # fn play(trace: &[u8], model: Model<'_>) -> Option<()> {
    /// let trace = Reader::open(trace).ok()?;
    /// let network = trace.header().network(model).ok()?;
    /// let (mut tissue, mut room) = (Tissue::<512, Track>::new(), [0; 64]);
    /// tissue.reset(&network).ok()?;
    /// tissue.choose_contacts(&network, trace.contact_cells(&model, &mut room).ok()?).ok()?;
    /// let played = trace.play(|record| {
    ///     tissue.tick(&network, &[record.sample], Budget::again(record.sweeps));
    ///     tissue.view().state_hash(&model)
    /// });
    /// # played.ok().map(|_| ())
    /// # }
    /// # assert!(Reader::open(&[]).is_err());
    /// ```
    ///
    /// # Errors
    /// The first tick whose state hash differs from the recorded one.
    pub fn play(&self, mut tick: impl FnMut(&Record) -> u64) -> Result<Played, ReplayError> {
        let (mut ticks, mut compared) = (0, 0);
        let end = self.records(|record, of| {
            let here = tick(of);
            ticks += 1;
            compared += u32::from(of.compare(record, here)?);
            Ok(())
        })?;
        Ok(Played { ticks, compared, end })
    }
}

/// Returns true if the writer was stopped within this record, the last one: it stores the checksum last.
fn is_unfinished(record: &[u8], behind: &[u8]) -> bool {
    record.ends_with(&[0; 4]) && behind.iter().all(|&byte| byte == 0)
}
