//! Runs the tissue of a session from its records, in lock step, and compares every recorded hash.

use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use chaincell_kernel::trace::{Decoder, End, RECORD_BYTES, Reader, ReplayError};
use chaincell_kernel::{Flags, TOOLS_MAX, TickOutput};
use serde::Serialize;

use super::frame::{Ask, Frame};
use super::intake::{Come, Intake};
use crate::bake::ImageBytes;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::tools::Poses;
use crate::error::{Error, Result};
use crate::files::recording::{Player, Start, Step, Stop, seal_of, seal_of_begun};
use crate::files::snapshot::SessionSnapshot;
use crate::interrupt;
use crate::session::ipc::payload::StateHeader;
use crate::session::ipc::shown::ShowPorts;
use crate::session::timing::clock::now_ns;
use crate::terminal;

/// Time between looks for viewers while no record comes.
const LOOK: Duration = Duration::from_millis(5);
/// Pause before a stream is opened again.
const AGAIN: Duration = Duration::from_millis(100);

/// A session as a follower joined it.
#[derive(Debug)]
pub struct Joined {
    /// Header and parts of the trace.
    pub begun: Vec<u8>,
    /// The model's image, if the mirror sent it.
    pub image: Option<ImageBytes>,
    /// The snapshot to begin from.
    pub start: Option<Begin>,
    /// The first frame after them.
    first: Option<Frame>,
}

/// A snapshot from which a follower begins.
#[derive(Debug)]
pub struct Begin {
    /// The snapshot.
    pub snapshot: SessionSnapshot,
    /// Its checksum.
    pub checksum: u32,
    records: u32,
    seal: u32,
    last_tick: u64,
}

/// Opens the stream, for which it waits at most until `end_ns`, and receives all that the tissue is built from;
/// `model` is the checksum of a model that is here.
///
/// # Errors
/// No stream; a mirror that refuses; a stream that ends before the first record.
pub fn join(intake: &mut Intake, model: Option<u32>, end_ns: u64) -> Result<Joined> {
    let mut is_told = false;
    loop {
        let joined = try_to_join(intake, model);
        interrupt::check()?;
        match joined {
            Err(why) if now_ns() < end_ns => {
                if !is_told {
                    terminal::note(format_args!("note: {why}; waiting for it"));
                }
                is_told = true;
                sleep(AGAIN);
            }
            joined => return joined,
        }
    }
}

fn try_to_join(intake: &mut Intake, model: Option<u32>) -> Result<Joined> {
    intake.open(&Ask { goes_on: None, model, packed: true })?;
    let mut joined = Joined { begun: Vec::new(), image: None, start: None, first: None };
    loop {
        interrupt::check()?;
        let frame = match intake.next(LOOK) {
            Come::Frame(frame) => frame,
            Come::Nothing => continue,
            Come::Cut(why) => {
                return Err(Error::input(format!(
                    "{why} before the session began: look for what the mirror says, and start again"
                )));
            }
        };
        match frame {
            Frame::Begun(begun) => joined.begun = begun,
            Frame::Model(image) => joined.image = Some(ImageBytes::copy(&image)),
            Frame::Start { records, seal, last_tick, snapshot } => {
                let (snapshot, checksum) = SessionSnapshot::of(&snapshot)
                    .map_err(|why| Error::input(format!("its snapshot: {why}")))?;
                joined.start = Some(Begin { snapshot, checksum, records, seal, last_tick });
            }
            Frame::Refused(why) => return Err(Error::input(format!("the mirror says: {why}"))),
            Frame::Records { .. } | Frame::Alive { .. } | Frame::End { .. } => {
                joined.first = Some(frame);
                return Ok(joined);
            }
            Frame::Ask(_) => return Err(Error::input("it is another follower, and no mirror")),
        }
    }
}

