//! Sends a trace while it grows: the file is read, and the session does not wait for it. For a follower that comes late
//! its server is asked for a snapshot, by a command like any other.
//!
//! Records are sent in batches of 10 ms. A record has 48 bytes, and a tick one record and another one for each tool;
//! packed, a tick of one tool takes less than half of its 96. A follower that was cut off names the record that it
//! needs next.

use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use chaincell_client::recording;
use chaincell_kernel::Model;
use chaincell_kernel::trace::{Command, RECORD_BYTES, Reader, TraceError};

use super::frame::{Ask, Frame, write_head};
use super::place::Place;
use crate::bake::ImageBytes;
use crate::error::{Error, Result};
use crate::files::recording::{MODEL, Mark, Tail, seal_of};
use crate::files::snapshot::{SessionSnapshot, place, start_place};
use crate::files::whole::folder_of;
use crate::interrupt;
use crate::session::ipc;
use crate::session::ipc::command::{CommandClient, refusal_text};
use crate::session::ipc::payload::CommandMessage;
use crate::session::ipc::services::Domain;
use crate::session::timing::clock::SECOND_NS;

/// Time between looks for new records.
const LOOK: Duration = Duration::from_millis(10);
/// Most records of a frame while no more are waiting, and while a follower catches up.
const FEW_RECORDS: usize = 128;
const MANY_RECORDS: usize = 4096;
/// Time after which a frame is sent although there is no record.
const ALIVE: Duration = Duration::from_millis(100);
/// Time without a record after which the writer is looked for.
const QUIET: Duration = Duration::from_millis(20);

/// Records behind the newest snapshot that make a follower late.
const LATE_RECORDS: u32 = 2000;
/// Longest wait for a snapshot \[ns\], and for the one that another mirror asks for.
const REPLY_NS: u64 = SECOND_NS;
const TURN: Duration = Duration::from_millis(1500);

/// A trace that is sent to one follower.
#[derive(Debug)]
pub struct Mirror {
    tail: Tail,
    place: Place,
}

/// Why a mirror stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stopped {
    /// The recording has ended, and all of it was sent.
    Ended,
    /// The follower has gone.
    Gone,
    /// The user asked to stop.
    Asked,
}

/// The error of a stream that cannot be written, such as a file on a full disk; `None` where its other end has gone, or
/// does not read.
#[must_use]
pub fn unwritten(why: &io::Error) -> Option<Error> {
    use io::ErrorKind::{BrokenPipe, ConnectionAborted, ConnectionReset, TimedOut, WouldBlock};
    match why.kind() {
        BrokenPipe | ConnectionAborted | ConnectionReset | TimedOut | WouldBlock => None,
        _ => Some(Error::input(format!("the stream to the follower cannot be written: {why}"))),
    }
}

impl Mirror {
    /// Opens a trace.
    ///
    /// # Errors
    /// As [`Tail::open`].
    pub fn open(place: &Place) -> Result<Self> {
        Ok(Self { tail: Tail::open(&place.trace)?, place: place.clone() })
    }

    /// Refuses a model that is not that of the session.
    ///
    /// # Errors
    /// That it is another one; a file that cannot be read or is no model.
    pub fn check_model(&self) -> Result<()> {
        self.model().map(|_| ())
    }

    /// Sends what is asked, then every record as it comes, until the recording ends. A follower is told of an
    /// error too.
    ///
    /// # Errors
    /// A follower of another session; a damaged trace; a missing model, or another one; a stream that cannot be
    /// written, such as a file on a full disk.
    pub fn send(&self, to: &mut impl Write, ask: &Ask) -> Result<Stopped> {
        match self.send_all(to, ask) {
            Ok(stopped) => Ok(stopped),
            Err(Failed::Stream(why)) => unwritten(&why).map_or(Ok(Stopped::Gone), Err),
            Err(Failed::Refused(why)) => {
                let _ = Frame::Refused(why.to_string()).write(to).and_then(|()| to.flush());
                Err(why)
            }
        }
    }

