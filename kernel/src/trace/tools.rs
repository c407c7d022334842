//! Tools in a trace: their parts, and their poses in each tick.

use super::record::{WORDS, command, sample};
use super::{
    Entry, KIND_COMMAND, KIND_PART, KIND_POSE, KIND_SAMPLE, KIND_TOOL_COMMAND, RECORD_BYTES, Writer,
};
use crate::terms::surface::{PARTS_MAX, TOOLS_MAX};
use crate::tick::pose::{ToolPart, ToolPose};
use crate::tick::tools::FRICTION_MAX;

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

/// Numbers of the two records of a part.
const SIZE: u8 = 0;
const ORIENTATION: u8 = 1;

impl Writer {
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
        let PoseRecord { tool, pose: ToolPose { position_m, orientation, engaged } } = *record;
        let [x, y, z] = position_m.data.0[0].map(f32::to_bits);
        let [i, j, k, w] = orientation.map(f32::to_bits);
        self.seal([x, y, z, engaged, i, j, k, w, KIND_POSE.into(), tool.into(), 0])
    }
}

/// Checks the order of the records of a trace.
#[derive(Debug)]
pub(super) struct Order {
    /// Tools of the trace.
    tools: u32,
    /// Tool whose pose comes next.
    next: u32,
    /// True once a record other than a part has come: no parts may follow.
    has_begun: bool,
    /// First record of a part whose second is missing.
    size: Option<[u32; WORDS]>,
}

impl Order {
    pub(super) fn new(tools: Option<RecordedTools>) -> Self {
        let tools = tools.map_or(0, |tools| tools.count);
        Self { tools, next: 0, has_begun: false, size: None }
    }

    /// Returns true if the last tick or the last part is incomplete.
    pub(super) fn is_within(&self) -> bool {
        self.next > 0 || self.size.is_some()
    }

    /// Returns the content of a record; the inner `None` for the first record of a part, the outer one for a
    /// record that is not allowed at its place.
    pub(super) fn entry(&mut self, kind: u16, words: &[u32; WORDS]) -> Option<Option<Entry>> {
        if kind == KIND_PART {
            return self.part(words);
        }
        if self.size.is_some() {
            return None;
        }
        self.has_begun = true;
        match kind {
            KIND_SAMPLE if self.next == self.tools => {
                self.next = 0;
                Some(Some(Entry::Tick(sample(words))))
            }
            KIND_COMMAND | KIND_TOOL_COMMAND if self.next == 0 => {
                Some(Some(Entry::Command(command(words)?)))
            }
            KIND_POSE if self.next < self.tools => {
                let record = pose(words).filter(|of| u32::from(of.tool) == self.next)?;
                self.next += 1;
                Some(Some(Entry::Pose(record)))
            }
            _ => None,
        }
    }

    fn part(&mut self, words: &[u32; WORDS]) -> Option<Option<Entry>> {
        let [i, j, k, w, a, b, c, none, kind, of, zero] = *words;
        let [tool, part, which, empty] = of.to_le_bytes();
        let is_sound = !self.has_begun
            && kind == u32::from(KIND_PART)
            && u32::from(tool) < self.tools
            && usize::from(part) < PARTS_MAX
            && (none, zero, empty) == (0, 0, 0);
        match (self.size.take(), which) {
            _ if !is_sound => None,
            (None, SIZE) => {
                self.size = Some(*words);
                Some(None)
            }
            (Some([x, y, z, radius, e, f, g, _, _, first, _]), ORIENTATION)
                if first.to_le_bytes() == [tool, part, SIZE, 0] && [a, b, c] == [0; 3] =>
            {
                let shape = ToolPart {
                    centre_m: [x, y, z].map(f32::from_bits),
                    orientation: [i, j, k, w].map(f32::from_bits),
                    half_m: [e, f, g].map(f32::from_bits),
                    radius_m: f32::from_bits(radius),
                };
                Some(Some(Entry::Part(PartRecord { tool, part, shape })))
            }
            _ => None,
        }
    }
}

fn pose(words: &[u32; WORDS]) -> Option<PoseRecord> {
    let [x, y, z, engaged, i, j, k, w, kind, tool, zero] = *words;
    let tool = u8::try_from(tool).ok()?;
    let position_m = [x, y, z].map(f32::from_bits).into();
    let orientation = [i, j, k, w].map(f32::from_bits);
    let pose = ToolPose { position_m, orientation, engaged };
    (kind == u32::from(KIND_POSE) && zero == 0).then_some(PoseRecord { tool, pose })
}
