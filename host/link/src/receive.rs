//! Receives a session and writes it as the stream of one mirror: in order, each record once.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel, sync_channel};
use std::thread::sleep;
use std::time::{Duration, Instant};

use chaincell_host::error::{Error, Result};
use chaincell_host::remote::frame::{Ask, Frame, write_head};
use chaincell_host::remote::mirror::unwritten;
use chaincell_host::{interrupt, terminal};
use zenoh::query::{ConsolidationMode, Reply};
use zenoh::sample::Sample;
use zenoh::{Config, Session, Wait};

use crate::message::{Keys, Message, frame_of, to_bytes};
use crate::page::is_up_to_date;
use crate::sequence::{Heard, Sequence};
use crate::settings;

/// Messages that may wait for a reader, ten seconds of them; further ones are asked for later.
const WAITING_MESSAGES: usize = 1024;
/// Pause before the next attempt to connect, and before the same question.
const AGAIN: Duration = Duration::from_millis(100);
/// One attempt to connect of so many may take long, as over a slow link; the others end soon, as the next one after a
/// cut begins the sooner.
const LONG_EACH: u32 = 7;
/// Longest wait for an answer: that with a large model over a slow link.
const ANSWER: Duration = Duration::from_secs(120);
/// Wait for a sender after which the user hears of it. `chaincell follow` ends one of 30 s.
const SILENCE: Duration = Duration::from_secs(10);
/// Time between looks for Ctrl-C and for a reader that has gone.
const LOOK: Duration = Duration::from_millis(50);

/// Why a receiver stopped.
#[derive(Debug)]
enum Stopped {
    /// The session has ended, and all of it is written.
    Ended,
    /// Nobody reads any more.
    Gone,
    /// Another reason.
    Failed(Error),
}

impl From<Error> for Stopped {
    fn from(why: Error) -> Self {
        Self::Failed(why)
    }
}

impl From<io::Error> for Stopped {
    fn from(why: io::Error) -> Self {
        unwritten(&why).map_or(Self::Gone, Self::Failed)
    }
}

/// Writes a session to `out` until its end, for which it waits as long as it takes: what `ask` asks for, and then
/// each record as it comes. Returns early if nobody reads any more, which `is_gone` says while nothing is written.
///
/// # Errors
/// A sender that refuses, or that is not trusted; a configuration that fits no network here; Ctrl-C.
pub fn receive(
    keys: &Keys,
    config: &Config,
    ask: &Ask,
    out: &mut impl Write,
    is_gone: impl Fn() -> bool,
) -> Result<()> {
    match Intake::open(keys, config, ask, out, is_gone).and_then(|mut intake| intake.run()) {
        Ok(never) => match never {},
        Err(Stopped::Ended | Stopped::Gone) => Ok(()),
        Err(Stopped::Failed(why)) => Err(why),
    }
}

/// What does not return.
enum Never {}

/// A wait for a sender.
struct Silence {
    begin: Instant,
    is_noted: bool,
}

impl Silence {
    fn begin() -> Self {
        Self { begin: Instant::now(), is_noted: false }
    }

    /// Writes once that it is long.
    fn look(&mut self, text: impl FnOnce() -> String) {
        if !self.is_noted && self.begin.elapsed() >= SILENCE {
            self.is_noted = true;
            terminal::note(format_args!("note: for {} s {}", SILENCE.as_secs(), text()));
        }
    }
}

/// A receiver and its reader.
struct Intake<'a, W, G> {
    session: Session,
    messages: Receiver<Message>,
    keys: &'a Keys,
    sequence: Sequence,
    /// What the reader asks for.
    first: Ask,
    silence: Silence,
    out: &'a mut W,
    is_gone: G,
}

