//! What a trace was recorded with.

use core::fmt;

use super::stage::{self, STAGE_BYTES};
use super::{CRC, HEADER_BYTES, MAGIC, NUMBERS, SCHEMES, VERSION_PLAIN, VERSION_STAGE, put};
use crate::model::Model;
use crate::number::Number;
use crate::solver::{Dynamics, NumberOf};
use crate::stage::{Stage, StageError, StageSettings};
use crate::tick::choice::Choice;
use crate::tick::choices::{Drive, Unloading};
use crate::tick::settings::{Network, Settings, SettingsError};

/// Words of the fixed part.
const WORDS: usize = HEADER_BYTES / 4;
/// Where the header's checksum stands.
const CHECKSUM_OFFSET: usize = HEADER_BYTES - 4;
/// Most contact cells: ids of cells are 16 bits wide.
const CONTACTS_MAX: usize = crate::model::image::CELLS_MAX;

/// Why a trace cannot be read or played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TraceError {
    /// The first bytes are not those of a trace.
    Magic,
    /// A format version that is not read here.
    Version(u32),
    /// The trace stops within its header.
    Truncated,
    /// The header's bytes were changed.
    Checksum,
    /// The header holds what this release does not know.
    Layout,
    /// A scheme or number type that is not known here.
    Scheme(u16, u16),
    /// The trace belongs to another model.
    Model {
        /// Checksum of the model it was recorded with.
        recorded: u32,
        /// Checksum of the model given.
        given: u32,
    },
    /// The settings do not fit the model.
    Settings(SettingsError),
    /// The output stage's settings are out of range.
    Stage(StageError),
    /// This input id is no cell of the model.
    Contact(u32),
    /// The trace was recorded with a probe of this radius \[m\], not with contact cells.
    Probe(f32),
    /// More contact cells than there is room for.
    Contacts {
        /// Contact cells of the trace.
        needed: usize,
        /// Room.
        room: usize,
    },
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Magic => {
                f.write_str("not a chaincell trace: record one with `chaincell run --trace`")
            }
            Self::Version(version) => write!(
                f,
                "format version {version} is not version {VERSION_PLAIN} or {VERSION_STAGE} that this \
                 release reads: take the release that wrote it, or record again"
            ),
            Self::Truncated => f.write_str("the trace stops within its header: copy it again"),
            Self::Checksum => {
                f.write_str("the header is damaged (its checksum does not match): copy it again")
            }
            Self::Layout => f.write_str("the header contradicts itself: record again"),
            Self::Scheme(scheme, number) => write!(
                f,
                "scheme {scheme} in number type {number} is not known here: take the release that \
                 wrote the trace"
            ),
            Self::Model { recorded, given } => write!(
                f,
                "recorded with the model of checksum {recorded:08x}, this one has {given:08x}: \
                 give the model of the recording (`chaincell info` shows the checksum)"
            ),
            Self::Settings(why) => write!(f, "its settings do not fit the model: {why}"),
            Self::Stage(why) => write!(f, "its output stage cannot be: {why}"),
            Self::Contact(id) => {
                write!(f, "its contact node {id} is no cell of the model: record again")
            }
            Self::Probe(radius_m) => write!(
                f,
                "it was recorded with a probe of radius {radius_m} m, not with contact cells: \
                 choose that probe"
            ),
            Self::Contacts { needed, room } => {
                write!(f, "it has {needed} contact cells, here is room for {room}")
            }
        }
    }
}

impl core::error::Error for TraceError {}

/// Code of a name in a table.
fn code(table: &[(&str, u16)], name: &str) -> Option<u16> {
    table.iter().find(|(known, _)| *known == name).map(|&(_, code)| code)
}

