//! Receives the frames of a mirror in a thread of its own, and connects again after a cut.

use std::io::{self, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{self, sleep};
use std::time::{Duration, Instant};

use super::frame::{Ask, Frame, read_head};
use super::way::Way;
use crate::error::{Error, Result};
use crate::interrupt;

/// Frames that may wait for the tissue; a mirror that is ahead of it waits too.
const WAITING_FRAMES: usize = 16;
/// Silence after which a stream counts as cut: a mirror sends ten frames a second.
const SILENCE: Duration = Duration::from_secs(2);
/// The same before the first frame: a program may have to connect, and a mirror to look through a long trace.
const FIRST_SILENCE: Duration = Duration::from_secs(30);
/// Time between looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// What came of a wait.
#[derive(Debug, PartialEq, Eq)]
pub enum Come {
    /// A frame.
    Frame(Frame),
    /// None within the span.
    Nothing,
    /// The stream is cut, and why.
    Cut(String),
}

/// The stream of a mirror.
#[derive(Debug)]
pub struct Intake {
    way: Box<dyn Way>,
    frames: Option<Receiver<io::Result<Frame>>>,
    /// When the last frame came, or the stream was opened.
    heard: Instant,
    has_heard: bool,
}

impl Intake {
    /// The stream that comes this way.
    #[must_use]
    pub fn new(way: Box<dyn Way>) -> Self {
        Self { way, frames: None, heard: Instant::now(), has_heard: false }
    }

    /// Opens the stream.
    ///
    /// # Errors
    /// Why there is none.
    pub fn open(&mut self, ask: &Ask) -> Result<()> {
        self.close();
        let stream = self.way.open(ask)?;
        let (sender, frames) = sync_channel(WAITING_FRAMES);
        let work = move || receive(stream, &sender);
        thread::Builder::new()
            .name("intake".into())
            .spawn(work)
            .map_err(|why| Error::check(format!("cannot begin a thread: {why}")))?;
        (self.frames, self.heard, self.has_heard) = (Some(frames), Instant::now(), false);
        Ok(())
    }

    /// Opens the stream again after a cut, as often as it takes, with this pause before each time; `why`
    /// it was cut.
    ///
    /// # Errors
    /// A stream that comes once; a program that has refused; Ctrl-C.
    pub fn open_again(&mut self, ask: &Ask, why: &str, pause: Duration) -> Result<()> {
        if let Some(why) = self.way.refusal() {
            return Err(why);
        }
        self.close();
        if !self.way.opens_again() {
            return Err(Error::input(format!(
                "the session is cut off ({why}), and standard input comes once: give a program, an address or a \
                 file to go on after a cut"
            )));
        }
        loop {
            sleep(pause);
            interrupt::check()?;
            match self.open(ask) {
                Ok(()) => return Ok(()),
                Err(why) => log::info!("not connected: {why}"),
            }
        }
    }

    /// Lets the stream go.
    pub fn close(&mut self) {
        self.frames = None;
        self.way.close();
    }

    /// Waits for the next frame, at most so long.
    pub fn next(&mut self, within: Duration) -> Come {
        let Some(frames) = &self.frames else { return Come::Cut("it is not open".into()) };
        match frames.recv_timeout(within.min(LOOK)) {
            Ok(Ok(frame)) => {
                (self.heard, self.has_heard) = (Instant::now(), true);
                Come::Frame(frame)
            }
            Ok(Err(why)) => Come::Cut(match why.kind() {
                io::ErrorKind::UnexpectedEof => "the stream ended".into(),
                _ => why.to_string(),
            }),
            Err(RecvTimeoutError::Disconnected) => Come::Cut("the stream ended".into()),
            Err(RecvTimeoutError::Timeout) => {
                let most = if self.has_heard { SILENCE } else { FIRST_SILENCE };
                match self.heard.elapsed() >= most {
                    true => Come::Cut(format!("no word for {} s", most.as_secs())),
                    false => Come::Nothing,
                }
            }
        }
    }
}

/// Reads frames until the stream or the follower ends.
fn receive(mut stream: Box<dyn Read + Send>, to: &SyncSender<io::Result<Frame>>) {
    if let Err(why) = read_head(&mut stream) {
        let _ = to.send(Err(why));
        return;
    }
    loop {
        let frame = Frame::read(&mut stream);
        let has_ended = frame.is_err();
        if to.send(frame).is_err() || has_ended {
            return;
        }
    }
}
