//! Records the received poses and their answers, in preallocated memory and in a trace on disk.

use chaincell_kernel::ToolPose;
use chaincell_kernel::trace::{CommandRecord, Record};

use crate::engine::motion::Pose;
use crate::engine::tools::Felt;
use crate::error::Result;
use crate::files::recording::TraceFile;
use crate::session::ipc::tools::TickForce;

/// Largest number of commands in a trace, besides the records of its ticks.
const COMMANDS_MAX: usize = 4096;

/// A recorded tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The executed pose, with the sweeps of the tick.
    pub pose: Pose,
    /// The tissue's answer.
    pub force: TickForce,
    /// True if the output stage's ramp was restarted before the tick.
    pub ramp_restarted: bool,
    /// Delay passed to the output stage before the tick, if it is measured \[ticks\].
    pub delay_ticks: Option<u16>,
}

impl Row {
    /// Creates the row of a tick without an output stage.
    #[must_use]
    pub fn of(pose: Pose, force: TickForce) -> Self {
        Self { pose, force, ramp_restarted: false, delay_ticks: None }
    }
}

/// Pose and output of a tool in a tick, for tools that are defined by their parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolRow {
    /// The executed pose.
    pub pose: ToolPose,
    /// The output.
    pub felt: Felt,
}

/// Ticks of a session, up to a capacity. From the first tick that did not fit on all are left out, so that
/// the recording has no gap.
#[derive(Debug, Default)]
pub struct Recorder {
    rows: Vec<Row>,
    /// Rows of the tools in each of these ticks, tick by tick.
    tool_rows: Vec<ToolRow>,
    keeps_rows: bool,
    trace: Option<TraceFile>,
    capacity_ticks: usize,
    ticks: usize,
    commands: usize,
    left_out_ticks: u64,
}

impl Recorder {
    /// Returns the number of records that a trace of `ticks` ticks needs, with `tools` tools that are defined
    /// by their parts.
    #[must_use]
    pub fn trace_records(ticks: usize, tools: usize) -> usize {
        ticks.saturating_mul(tools + 1).saturating_add(COMMANDS_MAX)
    }

    /// Creates a recorder with memory for `capacity_ticks` ticks; with 0 it records nothing.
    #[must_use]
    pub fn with_capacity(capacity_ticks: usize) -> Self {
        let mut rows = Vec::new();
        // Writing every row now keeps page faults out of the loop.
        let none = Row::of(Pose::default(), TickForce::default());
        rows.resize(capacity_ticks, none);
        rows.clear();
        Self { rows, keeps_rows: true, capacity_ticks, ..Self::default() }
    }

    /// Allocates memory for the poses and outputs of `tools` tools in the recorded ticks.
    #[must_use]
    pub fn with_tools(mut self, tools: usize) -> Self {
        let none = ToolRow { pose: ToolPose::AWAY, felt: Felt::default() };
        self.tool_rows.resize(self.capacity_ticks.saturating_mul(tools), none);
        self.tool_rows.clear();
        self
    }

    /// Records `capacity_ticks` ticks in a trace only.
    #[must_use]
    pub fn on_disk(capacity_ticks: usize, trace: TraceFile) -> Self {
        Self { trace: Some(trace), capacity_ticks, ..Self::default() }
    }

    /// Records the same ticks in a trace too.
    #[must_use]
    pub fn with_trace(self, trace: TraceFile) -> Self {
        Self { trace: Some(trace), ..self }
    }

    /// Records a tick, or counts it as left out if the recorder is full. Called before the answer is sent: a
    /// controller that has the answer can rely on the record. Makes no allocation and no system call.
    pub fn record(&mut self, row: Row) {
        self.record_tools(row, &[], &[]);
    }

    /// Like [`Self::record`], with the poses and outputs of the tools that are defined by their parts.
    pub fn record_tools(&mut self, row: Row, poses: &[ToolPose], felt: &[Felt]) {
        if self.has_ended() || !self.trace(&row, poses) {
            self.left_out_ticks += 1;
            return;
        }
        if self.keeps_rows {
            self.rows.push(row);
            let each = poses.iter().zip(felt);
            self.tool_rows.extend(each.map(|(&pose, &felt)| ToolRow { pose, felt }));
        }
        self.ticks += 1;
    }

    /// Adds a tick to the trace, if there is one. Returns false if the trace is full.
    fn trace(&mut self, row: &Row, poses: &[ToolPose]) -> bool {
        let Some(trace) = &mut self.trace else { return true };
        let &Row { pose, force, ramp_restarted, delay_ticks } = row;
        let state_hash = (force.state_hash != 0).then_some(force.state_hash);
        let (sample, Pose { tick, sweeps, .. }) = (pose.into(), pose);
        let record = Record { tick, sample, sweeps, ramp_restarted, delay_ticks, state_hash };
        trace.add_tools(&record, poses)
    }

    /// Returns the executed poses in order, each with its answer. They have the received bits, except for
    /// `engaged` before the first release.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Returns the rows of all tools in these ticks, tick by tick.
    #[must_use]
    pub fn tool_rows(&self) -> &[ToolRow] {
        &self.tool_rows
    }

