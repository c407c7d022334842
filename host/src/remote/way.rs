//! How the bytes of a mirror come to its follower.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::frame::{Ask, Frame};
use super::mirror::Mirror;
use super::place::Place;
use crate::error::{Error, Result};

/// Longest wait for the first connection.
const CONNECT: Duration = Duration::from_secs(5);
/// Bounds of that for later ones, which is four times the last one's. The system repeats a lost request after a
/// second, so that a new one comes sooner.
const CONNECT_AGAIN: [Duration; 2] = [Duration::from_millis(200), CONNECT];

/// Exit code of `chaincell mirror` where it cannot do what it was asked.
const REFUSED: i32 = 2;
/// Longest wait for the end of a program whose stream has ended, and time between looks for it.
const ENDS: Duration = Duration::from_millis(200);
const LOOK: Duration = Duration::from_millis(5);

/// A stream of bytes from a mirror, opened anew after each cut.
pub trait Way: fmt::Debug + Send {
    /// Opens the stream for what is asked.
    ///
    /// # Errors
    /// Why there is none, with what was tried.
    fn open(&mut self, ask: &Ask) -> Result<Box<dyn Read + Send>>;

    /// Lets the stream go, so that a reader that waits for it ends.
    fn close(&mut self);

    /// True where it can be opened anew.
    fn opens_again(&self) -> bool {
        true
    }

    /// Why it never comes again, if the stream that has just ended said so.
    fn refusal(&mut self) -> Option<Error> {
        None
    }
}

/// Standard input: all of a session, once.
#[derive(Debug)]
pub struct Input;

impl Way for Input {
    fn open(&mut self, _ask: &Ask) -> Result<Box<dyn Read + Send>> {
        Ok(Box::new(io::stdin()))
    }

    fn close(&mut self) {}

    fn opens_again(&self) -> bool {
        false
    }
}

/// A program whose standard output is the stream, such as `ssh HOST chaincell mirror TRACE`. It is started with
/// the words of [`Ask::words`] behind its own.
#[derive(Debug)]
pub struct Program {
    words: Vec<String>,
    child: Option<Child>,
}

impl Program {
    /// A program and its arguments.
    #[must_use]
    pub fn new(words: Vec<String>) -> Self {
        Self { words, child: None }
    }
}

impl Way for Program {
    fn open(&mut self, ask: &Ask) -> Result<Box<dyn Read + Send>> {
        let refused = |why: io::Error| Error::input(format!("`{}`: {why}", self.words.join(" ")));
        let (name, words) = self.words.split_first().ok_or_else(|| Error::input("no program"))?;
        let mut command = Command::new(name);
        command.args(words).args(ask.words()).stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(refused)?;
        let out = child.stdout.take();
        self.child = Some(child);
        out.map(|out| Box::new(out) as Box<dyn Read + Send>)
            .ok_or_else(|| Error::check("a program without its output"))
    }

    fn close(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }

    fn refusal(&mut self) -> Option<Error> {
        // One whose stream has ended is about to end itself.
        let child = self.child.as_mut()?;
        let begun = Instant::now();
        let mut ended = child.try_wait();
        while matches!(ended, Ok(None)) && begun.elapsed() < ENDS {
            sleep(LOOK);
            ended = child.try_wait();
        }
        let has_refused = matches!(ended, Ok(Some(status)) if status.code() == Some(REFUSED));
        has_refused.then(|| {
            Error::input(format!(
                "`{}` ended with exit code {REFUSED}, so it has no session to go on with: it has said why; start the \
                 follower again with what it needs",
                self.words.join(" ")
            ))
        })
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.close();
    }
}

/// A connection to a mirror that listens.
#[derive(Debug)]
pub struct Tcp {
    address: SocketAddr,
    stream: Option<TcpStream>,
    /// Longest wait for the next connection.
    connect: Duration,
}

impl Tcp {
    /// A mirror at this address.
    #[must_use]
    pub fn new(address: SocketAddr) -> Self {
        Self { address, stream: None, connect: CONNECT }
    }
}

impl Way for Tcp {
    fn open(&mut self, ask: &Ask) -> Result<Box<dyn Read + Send>> {
        let start = Instant::now();
        let opened = TcpStream::connect_timeout(&self.address, self.connect);
        let opened = opened.and_then(|mut stream| {
            let mut asked = Vec::new();
            Frame::Ask(*ask).write(&mut asked)?;
            stream.write_all(&asked)?;
            Ok((stream.try_clone()?, stream))
        });
        let (stream, read) =
            opened.map_err(|why| Error::input(format!("tcp:{}: {why}", self.address)))?;
        let [least, most] = CONNECT_AGAIN;
        self.connect = (4 * start.elapsed()).clamp(least, most);
        self.stream = Some(stream);
        Ok(Box::new(read))
    }

    fn close(&mut self) {
        if let Some(stream) = self.stream.take() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

/// A session that is recorded on this machine.
#[derive(Debug)]
pub enum Local {
    /// As its user names it, which may come later: see [`Place::find`].
    Named(PathBuf),
    /// Where it was found.
    Found(Place),
}

impl Way for Local {
    fn open(&mut self, ask: &Ask) -> Result<Box<dyn Read + Send>> {
        let place = match self {
            Self::Named(session) => Place::find(session, None)?,
            Self::Found(place) => place.clone(),
        };
        let mirror = Mirror::open(&place)?;
        let (read, mut write) = io::pipe().map_err(Error::check)?;
        // Nothing travels.
        let ask = Ask { packed: false, ..*ask };
        let work = move || {
            // The follower reads from the stream why it ended.
            let _ = mirror.send(&mut write, &ask);
        };
        let thread = std::thread::Builder::new().name("mirror".into()).spawn(work);
        thread.map_err(|why| Error::check(format!("cannot begin a thread: {why}")))?;
        Ok(Box::new(read))
    }

    fn close(&mut self) {}
}
