//! The header of a trace: model, scheme, settings and tools of the recording.

use core::fmt;

use super::stage::{self, STAGE_BYTES};
use super::{CRC, HEADER_BYTES, MAGIC, RecordedTools, VERSION, put};
use crate::model::Model;
use crate::number::Number;
use crate::solver::{Dynamics, NumberOf};
use crate::stage::{Stage, StageError, StageSettings};
use crate::tick::choice::Choice;
use crate::tick::choices::{Arithmetic, Drive, Scheme, Unloading};
use crate::tick::hash::REVISION;
use crate::tick::settings::{Network, Settings, SettingsError};

/// Bytes before the origin; the checksum is the last four.
pub(super) const COMMON_BYTES: usize = 64;
/// Flags of the optional parts of a header.
const STAGE_BIT: u16 = 1;
const TOOLS_BIT: u16 = 2;
/// Offset of the header's checksum.
const CHECKSUM_OFFSET: usize = COMMON_BYTES - 4;
/// Most contact cells: ids of cells are 16 bits wide.
const CONTACTS_MAX: usize = crate::model::image::CELLS_MAX;

/// The reason for which a trace cannot be read or played.
///
/// ```
/// use chaincell_kernel::trace::{Reader, TraceError};
///
/// let error = Reader::open(b"not a trace").unwrap_err();
/// assert_eq!(error, TraceError::Magic);
/// assert_eq!(error.to_string(), "not a chaincell trace: record one with `chaincell run --trace`");
/// ```
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
    /// The header has content that this release does not know.
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
    /// The release that wrote the trace has arithmetic with other bits than this release.
    Revision(Origin),
    /// The settings do not fit the model.
    Settings(SettingsError),
    /// The output stage's settings are out of range.
    Stage(StageError),
    /// This input id is no cell of the model.
    Contact(u32),
    /// The trace was recorded with this number of tools, chosen by their parts, not with contact cells.
    Tools(u32),
    /// The trace has more contact cells than the memory given for them.
    Contacts {
        /// Contact cells of the trace.
        needed: usize,
        /// Contact cells that fit.
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
                "format version {version} is not {VERSION}, the one that this release reads: take \
                 the release that wrote it (versions 1 and 2: chaincell 0.1; 3 and 4: 0.2 before \
                 version {VERSION}), or record again"
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
            Self::Revision(Origin { revision, release: [major, minor, patch] }) => write!(
                f,
                "recorded with revision {revision} of the arithmetic, this release has revision \
                 {REVISION}, whose ticks differ in their last bits: replay it with chaincell \
                 {major}.{minor}.{patch}"
            ),
            Self::Settings(why) => write!(f, "its settings do not fit the model: {why}"),
            Self::Stage(why) => write!(f, "its output stage cannot be: {why}"),
            Self::Contact(id) => {
                write!(f, "its contact node {id} is no cell of the model: record again")
            }
            Self::Tools(count) => write!(
                f,
                "it was recorded with {count} tools that were chosen by their parts, not with contact \
                 cells: replay it with the chaincell command"
            ),
            Self::Contacts { needed, room } => {
                write!(f, "it has {needed} contact cells, here is room for {room}")
            }
        }
    }
}

impl core::error::Error for TraceError {}

/// Returns the bytes of the header of a trace with n contact cells and no output stage; with a stage see
/// [`Header::bytes`].
#[must_use]
pub const fn header_bytes(contacts: usize) -> usize {
    (HEADER_BYTES + 4 * contacts).next_multiple_of(8)
}

/// The release that wrote a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Origin {
    /// Revision of its arithmetic, see [`REVISION`].
    pub revision: u32,
    /// Its release: major, minor, patch.
    pub release: [u16; 3],
}

impl Origin {
    /// This release.
    pub const HERE: Self = Self {
        revision: REVISION,
        release: [
            number(env!("CARGO_PKG_VERSION_MAJOR")),
            number(env!("CARGO_PKG_VERSION_MINOR")),
            number(env!("CARGO_PKG_VERSION_PATCH")),
        ],
    };
}

/// Returns the number of decimal digits.
const fn number(digits: &str) -> u16 {
    match u16::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => u16::MAX,
    }
}

/// The model, scheme, settings and tools of a recording, without its contact cells.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, Track, include_model};
/// use chaincell_kernel::stage::{Device, StageSettings};
/// use chaincell_kernel::trace::{Header, Reader, TraceError, Writer};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
///
/// let header = Header::of::<Track>(&network).ok_or("a scheme without a code")?;
/// let header = Header { stage: Some(StageSettings::for_device(Device::Falcon)), ..header };
/// let mut trace = vec![0; header.bytes(1)]; // with one contact cell
/// Writer::begin(&header, &[40], &mut trace).ok_or("too short")?;
/// assert_eq!(*Reader::open(&trace)?.header(), header);
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/box5.chaincell"));
/// # let other = Model::from_bytes(image)?;
/// assert!(matches!(header.network(other), Err(TraceError::Model { .. }))); // not the one recorded
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header {
    /// The release that wrote it.
    pub origin: Origin,
    /// Checksum of the model.
    pub model: u32,
    /// Scheme.
    pub scheme: Scheme,
    /// Number type.
    pub number: Arithmetic,
    /// Settings in force.
    pub settings: Settings,
    /// The tools, if they were chosen by their parts; then there are no contact cells.
    pub tools: Option<RecordedTools>,
    /// The output stage between the device that the samples came from and the tissue. A reset restarts it;
    /// during a pause it has no ticks.
    pub stage: Option<StageSettings>,
}

