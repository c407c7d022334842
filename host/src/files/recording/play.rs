//! Playing a trace, as a whole or entry by entry.

use chaincell_kernel::trace::{Command, CommandRecord, End, Entry, Reader, Record, ReplayError};
use chaincell_kernel::{Budget, TickOutput, ToolPose};

use super::Mark;
use crate::engine::order::skipped;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::tools::Poses;

/// The cause of a replay that stopped before the end of the trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The state after an entry differs from the recorded one.
    Differs(ReplayError),
    /// The command of this record cannot be executed.
    Command(u32),
    /// The caller has seen enough.
    Enough,
}

/// Numbers of played entries.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Played {
    /// Ticks, including those that were answered during a pause.
    pub ticks: u32,
    /// Commands.
    pub commands: u32,
    /// Entries whose hash was compared.
    pub compared: u32,
    /// True if the first tool had a contact.
    pub has_touched: bool,
}

/// Point from which a trace is played.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Start {
    /// The replay starts after this record; `None` for the beginning.
    pub behind: Option<u32>,
    /// Last tick before it in the same trace; the number of the next one says how many samples were lost.
    pub last_tick: Option<u64>,
    /// True if the session was paused there.
    pub is_paused: bool,
}

impl Start {
    /// The place after the snapshot of `mark` in a session that `is_paused`; `first` is that from which the
    /// trace begins, if there is one.
    #[must_use]
    pub fn behind(mark: &Mark, first: Option<Mark>, is_paused: bool) -> Self {
        let last_tick = mark.last_tick(first);
        Self { behind: Some(mark.record), last_tick, is_paused }
    }
}

/// A tick or command that has been played.
#[derive(Debug, Clone, Copy)]
pub enum Step<'a> {
    /// A tick.
    Tick {
        /// Its record.
        record: &'a Record,
        /// The device's poses of all tools.
        poses: &'a [ToolPose],
        /// Its output; `None` in a pause, where nothing ticks.
        output: Option<TickOutput>,
    },
    /// A command.
    Command(&'a CommandRecord),
}

/// Plays entries one by one, as they come.
#[derive(Debug)]
pub struct Player {
    is_paused: bool,
    /// Poses of the tools in the tick whose record comes next.
    poses: Poses,
    /// Pose of the tool in a tick of held cells.
    one: [ToolPose; 1],
    last: Option<u64>,
    played: Played,
}

impl Player {
    /// A player from `start` on, for a tissue of this number of tools, 0 with held cells.
    #[must_use]
    pub fn new(tools: usize, start: Start) -> Self {
        let Start { last_tick: last, is_paused, .. } = start;
        let (poses, one) = (Poses::away(tools), [ToolPose::AWAY]);
        Self { is_paused, poses, one, last, played: Played::default() }
    }

    /// True while the session is paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Numbers of what has been played.
    #[must_use]
    pub fn played(&self) -> Played {
        self.played
    }