impl<'a, W: Write, G: Fn() -> bool> Intake<'a, W, G> {
    /// Connects, as often as it takes, and listens.
    fn open(
        keys: &'a Keys,
        config: &Config,
        ask: &Ask,
        out: &'a mut W,
        is_gone: G,
    ) -> std::result::Result<Self, Stopped> {
        let short = settings::hasty(config).map_err(Error::check)?;
        let (mut attempts, mut silence) = (0_u32, Silence::begin());
        let session = loop {
            let is_long = attempts.is_multiple_of(LONG_EACH);
            match settings::open(if is_long { config } else { &short }) {
                Ok(session) => break session,
                Err(why) => {
                    if attempts == 0 {
                        log::info!("not connected: {why}");
                    }
                    silence.look(|| format!("there was no connection: {why}; trying again"));
                }
            }
            if is_long {
                settings::check_connect(config)?;
            }
            attempts = attempts.wrapping_add(1);
            look(&is_gone)?;
            sleep(AGAIN);
        };
        let (sender, messages) = sync_channel(WAITING_MESSAGES);
        let take = move |sample: Sample| {
            // Where the reader is slow, or the bytes are none, the next number shows what is missing.
            if let Some(message) = Message::of(&sample.payload().to_bytes()) {
                let _ = sender.try_send(message);
            }
        };
        session
            .declare_subscriber(keys.records.clone())
            .callback(take)
            .background()
            .wait()
            .map_err(Error::check)?;
        let (sequence, first, silence) = (Sequence::new(ask), *ask, Silence::begin());
        Ok(Self { session, messages, keys, sequence, first, silence, out, is_gone })
    }

    /// Writes what comes and asks for what is missing.
    fn run(&mut self) -> std::result::Result<Never, Stopped> {
        write_head(self.out)?;
        self.out.flush()?;
        let mut is_missing = true;
        loop {
            self.look()?;
            while is_missing {
                is_missing = !self.ask()?;
                if is_missing {
                    self.look()?;
                }
            }
            match self.messages.recv_timeout(LOOK) {
                Ok(message) => match self.sequence.hear(message) {
                    Heard::Next(frame) => self.write(frame)?,
                    Heard::Old => {}
                    Heard::Missing => is_missing = true,
                },
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Error::check("the connection is closed").into());
                }
            }
        }
    }

    /// Asks for what is missing, and writes the answer. Returns true if nothing is missing after it.
    fn ask(&mut self) -> std::result::Result<bool, Stopped> {
        let ask = self.sequence.ask();
        log::debug!("asks for what comes after {:?}", ask.goes_on);
        let (sender, replies) = channel();
        self.session
            .get(self.keys.ask.clone())
            .payload(to_bytes(&Frame::Ask(ask)))
            .consolidation(ConsolidationMode::None)
            .timeout(ANSWER)
            .callback(move |reply: Reply| _ = sender.send(reply))
            .wait()
            .map_err(Error::check)?;
        let (mut is_complete, mut has_come) = (false, false);
        loop {
            let reply = match replies.recv_timeout(LOOK) {
                Ok(reply) => reply,
                Err(RecvTimeoutError::Timeout) => {
                    self.look()?;
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => break,
            };
            let Ok(sample) = reply.result() else { continue };
            let Some(frame) = frame_of(&sample.payload().to_bytes()) else { continue };
            let is_last = is_up_to_date(&frame);
            let frames = self.sequence.answer(frame);
            // One that does not come next shows that a frame before it was lost.
            is_complete = is_last && !frames.is_empty();
            for frame in frames {
                has_come = true;
                self.write(frame)?;
            }
        }
        if !has_come {
            sleep(AGAIN);
        }
        Ok(is_complete)
    }

    /// Stops where the user asks to, or nobody reads; a long silence is noted.
    fn look(&mut self) -> std::result::Result<(), Stopped> {
        let Keys { records, ask } = self.keys;
        self.silence.look(|| {
            format!(
                "nothing came from {records} and {ask}: no sender is there, or an access rule (`access_control`) of \
                 it or of a router denies this receiver; asking again"
            )
        });
        look(&self.is_gone)
    }

    /// Writes a frame; the last one ends the stream.
    fn write(&mut self, frame: Frame) -> std::result::Result<(), Stopped> {
        self.first.write(&frame, self.out)?;
        self.out.flush()?;
        self.silence = Silence::begin();
        match frame {
            Frame::End { .. } => Err(Stopped::Ended),
            Frame::Refused(why) => Err(Error::input(format!("the sender says: {why}")).into()),
            _ => Ok(()),
        }
    }
}

/// Stops where the user asks to, or nobody reads.
fn look(is_gone: &impl Fn() -> bool) -> std::result::Result<(), Stopped> {
    interrupt::check()?;
    if is_gone() { Err(Stopped::Gone) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_is_an_error_and_a_reader_that_has_gone_is_none() {
        let of = |kind: io::ErrorKind| Stopped::from(io::Error::from(kind));
        assert!(matches!(of(io::ErrorKind::StorageFull), Stopped::Failed(_)));
        assert!(matches!(of(io::ErrorKind::BrokenPipe), Stopped::Gone));
    }
}