impl Header {
    /// Returns the bytes of the header with n contact cells.
    #[must_use]
    pub const fn bytes(&self, contacts: usize) -> usize {
        header_bytes(contacts) + if self.stage.is_some() { STAGE_BYTES } else { 0 }
    }

    /// Returns the output stage of the recording in its initial state. A sample of the trace goes through
    /// [`Stage::sample`] to the tissue, the tissue's answer through [`Stage::output`].
    ///
    /// # Errors
    /// Settings that are out of range.
    pub fn output_stage(&self) -> Result<Option<Stage>, TraceError> {
        self.stage.map(Stage::new).transpose().map_err(TraceError::Stage)
    }

    /// Returns the header for a network under the scheme `D`; `None` if the scheme has no code in the format.
    #[must_use]
    pub fn of<D: Dynamics>(network: &Network<'_>) -> Option<Self> {
        let number = Arithmetic::from_name(NumberOf::<D>::NAME)?;
        Some(Self::new(network, Scheme::from_name(D::NAME)?, number))
    }

    /// Returns the header for a network under a scheme and a number type.
    #[must_use]
    pub fn new(network: &Network<'_>, scheme: Scheme, number: Arithmetic) -> Self {
        Self {
            origin: Origin::HERE,
            model: network.model().checksum(),
            scheme,
            number,
            settings: *network.settings(),
            tools: None,
            stage: None,
        }
    }

    /// Writes the header with the input ids of the contact cells (in the order of the model's cells); returns
    /// its length and checksum, `None` if `to` is too short, there are too many ids, or both ids and
    /// tools are given.
    pub(super) fn write(&self, contacts: &[u32], to: &mut [u8]) -> Option<(usize, u32)> {
        // Contact cells and tools exclude each other.
        if contacts.len() > CONTACTS_MAX || (!contacts.is_empty() && self.tools.is_some()) {
            return None;
        }
        let (count, friction) =
            self.tools.map_or((0, 0), |tools| (tools.count, tools.friction.to_bits()));
        let stage_bit = if self.stage.is_some() { STAGE_BIT } else { 0 };
        let tools_bit = if self.tools.is_some() { TOOLS_BIT } else { 0 };
        // Assemble the words of the fixed part.
        let bytes = self.bytes(contacts.len());
        let to = to.get_mut(..bytes)?;
        to.fill(0);
        let settings = &self.settings;
        let [low, high]: [u32; 2] = bytemuck::cast(MAGIC);
        let codes = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        let Origin { revision, release: [major, minor, patch] } = self.origin;
        let words: [u32; HEADER_BYTES / 4] = [
            low,
            high,
            VERSION,
            bytes as u32,
            self.model,
            codes(self.scheme.code(), self.number.code()),
            codes(settings.unloading.code(), settings.drive.code()),
            settings.sweeps.into(),
            settings.step.to_bits(),
            settings.tick_time.to_bits(),
            settings.max_tool_step_m.to_bits(),
            settings.max_force_n.to_bits(),
            contacts.len() as u32,
            0,
            count,
            0,
            revision,
            codes(major, minor),
            codes(patch, stage_bit | tools_bit),
            friction,
        ];
        // Write all words, then the checksum.
        let stage = self.stage.as_ref().map(stage::words);
        let all = words.iter().chain(stage.iter().flatten()).chain(contacts);
        for (place, word) in to.chunks_exact_mut(4).zip(all) {
            put(place, *word);
        }
        let crc = checksum(to);
        put(to.get_mut(CHECKSUM_OFFSET..COMMON_BYTES)?, crc);
        Some((bytes, crc))
    }