    /// Plays the entry of the record `index` with `tick` in place of [`TissueEngine::tick_by`], and compares
    /// the state. Returns the step that it completes; a tool's part or pose completes none.
    ///
    /// # Errors
    /// Another state than the recorded one; a command that cannot be executed.
    pub fn entry<'a, 'm>(
        &'a mut self,
        index: u32,
        entry: &'a Entry,
        tissue: &mut Staged<'m>,
        tick: impl FnOnce(&mut Staged<'m>, &[ToolPose], Budget<'_>) -> TickOutput,
    ) -> Result<Option<Step<'a>>, Stop> {
        let mut output = None;
        match entry {
            // The tissue already has its parts.
            Entry::Part(_) => return Ok(None),
            // Poses of tools precede their tick.
            Entry::Pose(record) => {
                if let Some(place) = self.poses.each_mut().get_mut(usize::from(record.tool)) {
                    *place = record.pose;
                }
                return Ok(None);
            }
            Entry::Tick(record) => {
                self.one = [record.sample];
                if !self.is_paused {
                    output = Some(self.tick(record, tissue, tick));
                }
                self.last = Some(record.tick);
                self.played.ticks += 1;
            }
            Entry::Command(record) => {
                match record.command {
                    Command::Pause => self.is_paused = true,
                    Command::Resume => self.is_paused = false,
                    Command::Snapshot { .. } => {}
                    command => tissue.command(&command).map_err(|_| Stop::Command(index))?,
                }
                self.played.commands += 1;
            }
        }
        // Compare the state with the recorded hash.
        let found = entry.compare(index, tissue.state_hash()).map_err(Stop::Differs)?;
        self.played.compared += u32::from(found);
        Ok(match entry {
            Entry::Tick(record) => Some(Step::Tick { record, poses: self.poses(tissue), output }),
            Entry::Command(record) => Some(Step::Command(record)),
            Entry::Part(_) | Entry::Pose(_) => None,
        })
    }

    /// The poses of a tick.
    fn poses(&self, tissue: &Staged<'_>) -> &[ToolPose] {
        if tissue.tools() > 0 { self.poses.each() } else { &self.one }
    }

    /// Repeats a tick with all that the clock decided.
    fn tick<'m>(
        &mut self,
        record: &Record,
        tissue: &mut Staged<'m>,
        tick: impl FnOnce(&mut Staged<'m>, &[ToolPose], Budget<'_>) -> TickOutput,
    ) -> TickOutput {
        if record.ramp_restarted {
            tissue.restart_ramp();
        }
        tissue.skipped(self.last.map_or(0, |last| skipped(last, record.tick)));
        if let Some(ticks) = record.delay_ticks {
            tissue.delayed(ticks);
        }
        let answer = tick(tissue, self.poses(tissue), Budget::again(record.sweeps));
        self.played.has_touched |= answer.contacts > 0;
        answer
    }
}

/// Plays a trace with its commands and pauses, and compares the states. The tissue has to be in the recorded
/// state of the start. During a pause neither tissue nor stage ticks; a reset resets both. `after` is called after
/// every step, and returns false to end there, with [`Stop::Enough`].
///
/// # Errors
/// The cause of the stop; `played` then counts the entries before it.
pub fn play<'m>(
    trace: &Reader<'_>,
    tissue: &mut Staged<'m>,
    start: Start,
    played: &mut Played,
    after: impl FnMut(&mut Staged<'m>, Step<'_>) -> bool,
) -> Result<End, Stop> {
    let tick = |tissue: &mut Staged<'m>, poses: &[ToolPose], budget: Budget<'_>| {
        tissue.tick_by(poses, budget)
    };
    play_steps(trace, tissue, start, played, tick, after)
}

/// As [`play`] to the end, with `tick` in place of [`TissueEngine::tick_by`]: it leaves the same state.
///
/// # Errors
/// As [`play`].
pub fn play_by<'m>(
    trace: &Reader<'_>,
    tissue: &mut Staged<'m>,
    start: Start,
    played: &mut Played,
    tick: impl FnMut(&mut Staged<'m>, &[ToolPose], Budget<'_>) -> TickOutput,
) -> Result<End, Stop> {
    play_steps(trace, tissue, start, played, tick, |_, _| true)
}

/// As [`play`], by `tick`.
fn play_steps<'m>(
    trace: &Reader<'_>,
    tissue: &mut Staged<'m>,
    start: Start,
    played: &mut Played,
    mut tick: impl FnMut(&mut Staged<'m>, &[ToolPose], Budget<'_>) -> TickOutput,
    mut after: impl FnMut(&mut Staged<'m>, Step<'_>) -> bool,
) -> Result<End, Stop> {
    let mut player = Player::new(tissue.tools(), start);
    let end = trace.entries(|index, entry| {
        // Skip the entries before the start.
        if start.behind.is_some_and(|behind| index <= behind) {
            return Ok(());
        }
        match player.entry(index, entry, tissue, &mut tick)? {
            Some(step) if !after(tissue, step) => Err(Stop::Enough),
            _ => Ok(()),
        }
    });
    *played = player.played();
    end
}