    /// Number of recorded ticks.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.ticks as u64
    }

    /// Returns true if a command leaves no gap in the recording: there is a free record, or none is needed
    /// since no further tick is recorded.
    #[must_use]
    pub fn has_room_for_command(&self) -> bool {
        let has_room = self.trace.as_ref().is_none_or(TraceFile::has_room);
        self.has_ended() || (self.commands < COMMANDS_MAX && has_room)
    }

    /// Returns true if ticks go on that the trace, if there is one, has no room for.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.trace.is_some() && self.left_out_ticks > 0
    }

    fn has_ended(&self) -> bool {
        self.left_out_ticks > 0 || self.ticks == self.capacity_ticks
    }

    /// Records a command after the ticks so far; call it only if [`Self::has_room_for_command`]. Does not
    /// allocate.
    pub fn command(&mut self, record: CommandRecord) {
        if self.has_ended() {
            return;
        }
        self.commands += 1;
        if let Some(trace) = &mut self.trace {
            trace.add_command(&record);
        }
    }

    /// Number of ticks that did not fit.
    #[must_use]
    pub fn left_out_ticks(&self) -> u64 {
        self.left_out_ticks
    }

    /// Ends the trace and cuts it to its length.
    ///
    /// # Errors
    /// The system's error, with the path.
    pub fn finish_trace(&mut self) -> Result<()> {
        self.trace.take().map_or(Ok(()), TraceFile::finish)
    }
}

#[cfg(test)]
mod tests {
    use chaincell_kernel::trace::{Command, End, Entry, Reader};

    use super::*;
    use crate::files::recording::tests::begun;

    #[test]
    fn a_full_recorder_counts_what_it_leaves_out() {
        let mut recorder = Recorder::with_capacity(2);
        for tick in 0..5 {
            let pose = Pose { tick, ..Pose::default() };
            recorder.record(Row::of(pose, TickForce::default()));
        }
        let ticks: Vec<u64> = recorder.rows().iter().map(|row| row.pose.tick).collect();
        assert_eq!(ticks, [0, 1]);
        assert_eq!((recorder.ticks(), recorder.left_out_ticks()), (2, 3));
        assert!(!recorder.is_full(), "it has no trace");
        assert!(recorder.has_room_for_command());
    }

    /// Returns a recorder with a trace, and the trace's path.
    fn traced(ticks: usize, records: usize) -> (tempfile::TempDir, std::path::PathBuf, Recorder) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.trace");
        let trace = TraceFile::create("`out`", &path, false, begun(None), records).unwrap();
        let recorder = Recorder::with_capacity(ticks).with_trace(trace);
        (folder, path, recorder)
    }

    fn tick(recorder: &mut Recorder, tick: u64) {
        let pose = Pose { tick, ..Pose::default() };
        let force = TickForce { tick, state_hash: tick % 2, ..TickForce::default() };
        recorder.record(Row::of(pose, force));
    }

    fn command(recorder: &mut Recorder, tick: u64) -> bool {
        let room = recorder.has_room_for_command();
        if room {
            recorder.command(CommandRecord { tick, command: Command::Reset, state_hash: None });
        }
        room
    }

    /// Returns the entries of a trace: the numbers of ticks, 0 for commands.
    fn entries(path: &std::path::Path) -> (Vec<u64>, End) {
        let bytes = std::fs::read(path).unwrap();
        let mut found = Vec::new();
        let end = Reader::open(&bytes).unwrap().entries(|_, entry| {
            found.push(match entry {
                Entry::Tick(record) => {
                    assert_eq!(record.state_hash.is_some(), record.tick % 2 == 1);
                    record.tick
                }
                _ => 0,
            });
            Ok::<(), ()>(())
        });
        (found, end.unwrap())
    }

    #[test]
    fn ticks_and_commands_stand_in_the_trace_in_order() {
        let (_folder, path, mut recorder) = traced(3, 20);
        tick(&mut recorder, 1);
        assert!(command(&mut recorder, 1));
        tick(&mut recorder, 2);
        // A killed process leaves this state.
        assert_eq!(entries(&path), (vec![1, 0, 2], End::Complete));
        tick(&mut recorder, 3);
        assert!(command(&mut recorder, 3), "behind the last tick that is kept nothing counts");
        tick(&mut recorder, 4);
        recorder.finish_trace().unwrap();
        assert_eq!(entries(&path), (vec![1, 0, 2, 3], End::Complete));
        assert_eq!((recorder.ticks(), recorder.left_out_ticks()), (3, 1));
        assert_eq!(recorder.rows().len(), 3);
    }

    #[test]
    fn a_full_trace_has_no_gaps() {
        let (_folder, path, mut recorder) = traced(100, 3);
        tick(&mut recorder, 1);
        assert!(command(&mut recorder, 1));
        tick(&mut recorder, 2);
        assert!(!command(&mut recorder, 2), "no place left");
        assert!(!recorder.is_full());
        tick(&mut recorder, 3);
        tick(&mut recorder, 4);
        assert!(recorder.is_full());
        assert!(command(&mut recorder, 4), "nothing is kept any more");
        recorder.finish_trace().unwrap();
        assert_eq!(entries(&path), (vec![1, 0, 2], End::Complete));
        assert_eq!((recorder.ticks(), recorder.left_out_ticks()), (2, 2));
        assert_eq!(recorder.rows().len(), 2);
    }
}
