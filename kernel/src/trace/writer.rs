//! Writing of a trace.

use super::header::Header;
use super::record::{
    CommandRecord, ORIENTATION, PartRecord, PoseRecord, RAMP_RESTARTED, Record, SIZE, WITH_DELAY,
    WITH_HASH, WITH_SWEEPS, WORDS, checksum,
};
use super::{KIND_PART, KIND_POSE, KIND_SAMPLE, RECORD_BYTES, put};
use crate::contact::pose::{ToolPart, ToolPose};

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
        // The orientation is not stored; an invalid one makes the recorded sample a bad one too.
        let engaged = if sample.turn().is_some() { sample.acting() } else { u32::MAX };
        let more = u32::from(sweeps.unwrap_or(0)) | u32::from(delay_ticks.unwrap_or(0)) << 16;
        self.encode(*tick, [x, y, z, engaged], *state_hash, [KIND_SAMPLE, bits], [more, 0])
    }

    /// Returns the bytes of the next record, for a command.
    pub fn command(&mut self, record: &CommandRecord) -> [u8; RECORD_BYTES] {
        let [command, parameter, value] = record.command.words();
        let [first, second, third] = record.command.further_words();
        let kind = record.command.record_kind();
        let of_command = [command, parameter, value, first];
        self.encode(record.tick, of_command, record.state_hash, [kind, 0], [second, third])
    }

    fn encode(
        &mut self,
        tick: u64,
        [a, b, c, d]: [u32; 4],
        state_hash: Option<u64>,
        [kind, bits]: [u16; 2],
        [more, last]: [u32; 2],
    ) -> [u8; RECORD_BYTES] {
        let low_high = |value: u64| [value as u32, (value >> 32) as u32];
        let [tick, hash] = [low_high(tick), low_high(state_hash.unwrap_or(0))];
        let bits = bits | if state_hash.is_some() { WITH_HASH } else { 0 };
        let kind = u32::from(kind) | u32::from(bits) << 16;
        self.seal([tick[0], tick[1], a, b, c, d, hash[0], hash[1], kind, more, last])
    }

    /// Returns the bytes of the next record, with these words.
    fn seal(&mut self, words: [u32; WORDS]) -> [u8; RECORD_BYTES] {
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

    /// Returns the bytes of the next two records, for a part of a tool.
    pub fn part(&mut self, record: &PartRecord) -> [[u8; RECORD_BYTES]; 2] {
        let PartRecord { tool, part, shape } = *record;
        let ToolPart { centre_m, orientation, half_m, radius_m } = shape;
        let [x, y, z] = centre_m.map(f32::to_bits);
        let [a, b, c] = half_m.map(f32::to_bits);
        let [i, j, k, w] = orientation.map(f32::to_bits);
        let kind = u32::from(KIND_PART);
        let of = |which| u32::from_le_bytes([tool, part, which, 0]);
        [
            self.seal([x, y, z, radius_m.to_bits(), a, b, c, 0, kind, of(SIZE), 0]),
            self.seal([i, j, k, w, 0, 0, 0, 0, kind, of(ORIENTATION), 0]),
        ]
    }

    /// Returns the bytes of the next record, for a tool's pose before its tick.
    pub fn pose(&mut self, record: &PoseRecord) -> [u8; RECORD_BYTES] {
        let PoseRecord { tool, pose } = *record;
        let ToolPose { position_m, orientation, .. } = pose;
        let [x, y, z] = position_m.data.0[0].map(f32::to_bits);
        let [i, j, k, w] = orientation.map(f32::to_bits);
        self.seal([x, y, z, pose.acting(), i, j, k, w, KIND_POSE.into(), tool.into(), 0])
    }
}
