//! The header of a trace: model, scheme, settings and tools of the recording.

use super::error::{Origin, TraceError};
use super::stage::{self, STAGE_BYTES};
use super::{CRC, HEADER_BYTES, MAGIC, VERSION, put};
use crate::contact::tools::FRICTION_MAX;
use crate::energy::surface::TOOLS_MAX;
use crate::model::Model;
use crate::number::Number;
use crate::solver::{Dynamics, NumberOf};
use crate::stage::{Stage, StageSettings};
use crate::tick::choice::Choice;
use crate::tick::choices::{Arithmetic, Scheme};
use crate::tick::hash::REVISION;
use crate::tick::settings::{Network, Settings};

/// Words before the settings.
const FRONT: usize = 6;
/// Bytes before the origin; the checksum is the last four.
pub(super) const COMMON_BYTES: usize = 4 * (FRONT + Settings::WORDS + 3);
/// Flags of the optional parts of a header.
const STAGE_BIT: u16 = 1;
const TOOLS_BIT: u16 = 2;
/// Offset of the header's checksum.
const CHECKSUM_OFFSET: usize = COMMON_BYTES - 4;
/// Most contact cells: ids of cells are 16 bits wide.
const CONTACTS_MAX: usize = crate::model::image::CELLS_MAX;

/// Returns the bytes of the header of a trace with n contact cells and no output stage; with a stage see
/// [`Header::bytes`].
#[must_use]
pub const fn header_bytes(contacts: usize) -> usize {
    (HEADER_BYTES + 4 * contacts).next_multiple_of(8)
}

/// The tools of a recording.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, ToolPart, ToolPose, Track, include_model};
/// # use chaincell_kernel::trace::{Entry, Header, Reader, Record, Writer};
/// use chaincell_kernel::trace::{PartRecord, PoseRecord, RecordedTools};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let header = Header::of::<Track>(&network).ok_or("a scheme without a code")?;
/// let header = Header { tools: Some(RecordedTools { count: 1, friction: 0.3 }), ..header };
/// let mut trace = vec![0; header.bytes(0)];
/// let (mut writer, _) = Writer::begin(&header, &[], &mut trace).ok_or("too short")?;
/// let ball = PartRecord { tool: 0, part: 0, shape: ToolPart::sphere(0.004) };
/// trace.extend(writer.part(&ball).concat());
/// let pose = ToolPose::at([0.0, 0.0, 0.05].into(), 1);
/// trace.extend(writer.pose(&PoseRecord { tool: 0, pose })); // of each tool, ahead of the tick
/// trace.extend(writer.record(&Record::of(1, pose)));
///
/// let mut kinds = vec![];
/// Reader::open(&trace)?.entries(|_index, entry| {
///     kinds.push(match entry {
///         Entry::Part(part) => ("part", part.shape.radius_m),
///         Entry::Pose(of) => ("pose", of.pose.position_m.z),
///         _ => ("tick", 0.0),
///     });
///     Ok::<(), std::convert::Infallible>(())
/// })?;
/// assert_eq!(kinds, [("part", 0.004), ("pose", 0.05), ("tick", 0.0)]); // [m]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedTools {
    /// Number of tools, 1 to 8.
    pub count: u32,
    /// Coefficient of friction.
    pub friction: f32,
}

impl RecordedTools {
    /// Reads the tools from the header's words; `None` if they are not valid.
    pub(super) fn read(count: u32, friction: u32) -> Option<Self> {
        let friction = f32::from_bits(friction);
        let is_one =
            (1..=TOOLS_MAX as u32).contains(&count) && (0.0..=FRICTION_MAX).contains(&friction);
        is_one.then_some(Self { count, friction })
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
        let [low, high]: [u32; 2] = bytemuck::cast(MAGIC);
        let codes = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        let Origin { revision, release: [major, minor, patch] } = self.origin;
        let scheme = codes(self.scheme.code(), self.number.code());
        let front: [u32; FRONT] = [low, high, VERSION, bytes as u32, self.model, scheme];
        let settings = self.settings.words();
        let release = [codes(major, minor), codes(patch, stage_bit | tools_bit)];
        let back = [contacts.len() as u32, count, 0, revision, release[0], release[1], friction];
        // Write all words, then the checksum.
        let stage = self.stage.as_ref().map(stage::words);
        let fixed = front.iter().chain(&settings).chain(&back);
        let all = fixed.chain(stage.iter().flatten()).chain(contacts);
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
        let [_, _, version, bytes, model, kind, settings @ .., contacts, count, stored] = words;
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
        let settings = Settings::from_words(settings).ok_or(TraceError::Layout)?;
        // Decode the tools, which exclude contact cells.
        let tools = match (count, friction) {
            (0, 0) if !has_tools => None,
            _ if has_tools && contacts == 0 => {
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
