//! Reading and replay of a trace.

use super::decoder::Decoder;
use super::end::End;
use super::error::TraceError;
use super::header::{Header, Read};
use super::record::{Entry, Record, ReplayError, sample};
use super::{KIND_SAMPLE, RECORD_BYTES};
use crate::model::Model;

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

    /// Returns a decoder of the records, at the first one.
    #[must_use]
    pub fn decoder(&self) -> Decoder {
        Decoder::new(self.header.tools, self.seed)
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
        let decoder = self.decoder();
        self.walk(|index, bytes| match decoder.sound(index, bytes)? {
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
        let mut decoder = self.decoder();
        let end = self.walk(|index, bytes| match decoder.next(bytes)? {
            Some(entry) => Ok(each(index, &entry)),
            None => Ok(Ok(())),
        })?;
        // Poses without their tick, or half of a part, count as a cut.
        let is_cut = end == End::Complete && decoder.is_within();
        Ok(if is_cut { End::Cut(decoder.index()) } else { end })
    }

    fn walk<E>(
        &self,
        mut each: impl FnMut(u32, &[u8; RECORD_BYTES]) -> Result<Result<(), E>, End>,
    ) -> Result<End, E> {
        let mut rest = self.records;
        for index in 0_u32.. {
            if rest.iter().all(|&byte| byte == 0) {
                break;
            }
            let Some((bytes, behind)) = rest.split_first_chunk() else {
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
