//! The records of a trace: writing, reading and replay.

use core::fmt;

use nalgebra::Vector3;

use super::header::Read;
use super::tools::Order;
use super::{
    CRC, Command, CommandRecord, Entry, Header, KIND_COMMAND, KIND_PART, KIND_POSE, KIND_SAMPLE,
    KIND_TOOL_COMMAND, RECORD_BYTES, TraceError, put,
};
use crate::model::Model;
use crate::stage::DELAY_TICKS_MAX;
use crate::tick::pose::ToolPose;

/// Words of a record without its checksum.
pub(super) const WORDS: usize = RECORD_BYTES / 4 - 1;
/// A hash was taken.
const WITH_HASH: u16 = 1;
/// The sweeps were counted.
const WITH_SWEEPS: u16 = 2;
/// The output stage's ramp restarted.
const RAMP_RESTARTED: u16 = 4;
/// The delay was measured.
const WITH_DELAY: u16 = 8;

/// One executed tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Number of the tick.
    pub tick: u64,
    /// The first tool's pose as received: its position bit by bit, without its orientation.
    pub sample: ToolPose,
    /// Sweeps of the tick, 0 for a late one; `None` for those of the settings.
    pub sweeps: Option<u16>,
    /// True if the output stage's ramp restarted before it.
    pub ramp_restarted: bool,
    /// Ticks given to [`Stage::delayed`](crate::stage::Stage::delayed) before it, at most
    /// [`DELAY_TICKS_MAX`]; `None` if the delay was not measured.
    pub delay_ticks: Option<u16>,
    /// Hash of the state after it, if one was taken.
    pub state_hash: Option<u64>,
}

impl Record {
    /// Returns the record of a tick with the sweeps of the settings, without a hash.
    #[must_use]
    pub const fn of(tick: u64, sample: ToolPose) -> Self {
        let (sweeps, delay_ticks, state_hash) = (None, None, None);
        Self { tick, sample, sweeps, ramp_restarted: false, delay_ticks, state_hash }
    }

    /// Compares with `here`, the hash of the state after the tick; returns false if the record has none.
    /// `index` is the record's place in the trace.
    ///
    /// # Errors
    /// A different hash.
    pub fn compare(&self, index: u32, here: u64) -> Result<bool, ReplayError> {
        compare(index, self.tick, self.state_hash, here)
    }
}

/// See [`Record::compare`].
pub(super) fn compare(
    record: u32,
    tick: u64,
    state_hash: Option<u64>,
    here: u64,
) -> Result<bool, ReplayError> {
    match state_hash {
        Some(recorded) if recorded != here => Err(ReplayError { record, tick, recorded, here }),
        recorded => Ok(recorded.is_some()),
    }
}

/// Returns the CRC-32 of a record at its place in its trace; `bytes` are those before the checksum.
fn checksum(seed: u32, index: u32, bytes: &[u8]) -> u32 {
    let mut digest = CRC.digest();
    digest.update(&seed.to_le_bytes());
    digest.update(&index.to_le_bytes());
    digest.update(bytes);
    digest.finalize()
}

/// Encodes a trace; the caller stores the bytes.
///
/// ```
/// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
/// use chaincell_kernel::trace::{End, Header, Played, Reader, Record, Writer};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
/// # let mut log = vec![0; 1024];
/// tissue.choose_contacts(&network, &[47])?;
/// let header = Header::of::<Track>(&network).ok_or("a scheme without a code")?;
/// let (mut writer, length) = Writer::begin(&header, &[40], &mut log).ok_or("too short")?;
/// # log.truncate(length);
/// for tick in 1..=3 {
///     let sample = ToolPose::at([0.0, 0.0, -0.001 * tick as f32].into(), 1);
///     tissue.tick(&network, &[sample], Budget::All);
///     let state_hash = Some(tissue.view().state_hash(&model));
///     log.extend(writer.record(&Record { state_hash, ..Record::of(tick, sample) }));
/// }
///
/// tissue.reset(&network)?;
/// tissue.choose_contacts(&network, &[47])?;
/// let played = Reader::open(&log)?.play(|record| {
///     tissue.tick(&network, &[record.sample], Budget::All);
///     tissue.view().state_hash(&model)
/// })?;
/// assert_eq!(played, Played { ticks: 3, compared: 3, end: End::Complete }); // the same bits
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Writer {
    seed: u32,
    next: u32,
}

impl Writer {
    /// Writes the header to the front of `to` and returns its length, [`Header::bytes`]; `contacts` are the
    /// input ids of the contact cells, in the order of the model's cells. `None` if `to` is too short or
    /// there are too many ids.
    #[must_use]
    pub fn begin(header: &Header, contacts: &[u32], to: &mut [u8]) -> Option<(Self, usize)> {
        let (bytes, seed) = header.write(contacts, to)?;
        Some((Self { seed, next: 0 }, bytes))
    }

