//! The records of a trace, and how their words are read.

use core::fmt;

use nalgebra::Vector3;

use super::command::Command;
use super::{CRC, KIND_POSE, RECORD_BYTES};
use crate::contact::pose::{ToolPart, ToolPose};

/// Words of a record without its checksum.
pub(super) const WORDS: usize = RECORD_BYTES / 4 - 1;
/// A hash was taken.
pub(super) const WITH_HASH: u16 = 1;
/// The sweeps were counted.
pub(super) const WITH_SWEEPS: u16 = 2;
/// The output stage's ramp restarted.
pub(super) const RAMP_RESTARTED: u16 = 4;
/// The delay was measured.
pub(super) const WITH_DELAY: u16 = 8;

/// Numbers of the two records of a part.
pub(super) const SIZE: u8 = 0;
pub(super) const ORIENTATION: u8 = 1;

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
    /// [`DELAY_TICKS_MAX`](crate::stage::DELAY_TICKS_MAX); `None` if the delay was not measured.
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

/// A part of a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartRecord {
    /// The tool, from 0.
    pub tool: u8,
    /// The part, from 0.
    pub part: u8,
    /// Shape of the part.
    pub shape: ToolPart,
}

/// A tool's pose in the tick whose record follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseRecord {
    /// The tool, from 0.
    pub tool: u8,
    /// Its pose as executed, bit by bit.
    pub pose: ToolPose,
}

/// A command that took effect, at its place between the ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandRecord {
    /// Number of the last tick before it, 0 before the first.
    pub tick: u64,
    /// The command.
    pub command: Command,
    /// Hash of the state after it, if one was taken.
    pub state_hash: Option<u64>,
}

/// One entry of a trace.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, ToolPose, Track, include_model};
/// use chaincell_kernel::trace::{Command, CommandRecord, Entry, Header, Reader, Record, Writer};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let header = Header::of::<Track>(&network).ok_or("a scheme without a code")?;
/// # let mut trace = vec![0; header.bytes(1)];
/// # let (mut writer, _) = Writer::begin(&header, &[40], &mut trace).ok_or("too short")?;
/// # trace.extend(writer.record(&Record::of(1, ToolPose::at([0.0; 3].into(), 1))));
/// # let state_hash = None;
/// # trace.extend(writer.command(&CommandRecord { tick: 1, command: Command::Reset, state_hash }));
///
/// let (mut ticks, mut commands) = (0, vec![]);
/// Reader::open(&trace)?.entries(|_index, entry| {
///     match entry {
///         Entry::Tick(_) => ticks += 1,
///         Entry::Command(record) => commands.push(record.command),
///         Entry::Part(_) | Entry::Pose(_) => {} // of tools that were chosen by their parts
///     }
///     Ok::<(), std::convert::Infallible>(())
/// })?;
/// assert_eq!((ticks, commands), (1, vec![Command::Reset]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Entry {
    /// An executed tick.
    Tick(Record),
    /// A command between two ticks.
    Command(CommandRecord),
    /// A part of a tool; parts come before all other entries.
    Part(PartRecord),
    /// A tool's pose in the next tick.
    Pose(PoseRecord),
}

impl Entry {
    /// Compares as [`Record::compare`] does; parts and poses have no hash.
    ///
    /// # Errors
    /// A different hash.
    pub fn compare(&self, index: u32, here: u64) -> Result<bool, ReplayError> {
        match self {
            Self::Tick(record) => record.compare(index, here),
            Self::Command(record) => compare(index, record.tick, record.state_hash, here),
            Self::Part(_) | Self::Pose(_) => Ok(false),
        }
    }
}

/// Returns the CRC-32 of a record at its place in its trace; `bytes` are those before the checksum.
pub(super) fn checksum(seed: u32, index: u32, bytes: &[u8]) -> u32 {
    let mut digest = CRC.digest();
    digest.update(&seed.to_le_bytes());
    digest.update(&index.to_le_bytes());
    digest.update(bytes);
    digest.finalize()
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
        sample: ToolPose::at(position_m, 0).with_acting(engaged),
        sweeps: has(words, WITH_SWEEPS).then_some(sweeps as u16),
        ramp_restarted: has(words, RAMP_RESTARTED),
        delay_ticks: has(words, WITH_DELAY).then_some((sweeps >> 16) as u16),
        state_hash: state_hash(words),
    }
}

/// Returns the command in a record; `None` if the words are no command of the record's kind.
pub(super) fn command(words: &[u32; WORDS]) -> Option<CommandRecord> {
    let [t0, t1, command, parameter, value, first, .., kind, second, third] = *words;
    let command = Command::of_record([command, parameter, value], [first, second, third])?;
    let record = CommandRecord { tick: long(t0, t1), command, state_hash: state_hash(words) };
    (kind as u16 == command.record_kind()).then_some(record)
}

/// Returns the pose in a record; `None` if the words are none.
pub(super) fn pose(words: &[u32; WORDS]) -> Option<PoseRecord> {
    let [x, y, z, engaged, i, j, k, w, kind, tool, zero] = *words;
    let tool = u8::try_from(tool).ok()?;
    let position_m = [x, y, z].map(f32::from_bits).into();
    let orientation = [i, j, k, w].map(f32::from_bits);
    let pose = ToolPose { orientation, ..ToolPose::at(position_m, 0).with_acting(engaged) };
    (kind == u32::from(KIND_POSE) && zero == 0).then_some(PoseRecord { tool, pose })
}