/// What was followed.
#[derive(Debug, Clone, Default, Serialize)]
pub struct FollowReport {
    /// Ticks that were run, without those before the snapshot that it began from.
    pub ticks: u32,
    /// Commands.
    pub commands: u32,
    /// Hashes that were compared, all equal.
    pub hashes_compared: u32,
    /// Number of the last tick.
    pub last_tick: u64,
    /// Hash of the last state.
    pub state_hash: String,
    /// Times that the stream was cut.
    pub cuts: u32,
    /// Most ticks by which the tissue was behind the trace when a frame came, besides those that it made up when it
    /// joined and after a cut.
    pub largest_lag_ticks: u32,
    /// Ticks and commands for which the follower's own trace had no room.
    pub ticks_unrecorded: u64,
    /// True if the recording has ended, and all of it was followed.
    pub has_ended: bool,
    /// True if it ended since its program was killed.
    pub was_killed: bool,
    /// The first tick that came out otherwise.
    pub first_difference: Option<Difference>,
}

/// A tick that came out otherwise.
#[derive(Debug, Clone, Serialize)]
pub struct Difference {
    /// Index of its record.
    pub record: u32,
    /// Its number.
    pub tick: u64,
    /// The recorded hash.
    pub recorded_state_hash: String,
    /// The hash here.
    pub followed_state_hash: String,
}