    /// Returns the bytes of the next record.
    pub fn record(&mut self, record: &Record) -> [u8; RECORD_BYTES] {
        let Record { tick, sample, sweeps, ramp_restarted, delay_ticks, state_hash } = record;
        let [x, y, z] = sample.position_m.data.0[0].map(f32::to_bits);
        let mut bits = if sweeps.is_some() { WITH_SWEEPS } else { 0 };
        bits |= if *ramp_restarted { RAMP_RESTARTED } else { 0 };
        bits |= if delay_ticks.is_some() { WITH_DELAY } else { 0 };
        let of_kind = [KIND_SAMPLE, bits, sweeps.unwrap_or(0), delay_ticks.unwrap_or(0)];
        // The orientation is not stored; an invalid one makes the recorded sample a bad one too.
        let engaged = if sample.turn().is_some() { sample.engaged } else { u32::MAX };
        self.encode(*tick, [x, y, z, engaged], *state_hash, of_kind)
    }

    /// Returns the bytes of the next record, for a command.
    pub fn command(&mut self, record: &CommandRecord) -> [u8; RECORD_BYTES] {
        let [command, parameter, value] = record.command.words();
        self.encode(
            record.tick,
            [command, parameter, value, 0],
            record.state_hash,
            [record.command.record_kind(), 0, 0, 0],
        )
    }

    fn encode(
        &mut self,
        tick: u64,
        [a, b, c, d]: [u32; 4],
        state_hash: Option<u64>,
        [kind, bits, sweeps, delay]: [u16; 4],
    ) -> [u8; RECORD_BYTES] {
        let low_high = |value: u64| [value as u32, (value >> 32) as u32];
        let [tick, hash] = [low_high(tick), low_high(state_hash.unwrap_or(0))];
        let bits = bits | if state_hash.is_some() { WITH_HASH } else { 0 };
        let kind = u32::from(kind) | u32::from(bits) << 16;
        let more = u32::from(sweeps) | u32::from(delay) << 16;
        self.seal([tick[0], tick[1], a, b, c, d, hash[0], hash[1], kind, more, 0])
    }

    /// Returns the bytes of the next record, with these words.
    pub(super) fn seal(&mut self, words: [u32; WORDS]) -> [u8; RECORD_BYTES] {
        let mut bytes = [0; RECORD_BYTES];
        for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
            put(place, word);
        }
        if let Some((body, place)) = bytes.split_last_chunk_mut::<4>() {
            *place = checksum(self.seed, self.next, body).to_le_bytes();
        }
        self.next = self.next.wrapping_add(1);
        bytes
    }
}

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

/// The first tick whose state hash differs from the recorded one.
///
/// ```
/// use chaincell_kernel::{ToolPose, trace::Record};
///
/// let record = Record { state_hash: Some(0xab), ..Record::of(7, ToolPose::at([0.0; 3].into(), 1)) };
/// let error = record.compare(6, 0xcd).unwrap_err();
/// assert!(error.to_string().starts_with("tick 7 (record 6) is the first that differs"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReplayError {
    /// Index of its record.
    pub record: u32,
    /// Number of the tick.
    pub tick: u64,
    /// Hash in the trace.
    pub recorded: u64,
    /// Hash of the replay.
    pub here: u64,
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { record, tick, recorded, here } = self;
        write!(
            f,
            "tick {tick} (record {record}) is the first that differs: state hash {recorded:016x} \
             in the trace, {here:016x} here"
        )
    }
}

impl core::error::Error for ReplayError {}

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

/// Returns the number in two words, the lower one first.
fn long(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

fn has(words: &[u32; WORDS], bit: u16) -> bool {
    let [.., kind, _, _] = *words;
    kind >> 16 & u32::from(bit) != 0
}

fn state_hash(words: &[u32; WORDS]) -> Option<u64> {
    let [.., h0, h1, _, _, _] = *words;
    has(words, WITH_HASH).then_some(long(h0, h1))
}

pub(super) fn sample(words: &[u32; WORDS]) -> Record {
    let [t0, t1, x, y, z, engaged, ..] = *words;
    let position_m = Vector3::from([x, y, z].map(f32::from_bits));
    let [.., sweeps, _] = *words;
    Record {
        tick: long(t0, t1),
        sample: ToolPose::at(position_m, engaged),
        sweeps: has(words, WITH_SWEEPS).then_some(sweeps as u16),
        ramp_restarted: has(words, RAMP_RESTARTED),
        delay_ticks: has(words, WITH_DELAY).then_some((sweeps >> 16) as u16),
        state_hash: state_hash(words),
    }
}

/// Returns the command in a record; `None` if the words are no command of the record's kind.
pub(super) fn command(words: &[u32; WORDS]) -> Option<CommandRecord> {
    let [t0, t1, command, parameter, value, zero, .., kind, _, _] = *words;
    let command = Command::from_words([command, parameter, value]).ok()?;
    let record = CommandRecord { tick: long(t0, t1), command, state_hash: state_hash(words) };
    (zero == 0 && kind as u16 == command.record_kind()).then_some(record)
}