    fn send_all(&self, to: &mut impl Write, ask: &Ask) -> std::result::Result<Stopped, Failed> {
        // What takes time comes before the first frame, for which a follower waits longer than for the next ones.
        if ask.goes_on.is_none() {
            self.let_late_ones_begin_later();
        }
        // The session, and its model unless the follower has it.
        write_head(to)?;
        let begun = self.tail.begun();
        let trace =
            Reader::open(begun).map_err(|why| Error::file("read", self.tail.path(), why))?;
        if let Some((seal, next)) = ask.goes_on {
            self.check_same(seal, next)?;
        }
        Frame::Begun(begun.to_vec()).write(to)?;
        if ask.goes_on.is_none() && ask.model != Some(trace.header().model) {
            Frame::Model(self.model()?).write(to)?;
        }
        // The place from which the follower begins or goes on.
        let next = match ask.goes_on {
            Some((_, record)) => record,
            None => self.send_start(to)?,
        };
        to.flush()?;
        self.send_records(to, next, ask)
    }

    /// Sends the newest snapshot; returns the index of the record after it.
    fn send_start(&self, to: &mut impl Write) -> std::result::Result<u32, Failed> {
        let marks = self.tail.marks()?;
        let first = self.tail.first_record();
        let begins_from = marks.first().copied().filter(|mark| mark.record == first);
        for mark in marks.iter().rev() {
            if let Some(snapshot) = self.snapshot(mark, first) {
                let records = mark.record + 1;
                let last_tick = mark.last_tick(begins_from).unwrap_or(0);
                let seal = self.tail.seal(records)?;
                Frame::Start { records, seal, last_tick, snapshot }.write(to)?;
                return Ok(records);
            }
        }
        if begins_from.is_some_and(|mark| mark.tick > 0) {
            let why = "the snapshot that it begins from is missing: copy it to the trace";
            return Err(Error::file("mirror", self.tail.path(), why).into());
        }
        Ok(first)
    }

    /// Lets the server that writes the trace take a snapshot if the newest one is far behind; without one a follower
    /// runs all ticks since then. Of several late followers on this machine one asks for all.
    fn let_late_ones_begin_later(&self) {
        if let Err(why) = self.ask_if_late() {
            log::warn!("no snapshot for a late follower, which runs all ticks: {why}");
        }
    }

    fn ask_if_late(&self) -> Result<()> {
        // To look for the newest snapshot reads the whole trace.
        if !self.tail.is_written() || !self.is_late()? {
            return Ok(());
        }
        // The folder is locked by the one that asks; the others look again when it has asked.
        let folder = File::open(folder_of(&self.place.trace)).map_err(Error::check)?;
        let (begun, mut has_waited) = (Instant::now(), false);
        while matches!(folder.try_lock(), Err(TryLockError::WouldBlock)) && begun.elapsed() < TURN {
            interrupt::check()?;
            sleep(LOOK);
            has_waited = true;
        }
        if has_waited && !self.is_late()? {
            return Ok(());
        }
        take_snapshot(&self.place.trace)
    }

    /// Returns true if the newest snapshot is far behind the trace.
    fn is_late(&self) -> Result<bool> {
        let newest = self.tail.marks()?.last().map_or(0, |mark| mark.record);
        Ok(self.tail.count()?.saturating_sub(newest) > LATE_RECORDS)
    }

    /// The bytes of a snapshot, if its file is there.
    fn snapshot(&self, mark: &Mark, first: u32) -> Option<Vec<u8>> {
        let trace = self.tail.path();
        let start = (mark.record == first).then(|| start_place(trace));
        start.into_iter().chain([place(trace, mark.tick)]).find_map(|file| {
            let bytes = fs::read(file).ok()?;
            let (_, checksum) = SessionSnapshot::of(&bytes).ok()?;
            (checksum == mark.checksum).then_some(bytes)
        })
    }