/// What a follower is told about as it goes.
#[derive(Debug, Clone, Copy)]
pub enum Told<'a> {
    /// A tick or a command, with the poses of the tools; a state of the tissue comes after it.
    Step(Step<'a>),
    /// The stream was cut, or could not be opened again.
    Cut(&'a str),
    /// It is there again.
    Again,
    /// Some time has passed.
    Look {
        /// Number of the last tick.
        tick: u64,
        /// Ticks that the mirror has named and that have not been run.
        lag_ticks: u32,
        /// Hashes that were compared.
        hashes_compared: u32,
    },
}

/// A tissue that follows a session.
pub struct Follower<'a, 'm> {
    intake: Intake,
    tissue: &'a mut Staged<'m>,
    show: Option<ShowPorts>,
    decoder: Decoder,
    player: Player,
    seal: u32,
    newest: u32,
    last: Last,
    /// True until the first records and those of a cut are made up.
    is_catching_up: bool,
    report: FollowReport,
    differs: Option<ReplayError>,
}

/// The last tick, for viewers.
#[derive(Debug, Clone, Copy)]
struct Last {
    tick: u64,
    ticks: u64,
    output: TickOutput,
    poses: Poses,
}

impl<'a, 'm> Follower<'a, 'm> {
    /// A follower whose tissue is in the state of the start of `joined`.
    ///
    /// # Errors
    /// A header that is none.
    pub fn new(
        intake: Intake,
        joined: &Joined,
        tissue: &'a mut Staged<'m>,
        show: Option<ShowPorts>,
    ) -> Result<Self> {
        let trace = Reader::open(&joined.begun)
            .map_err(|why| Error::input(format!("cannot follow: {why}")))?;
        let mut decoder = trace.decoder();
        // The parts of the tools are records: the tissue has them already.
        let parts_at = trace.header().bytes(trace.contacts().len());
        let (parts, _) = joined.begun[parts_at..].as_chunks::<RECORD_BYTES>();
        for part in parts {
            decoder.next(part).map_err(|why| Error::input(format!("cannot follow: {why}")))?;
        }
        let mut start = Start::default();
        if let Some(begin) = &joined.start {
            decoder.skip_to(begin.records);
            start.is_paused = begin.snapshot.is_paused;
            start.last_tick = Some(begin.last_tick).filter(|&tick| tick > 0);
        }
        let tick = joined.start.as_ref().map_or(0, |begin| begin.snapshot.tick);
        let poses = Poses::away(tissue.tools());
        Ok(Self {
            intake,
            player: Player::new(tissue.tools(), start),
            tissue,
            show,
            newest: decoder.index(),
            decoder,
            seal: joined.start.as_ref().map_or(seal_of_begun(&joined.begun), |begin| begin.seal),
            last: Last { tick, ticks: 0, output: TickOutput::NONE, poses },
            is_catching_up: true,
            report: FollowReport::default(),
            differs: None,
        })
    }

    /// Follows until the recording ends, or a tick differs.
    ///
    /// # Errors
    /// A mirror that refuses; a damaged trace; a stream that comes once and is cut; Ctrl-C.
    pub fn run(
        &mut self,
        joined: Joined,
        mut told: impl FnMut(&mut Staged<'m>, Told<'_>) -> Result<()>,
    ) -> Result<()> {
        let mut frame = joined.first;
        loop {
            interrupt::check()?;
            if let Some(frame) = frame.take()
                && self.take(frame, &mut told)?
            {
                return Ok(());
            }
            self.show();
            let (lag_ticks, tick) = (self.lag_ticks(), self.last.tick);
            let hashes_compared = self.player.played().compared;
            told(self.tissue, Told::Look { tick, lag_ticks, hashes_compared })?;
            match self.intake.next(LOOK) {
                Come::Frame(come) => frame = Some(come),
                Come::Nothing => {}
                Come::Cut(why) => {
                    // The mirror in this process ends by the same Ctrl-C.
                    interrupt::check()?;
                    self.connect(&why, &mut told)?;
                }
            }
        }
    }

    /// Connects again, and asks for what is missing.
    fn connect(
        &mut self,
        why: &str,
        told: &mut impl FnMut(&mut Staged<'m>, Told<'_>) -> Result<()>,
    ) -> Result<()> {
        self.report.cuts += 1;
        self.is_catching_up = true;
        told(self.tissue, Told::Cut(why))?;
        let goes_on = Some((self.seal, self.decoder.index()));
        self.intake.open_again(&Ask { goes_on, model: None, packed: true }, why, AGAIN)?;
        told(self.tissue, Told::Again)
    }

    /// Takes a frame. Returns true at the end of the session.
    fn take(
        &mut self,
        frame: Frame,
        told: &mut impl FnMut(&mut Staged<'m>, Told<'_>) -> Result<()>,
    ) -> Result<bool> {
        match frame {
            Frame::Records { first, newest, bytes } => {
                self.note_newest(newest);
                self.take_records(first, &bytes, told)
            }
            Frame::Alive { newest } => {
                self.note_newest(newest);
                Ok(false)
            }
            Frame::End { is_whole, .. } => {
                (self.report.has_ended, self.report.was_killed) = (true, !is_whole);
                Ok(true)
            }
            Frame::Refused(why) => Err(Error::input(format!("the mirror says: {why}"))),
            // A mirror begins anew after a cut.
            Frame::Begun(_) => Ok(false),
            Frame::Model(_) | Frame::Start { .. } | Frame::Ask(_) => Err(Error::input(
                "the mirror sent the session from its beginning: a program between them has to hand on the \
                     words that `follow` adds, as \"$@\" does in a script; start the follower again",
            )),
        }
    }

    /// Notes how many records the trace has: outside of a cut, how far the tissue was behind.
    fn note_newest(&mut self, newest: u32) {
        if !self.is_catching_up {
            self.report.largest_lag_ticks = self.report.largest_lag_ticks.max(self.lag_ticks());
        }
        self.newest = newest;
    }

    /// Ticks that the trace has and that have not been run, see [`lag_ticks`].
    fn lag_ticks(&self) -> u32 {
        lag_ticks(self.newest.saturating_sub(self.decoder.index()), self.tissue.tools())
    }

    /// Runs records, without those that have been run. Returns true if a tick differs.
    fn take_records(
        &mut self,
        first: u32,
        bytes: &[u8],
        told: &mut impl FnMut(&mut Staged<'m>, Told<'_>) -> Result<()>,
    ) -> Result<bool> {
        let next = self.decoder.index();
        if first > next {
            return Err(Error::check(format!(
                "the mirror left out the records {next} to {}: start the follower again",
                first - 1
            )));
        }
        let (records, _) = bytes.as_chunks::<RECORD_BYTES>();
        for record in records.iter().skip((next - first) as usize) {
            interrupt::check()?;
            if self.run_record(record, told)? {
                return Ok(true);
            }
        }
        if self.decoder.index() >= self.newest {
            self.is_catching_up = false;
        }
        Ok(false)
    }

    /// Runs one record. Returns true if it differs.
    fn run_record(
        &mut self,
        record: &[u8; RECORD_BYTES],
        told: &mut impl FnMut(&mut Staged<'m>, Told<'_>) -> Result<()>,
    ) -> Result<bool> {
        let index = self.decoder.index();
        let entry = self
            .decoder
            .next(record)
            .map_err(|why: End| Error::input(format!("cannot follow: {why}")))?;
        self.seal = seal_of(record);
        let Some(entry) = entry else { return Ok(false) };
        let step = self.player.entry(index, &entry, self.tissue, |tissue, poses, budget| {
            tissue.tick_by(poses, budget)
        });
        let step = match step {
            Ok(step) => step,
            Err(Stop::Differs(why)) => {
                self.differs = Some(why);
                self.report.first_difference = Some(Difference {
                    record: why.record,
                    tick: why.tick,
                    recorded_state_hash: format!("{:016x}", why.recorded),
                    followed_state_hash: format!("{:016x}", why.here),
                });
                return Ok(true);
            }
            Err(Stop::Command(record)) => {
                return Err(Error::input(format!(
                    "cannot follow: the command of record {record} does not fit the model: take the same release \
                     on both sides"
                )));
            }
            Err(Stop::Enough) => return Ok(true),
        };
        if let Some(step) = step {
            if let Step::Tick { record, poses, output } = step {
                self.last.tick = record.tick;
                self.last.ticks += 1;
                self.last.output = output.unwrap_or(rest(&self.last.output));
                self.last.poses = Poses::of(poses);
            }
            told(self.tissue, Told::Step(step))?;
            if let Some(show) = &mut self.show {
                show.changed();
            }
            self.show();
        }
        Ok(false)
    }

    /// Sends to viewers what is due.
    fn show(&mut self) {
        let Some(show) = &mut self.show else { return };
        let header = StateHeader {
            tick: self.last.tick,
            ticks_answered: self.last.ticks,
            flags: self.last.output.flags.0,
            model_checksum: self.tissue.model_checksum(),
            ..StateHeader::default()
        };
        show.show(now_ns(), header, self.last.poses.each(), self.tissue);
    }

    /// The session between its last tick and the next one, with its tissue; `begun` is what its trace begins
    /// with, and `publisher` the id of the one in charge, 0 if that is unknown. A tool counts as released if it
    /// was engaged in the last tick.
    ///
    /// # Errors
    /// A tissue that cannot be saved.
    pub fn snapshot(&mut self, begun: &[u8], publisher: u128) -> Result<SessionSnapshot> {
        let mut released = [false; TOOLS_MAX];
        for (released, pose) in released.iter_mut().zip(self.last.poses.each()) {
            *released = pose.engaged == 1;
        }
        let saved = self.tissue.saved();
        Ok(SessionSnapshot {
            tick: self.last.tick,
            publisher,
            released,
            is_paused: self.player.is_paused(),
            begun: begun.to_vec(),
            saved: saved.ok_or_else(|| Error::check("the tissue cannot be saved"))?,
        })
    }

    /// Checks that no tick has come out otherwise; `session` names what is followed.
    ///
    /// # Errors
    /// The first tick that differs.
    pub fn check_same(&self, session: &Path) -> Result<()> {
        match self.differs {
            None => Ok(()),
            Some(why) => Err(Error::check(format!("{}: {why}", session.display()))),
        }
    }

    /// What was followed so far.
    pub fn report(&mut self) -> FollowReport {
        let played = self.player.played();
        FollowReport {
            ticks: played.ticks,
            commands: played.commands,
            hashes_compared: played.compared,
            last_tick: self.last.tick,
            state_hash: format!("{:016x}", self.tissue.state_hash()),
            ..self.report.clone()
        }
    }
}

/// Ticks of a number of records, rounded up: a tick has one record, and another one for each tool.
fn lag_ticks(records: u32, tools: usize) -> u32 {
    records.div_ceil(1 + tools as u32)
}

/// The output in a pause: nothing ticks.
fn rest(last: &TickOutput) -> TickOutput {
    TickOutput {
        flags: Flags::SAFE_STATE,
        energy_j: last.energy_j,
        contacts: last.contacts,
        ..TickOutput::NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_of_two_tools_is_three_records() {
        assert_eq!([0, 1, 3, 4, 12].map(|records| lag_ticks(records, 2)), [0, 1, 1, 2, 4]);
        assert_eq!([0, 1, 12].map(|records| lag_ticks(records, 0)), [0, 1, 12]);
    }
}