    /// Reads the header, with the bytes of the contact cells, its length and its checksum.
    pub(super) fn read(trace: &[u8]) -> Result<Read<'_>, TraceError> {
        // Check the magic and the version.
        let magic = trace.get(..MAGIC.len()).unwrap_or(trace);
        if !MAGIC.starts_with(magic) || magic.is_empty() {
            return Err(TraceError::Magic);
        }
        let common: &[u8; COMMON_BYTES] = trace.first_chunk().ok_or(TraceError::Truncated)?;
        let words: [u32; COMMON_BYTES / 4] = bytemuck::cast(*common);
        let [_, _, version, bytes, model, kind, codes, sweeps, rest @ ..] = words;
        let [step, tick_time, max_tool_step, max_force, contacts, zero, count, stored] = rest;
        if version != VERSION {
            return Err(TraceError::Version(version));
        }
        // Check length and checksum. A damaged length must not be reported as a truncated header.
        let (bytes, contacts) = (bytes as usize, contacts as usize);
        if contacts > CONTACTS_MAX
            || [0, STAGE_BYTES].iter().all(|stage| header_bytes(contacts) + stage != bytes)
        {
            return Err(TraceError::Checksum);
        }
        let header = trace.get(..bytes).ok_or(TraceError::Truncated)?;
        if checksum(header) != stored {
            return Err(TraceError::Checksum);
        }
        // Read the rest of the fixed part and check the length against its flags.
        let (origin, parts, friction) = extension(header)?;
        let stage_bytes = if parts & STAGE_BIT != 0 { STAGE_BYTES } else { 0 };
        let front = HEADER_BYTES..HEADER_BYTES + stage_bytes;
        let has_tools = parts & TOOLS_BIT != 0;
        if bytes != header_bytes(contacts) + stage_bytes {
            return Err(TraceError::Layout);
        }
        // Decode the settings.
        let [unloading, drive]: [u16; 2] = bytemuck::cast(codes);
        let settings = Settings {
            sweeps: u16::try_from(sweeps).map_err(|_| TraceError::Layout)?,
            step: f32::from_bits(step),
            tick_time: f32::from_bits(tick_time),
            max_tool_step_m: f32::from_bits(max_tool_step),
            drive: Drive::from_code(drive).ok_or(TraceError::Layout)?,
            unloading: Unloading::from_code(unloading).ok_or(TraceError::Layout)?,
            max_force_n: f32::from_bits(max_force),
        };
        // Decode the tools, which exclude contact cells.
        let tools = match (zero, count, friction) {
            (0, 0, 0) if !has_tools => None,
            (0, ..) if has_tools && contacts == 0 => {
                Some(RecordedTools::read(count, friction).ok_or(TraceError::Layout)?)
            }
            _ => return Err(TraceError::Layout),
        };
        // Decode the output stage, the contact cells, the scheme and the number type.
        let ids = front.end..front.end + 4 * contacts;
        let stage = stage::read(header.get(front).ok_or(TraceError::Layout)?)?;
        let ids = header.get(ids).ok_or(TraceError::Layout)?;
        let [scheme, number]: [u16; 2] = bytemuck::cast(kind);
        let unknown = TraceError::Scheme(scheme, number);
        let scheme = Scheme::from_code(scheme).ok_or(unknown)?;
        let number = Arithmetic::from_code(number).ok_or(unknown)?;
        let header = Self { origin, model, scheme, number, settings, tools, stage };
        Ok(Read { header, contacts: ids, bytes, checksum: stored })
    }

    /// Returns true if the trace is one of the scheme `D`.
    #[must_use]
    pub fn is_of<D: Dynamics>(&self) -> bool {
        (self.scheme.name(), self.number.name()) == (D::NAME, NumberOf::<D>::NAME)
    }

    /// Returns the network of the recording.
    ///
    /// # Errors
    /// Another model, another revision of the arithmetic, or settings that do not fit the model.
    pub fn network<'m>(&self, model: Model<'m>) -> Result<Network<'m>, TraceError> {
        let (recorded, given) = (self.model, model.checksum());
        if recorded != given {
            return Err(TraceError::Model { recorded, given });
        }
        if self.origin.revision != REVISION {
            return Err(TraceError::Revision(self.origin));
        }
        Network::new(model, self.settings).map_err(TraceError::Settings)
    }
}

/// A header that was read.
pub(super) struct Read<'t> {
    pub(super) header: Header,
    /// The bytes of the contact cells.
    pub(super) contacts: &'t [u8],
    /// Length of the header.
    pub(super) bytes: usize,
    pub(super) checksum: u32,
}

/// Reads the release that wrote the trace, the flags of its optional parts, and the word of the friction.
fn extension(header: &[u8]) -> Result<(Origin, u16, u32), TraceError> {
    let words: &[u8; HEADER_BYTES - COMMON_BYTES] =
        header.get(COMMON_BYTES..).and_then(<[u8]>::first_chunk).ok_or(TraceError::Layout)?;
    let [revision, low, high, friction]: [u32; 4] = bytemuck::cast(*words);
    let [major, minor, patch, parts]: [u16; 4] = bytemuck::cast([low, high]);
    if parts & !(STAGE_BIT | TOOLS_BIT) != 0 {
        return Err(TraceError::Layout);
    }
    Ok((Origin { revision, release: [major, minor, patch] }, parts, friction))
}

/// Returns the CRC-32 of a header without the checksum itself.
fn checksum(header: &[u8]) -> u32 {
    let mut digest = CRC.digest();
    digest.update(header.get(..CHECKSUM_OFFSET).unwrap_or(header));
    digest.update(header.get(COMMON_BYTES..).unwrap_or(&[]));
    digest.finalize()
}