    /// Sends records from an index on, until the recording ends.
    fn send_records(
        &self,
        to: &mut impl Write,
        mut next: u32,
        ask: &Ask,
    ) -> std::result::Result<Stopped, Failed> {
        let (mut said, mut came, mut most) = (Instant::now(), Instant::now(), MANY_RECORDS);
        let mut seal = self.tail.seal(next)?;
        while !interrupt::asked() {
            let bytes = self.tail.records(next, most)?;
            if let Some(last) = bytes.last_chunk() {
                seal = seal_of(last);
            }
            let records = (bytes.len() / RECORD_BYTES) as u32;
            if records > 0 {
                let first = next;
                next += records;
                let is_behind = records as usize == most;
                let newest = if is_behind { self.tail.count()?.max(next) } else { next };
                ask.write(&Frame::Records { first, newest, bytes }, to)?;
                to.flush()?;
                (said, came) = (Instant::now(), Instant::now());
                most = if is_behind { MANY_RECORDS } else { FEW_RECORDS };
                if is_behind {
                    continue;
                }
            } else if came.elapsed() >= QUIET && !self.tail.is_written() {
                // The last records may have come since the look.
                if self.tail.records(next, 1)?.is_empty() {
                    let is_whole = self.tail.is_whole(next)?;
                    Frame::End { newest: next, is_whole }.write(to)?;
                    to.flush()?;
                    return Ok(Stopped::Ended);
                }
            } else if said.elapsed() >= ALIVE {
                self.check_same(seal, next)?;
                Frame::Alive { newest: next }.write(to)?;
                to.flush()?;
                said = Instant::now();
            }
            sleep(LOOK);
        }
        Ok(Stopped::Asked)
    }

    /// The model's image.
    fn model(&self) -> Result<Vec<u8>> {
        let beside = self.place.trace.with_file_name(MODEL);
        let path = self.place.model.as_ref().unwrap_or(&beside);
        let bytes = fs::read(path).map_err(|why| {
            let remedy = "name the model with --model";
            Error::file("read model", path, format_args!("{why}; {remedy}"))
        })?;
        // A follower would refuse another one, and cannot name its file.
        let refused = |why: &dyn fmt::Display| Error::file("send model", path, why);
        let image = ImageBytes::copy(&bytes);
        let given = Model::from_bytes(image.as_bytes()).map_err(|why| refused(&why))?.checksum();
        let trace = Reader::open(self.tail.begun());
        let recorded =
            trace.map_err(|why| Error::file("read", self.tail.path(), why))?.header().model;
        if recorded != given {
            let why = TraceError::Model { recorded, given };
            return Err(refused(&format_args!("the session was {why}")));
        }
        Ok(bytes)
    }

    /// Checks that the file holds the session that is followed, see [`Tail::seal`].
    fn check_same(&self, seal: u32, next: u32) -> Result<()> {
        if self.tail.seal(next)? == seal {
            return Ok(());
        }
        let why =
            "it holds another session than the one that is followed: start the follower again";
        Err(Error::file("mirror", self.tail.path(), why))
    }
}

/// Lets the server that writes a trace take a snapshot, and waits until it is written.
fn take_snapshot(trace: &Path) -> Result<()> {
    let domain = Domain::default();
    let scene = recording::scene_of(trace, &domain)?;
    let scene =
        scene.ok_or_else(|| Error::input("no server on this machine shows that it writes it"))?;
    let scene = ipc::open(scene.as_deref(), &domain)?;
    let client = CommandClient::open(&scene)?;
    if !client.is_served() {
        return Err(Error::input("its server was killed"));
    }
    let command = CommandMessage::new(&Command::Snapshot { checksum: 0 });
    let reply = client.send(command, REPLY_NS, interrupt::asked)?;
    match reply.result {
        0 => Ok(()),
        _ => Err(Error::input(refusal_text(reply.reason))),
    }
}

/// Why sending failed.
#[derive(Debug)]
enum Failed {
    /// The stream.
    Stream(io::Error),
    /// The session.
    Refused(Error),
}

impl From<io::Error> for Failed {
    fn from(why: io::Error) -> Self {
        Self::Stream(why)
    }
}

impl From<Error> for Failed {
    fn from(why: Error) -> Self {
        Self::Refused(why)
    }
}