/// Name of a code in a table.
fn name(table: &[(&'static str, u16)], code: u16) -> Option<&'static str> {
    table.iter().find(|&&(_, known)| known == code).map(|&(name, _)| name)
}

/// Bytes of the header of a trace with so many contact cells and no output stage; with one see
/// [`Header::bytes`].
#[must_use]
pub const fn header_bytes(contacts: usize) -> usize {
    (HEADER_BYTES + 4 * contacts).next_multiple_of(8)
}

/// The probe of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedProbe {
    /// Radius \[m\].
    pub radius_m: f32,
    /// Contacts that the tissue had room for: the bits depend on it where that bit.
    pub capacity: u32,
}

impl RecordedProbe {
    /// From the header's two words; `None` where they are no probe.
    fn read(radius: u32, capacity: u32) -> Option<Self> {
        let radius_m = f32::from_bits(radius);
        let is_one = radius_m > 0.0 && radius_m.is_finite() && capacity as usize <= CONTACTS_MAX;
        is_one.then_some(Self { radius_m, capacity })
    }
}

/// What a trace was recorded with, but for the contact cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header {
    /// Checksum of the model.
    pub model: u32,
    /// Scheme, see [`SCHEMES`].
    pub scheme: u16,
    /// Number type, see [`NUMBERS`].
    pub number: u16,
    /// Settings in force.
    pub settings: Settings,
    /// The probe, where contact was by shape; then there are no contact cells.
    pub probe: Option<RecordedProbe>,
    /// The output stage between the device that the samples came from and the tissue. A reset
    /// begins it anew, a pause is no tick of it.
    pub stage: Option<StageSettings>,
}

impl Header {
    /// Bytes of the header with so many contact cells.
    #[must_use]
    pub const fn bytes(&self, contacts: usize) -> usize {
        header_bytes(contacts) + if self.stage.is_some() { STAGE_BYTES } else { 0 }
    }

    /// The output stage of the recording, as it began. A sample of the trace goes through
    /// [`Stage::sample`] to the tissue, the tissue's answer through [`Stage::output`].
    ///
    /// # Errors
    /// Settings that are out of range.
    pub fn output_stage(&self) -> Result<Option<Stage>, TraceError> {
        self.stage.map(Stage::new).transpose().map_err(TraceError::Stage)
    }

    /// Of a network under the scheme `D`; `None` where that has no code in the format.
    #[must_use]
    pub fn of<D: Dynamics>(network: &Network<'_>) -> Option<Self> {
        Self::named(network, D::NAME, NumberOf::<D>::NAME)
    }

    /// Of a network under a scheme and in numbers by their names; `None` where one has no code in
    /// the format.
    #[must_use]
    pub fn named(network: &Network<'_>, scheme: &str, number: &str) -> Option<Self> {
        Some(Self {
            model: network.model().checksum(),
            scheme: code(&SCHEMES, scheme)?,
            number: code(&NUMBERS, number)?,
            settings: *network.settings(),
            probe: None,
            stage: None,
        })
    }

    /// Writes the header with the input ids of the contact cells (in the order of the model's
    /// cells); gives its length and checksum, `None` where `to` is too short, the ids are too many,
    /// or stand beside a probe.
    pub(super) fn write(&self, contacts: &[u32], to: &mut [u8]) -> Option<(usize, u32)> {
        if contacts.len() > CONTACTS_MAX || (self.probe.is_some() && !contacts.is_empty()) {
            return None;
        }
        let bytes = self.bytes(contacts.len());
        let to = to.get_mut(..bytes)?;
        to.fill(0);
        let settings = &self.settings;
        let [low, high]: [u32; 2] = bytemuck::cast(MAGIC);
        let words: [u32; WORDS] = [
            low,
            high,
            if self.stage.is_some() { VERSION_STAGE } else { VERSION_PLAIN },
            bytes as u32,
            self.model,
            u32::from(self.scheme) | u32::from(self.number) << 16,
            u32::from(settings.unloading.code()) | u32::from(settings.drive.code()) << 16,
            settings.sweeps.into(),
            settings.step.to_bits(),
            settings.tick_time.to_bits(),
            settings.max_tool_step_m.to_bits(),
            settings.max_force_n.to_bits(),
            contacts.len() as u32,
            self.probe.map_or(0, |probe| probe.radius_m.to_bits()),
            self.probe.map_or(0, |probe| probe.capacity),
            0,
        ];
        let stage = self.stage.as_ref().map(stage::words);
        let all = words.iter().chain(stage.iter().flatten()).chain(contacts);
        for (place, word) in to.chunks_exact_mut(4).zip(all) {
            put(place, *word);
        }
        let crc = checksum(to);
        put(to.get_mut(CHECKSUM_OFFSET..HEADER_BYTES)?, crc);
        Some((bytes, crc))
    }

    /// Reads the header: itself, the bytes of the contact cells, its length and checksum.
    pub(super) fn read(trace: &[u8]) -> Result<(Self, &[u8], usize, u32), TraceError> {
        let magic = trace.get(..MAGIC.len()).unwrap_or(trace);
        if !MAGIC.starts_with(magic) || magic.is_empty() {
            return Err(TraceError::Magic);
        }
        let fixed: &[u8; HEADER_BYTES] = trace.first_chunk().ok_or(TraceError::Truncated)?;
        let words: [u32; WORDS] = bytemuck::cast(*fixed);
        let [_, _, version, bytes, model, kind, unloading, sweeps, rest @ ..] = words;
        let [step, tick_time, max_tool_step, max_force, contacts, radius, capacity, stored] = rest;
        let front = match version {
            VERSION_PLAIN => HEADER_BYTES,
            VERSION_STAGE => HEADER_BYTES + STAGE_BYTES,
            _ => return Err(TraceError::Version(version)),
        };
        // A damaged length must not be read as a cut.
        let (bytes, contacts) = (bytes as usize, contacts as usize);
        if contacts > CONTACTS_MAX || bytes != front - HEADER_BYTES + header_bytes(contacts) {
            return Err(TraceError::Checksum);
        }
        let header = trace.get(..bytes).ok_or(TraceError::Truncated)?;
        if checksum(header) != stored {
            return Err(TraceError::Checksum);
        }
        let [unloading, drive]: [u16; 2] = bytemuck::cast(unloading);
        let settings = Settings {
            sweeps: u16::try_from(sweeps).map_err(|_| TraceError::Layout)?,
            step: f32::from_bits(step),
            tick_time: f32::from_bits(tick_time),
            max_tool_step_m: f32::from_bits(max_tool_step),
            drive: Drive::from_code(drive).ok_or(TraceError::Layout)?,
            unloading: Unloading::from_code(unloading).ok_or(TraceError::Layout)?,
            max_force_n: f32::from_bits(max_force),
        };
        let probe = match (radius, capacity) {
            (0, 0) => None,
            _ if contacts > 0 => return Err(TraceError::Layout),
            _ => Some(RecordedProbe::read(radius, capacity).ok_or(TraceError::Layout)?),
        };
        let stage = stage::read(header.get(HEADER_BYTES..front).ok_or(TraceError::Layout)?)?;
        let ids = header.get(front..front + 4 * contacts).ok_or(TraceError::Layout)?;
        let [scheme, number]: [u16; 2] = bytemuck::cast(kind);
        Ok((Self { model, scheme, number, settings, probe, stage }, ids, bytes, stored))
    }

    /// Names of the scheme and of the number type, [`Dynamics::NAME`] and [`Number::NAME`].
    ///
    /// # Errors
    /// A scheme or a number type that is not known here.
    pub fn names(&self) -> Result<(&'static str, &'static str), TraceError> {
        let names = name(&SCHEMES, self.scheme).zip(name(&NUMBERS, self.number));
        names.ok_or(TraceError::Scheme(self.scheme, self.number))
    }

    /// Whether the trace is one of the scheme `D`.
    #[must_use]
    pub fn is_of<D: Dynamics>(&self) -> bool {
        self.names() == Ok((D::NAME, NumberOf::<D>::NAME))
    }

    /// The network of the recording.
    ///
    /// # Errors
    /// Another model, or settings that do not fit it.
    pub fn network<'m>(&self, model: Model<'m>) -> Result<Network<'m>, TraceError> {
        let (recorded, given) = (self.model, model.checksum());
        if recorded != given {
            return Err(TraceError::Model { recorded, given });
        }
        Network::new(model, self.settings).map_err(TraceError::Settings)
    }
}

/// CRC-32 of a header, but for the checksum itself.
fn checksum(header: &[u8]) -> u32 {
    let mut digest = CRC.digest();
    digest.update(header.get(..CHECKSUM_OFFSET).unwrap_or(header));
    digest.update(header.get(HEADER_BYTES..).unwrap_or(&[]));
    digest.finalize()
}
