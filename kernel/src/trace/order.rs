//! The order of records: parts first, then poses before their tick.

use super::header::RecordedTools;
use super::record::{Entry, ORIENTATION, PartRecord, SIZE, WORDS, command, pose, sample};
use super::{KIND_COMMAND, KIND_PART, KIND_POSE, KIND_SAMPLE, KIND_TOOL_COMMAND};
use crate::contact::pose::ToolPart;
use crate::energy::surface::PARTS_MAX;

/// Checks the order of the records of a trace.
#[derive(Debug, Clone)]
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

    /// Goes on behind a whole tick or a command.
    pub(super) fn skip(&mut self) {
        (self.next, self.has_begun, self.size) = (0, true, None);
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
