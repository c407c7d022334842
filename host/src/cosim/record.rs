//! Keeps poses as received and their answers, in memory taken beforehand.

use chaincell_kernel::trace::CommandRecord;

use super::payload::{ToolForce, ToolPose};

/// Commands that a recorder keeps.
const COMMANDS_MAX: usize = 4096;

/// Ticks of a session, up to a capacity.
#[derive(Debug, Clone, Default)]
pub struct Recorder {
    rows: Vec<(ToolPose, ToolForce)>,
    commands: Vec<(usize, CommandRecord)>,
    capacity_ticks: usize,
    left_out_ticks: u64,
}

impl Recorder {
    /// Room for `capacity_ticks` ticks; 0 keeps nothing.
    #[must_use]
    pub fn with_capacity(capacity_ticks: usize) -> Self {
        let mut rows = Vec::new();
        // Writing every row now keeps page faults out of the loop.
        rows.resize(capacity_ticks, (ToolPose::default(), ToolForce::default()));
        rows.clear();
        let commands = Vec::with_capacity(if capacity_ticks == 0 { 0 } else { COMMANDS_MAX });
        Self { rows, commands, capacity_ticks, left_out_ticks: 0 }
    }

    /// Keeps one tick, or counts it as left out when full. Allocates nothing.
    pub fn record(&mut self, pose: ToolPose, force: ToolForce) {
        if self.rows.len() < self.capacity_ticks {
            self.rows.push((pose, force));
        } else {
            self.left_out_ticks += 1;
        }
    }

    /// Poses that were executed, bit for bit as received, each with its answer, in order.
    #[must_use]
    pub fn rows(&self) -> &[(ToolPose, ToolForce)] {
        &self.rows
    }

    /// Whether a command may be carried out without a gap in what is kept: there is a place for
    /// it, or none is needed since no further tick is kept.
    #[must_use]
    pub fn has_room_for_command(&self) -> bool {
        self.rows.len() == self.capacity_ticks || self.commands.len() < COMMANDS_MAX
    }

    /// Keeps a command behind the ticks so far. Allocates nothing.
    pub fn command(&mut self, record: CommandRecord) {
        if self.rows.len() < self.capacity_ticks && self.commands.len() < COMMANDS_MAX {
            self.commands.push((self.rows.len(), record));
        }
    }

    /// Commands that took effect, each with the number of rows before it, in order.
    #[must_use]
    pub fn commands(&self) -> &[(usize, CommandRecord)] {
        &self.commands
    }

    /// Ticks that came after the last free row.
    #[must_use]
    pub fn left_out_ticks(&self) -> u64 {
        self.left_out_ticks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_recorder_counts_what_it_leaves_out() {
        let mut recorder = Recorder::with_capacity(2);
        for tick in 0..5 {
            let pose = ToolPose { tick, ..ToolPose::default() };
            recorder.record(pose, ToolForce::default());
        }
        let ticks: Vec<u64> = recorder.rows().iter().map(|(pose, _)| pose.tick).collect();
        assert_eq!(ticks, [0, 1]);
        assert_eq!(recorder.left_out_ticks(), 3);
    }
}
