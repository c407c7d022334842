//! Decoding of the records of a trace one by one, as they arrive.

use super::end::End;
use super::header::RecordedTools;
use super::order::Order;
use super::record::{
    CommandRecord, Entry, RAMP_RESTARTED, WITH_DELAY, WITH_HASH, WITH_SWEEPS, WORDS, checksum,
    command,
};
use super::{KIND_COMMAND, KIND_PART, KIND_POSE, KIND_SAMPLE, KIND_TOOL_COMMAND, RECORD_BYTES};
use crate::stage::DELAY_TICKS_MAX;

/// Decodes records in order, from a trace that another program still writes or sends: see
/// [`Reader::decoder`](super::Reader::decoder). Memory: 80 bytes; a record costs its checksum.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, ToolPose, Track, include_model};
/// use chaincell_kernel::trace::{End, Entry, Header, Reader, Record, Writer};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let header = Header::of::<Track>(&network).ok_or("a scheme without a code")?;
/// # let mut begun = vec![0; header.bytes(1)];
/// # let (mut writer, _) = Writer::begin(&header, &[40], &mut begun).ok_or("too short")?;
/// let mut decoder = Reader::open(&begun)?.decoder();
/// let record = writer.record(&Record::of(7, ToolPose::at([0.0; 3].into(), 1))); // 48 bytes
///
/// assert!(matches!(decoder.next(&record), Ok(Some(Entry::Tick(of))) if of.tick == 7));
/// assert_eq!(decoder.next(&record), Err(End::Damaged(1))); // it is no record 1
/// assert_eq!(decoder.index(), 1); // which is still expected
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Decoder {
    tools: Option<RecordedTools>,
    seed: u32,
    next: u32,
    order: Order,
}

impl Decoder {
    pub(super) fn new(tools: Option<RecordedTools>, seed: u32) -> Self {
        Self { tools, seed, next: 0, order: Order::new(tools) }
    }

    /// Index of the record that is expected.
    #[must_use]
    pub fn index(&self) -> u32 {
        self.next
    }

    /// Expects the record `index`, which has to follow a whole tick or a command: for a trace from which the
    /// records before it are left out.
    pub fn skip_to(&mut self, index: u32) {
        self.next = index;
        self.order.skip();
    }

    /// Returns true between the poses of a tick and the tick itself, and between the halves of a part.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.order.is_within()
    }

    /// Decodes the record that is expected; `None` for the first half of a part.
    ///
    /// # Errors
    /// A record with another checksum, or that is not known or not allowed here; it is still expected then.
    pub fn next(&mut self, record: &[u8; RECORD_BYTES]) -> Result<Option<Entry>, End> {
        let index = self.next;
        let (kind, words) = self.sound(index, record)?;
        let entry = self.order.entry(kind, &words).ok_or(End::Kind(index, kind))?;
        self.next = index.saturating_add(1);
        Ok(entry)
    }

    /// Checks the checksum and the kind of the record `index`, wherever the decoder is.
    ///
    /// # Errors
    /// As [`Self::next`].
    pub fn check(&self, index: u32, record: &[u8; RECORD_BYTES]) -> Result<(), End> {
        self.sound(index, record).map(|_| ())
    }

    /// Returns the command in the record `index`, wherever the decoder is; `None` in any other record, whose
    /// checksum is not computed.
    #[must_use]
    pub fn command(&self, index: u32, record: &[u8; RECORD_BYTES]) -> Option<CommandRecord> {
        let kind = record.get(KIND_AT..)?.first_chunk()?;
        if ![KIND_COMMAND, KIND_TOOL_COMMAND].contains(&u16::from_le_bytes(*kind)) {
            return None;
        }
        let (_, words) = self.sound(index, record).ok()?;
        command(&words)
    }

    /// Returns kind and words of a record whose checksum matches.
    pub(super) fn sound(&self, index: u32, bytes: &[u8]) -> Result<(u16, [u32; WORDS]), End> {
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
            KIND_COMMAND => WITH_HASH,
            // Its other words are those of the command.
            KIND_TOOL_COMMAND if bits & !WITH_HASH == 0 => return Ok((kind, words)),
            KIND_PART | KIND_POSE if self.tools.is_some() => return Ok((kind, words)),
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
}

/// Offset of a record's kind.
const KIND_AT: usize = 4 * (WORDS - 3);
