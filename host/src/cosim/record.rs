//! Keeps poses as received and their answers, in memory taken beforehand.

use super::payload::{ToolForce, ToolPose};

/// Ticks of a session, up to a capacity.
#[derive(Debug, Clone, Default)]
pub struct Recorder {
    rows: Vec<(ToolPose, ToolForce)>,
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
        Self { rows, capacity_ticks, left_out_ticks: 0 }
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
