//! Opens services within a time limit. iceoryx2 may wait for another program for ever and cannot be
//! stopped: it opens them in a thread, and files that block it are cleared up meanwhile.

use std::sync::mpsc::{TryRecvError, channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::{Error, Kind, Result};
use crate::leftovers::{Cause, Leftovers};

/// Longest wait for iceoryx2, which itself waits for a second for another program.
const LIMIT: Duration = Duration::from_secs(4);
/// Time within which opening is tried again.
const AGAIN: Duration = Duration::from_secs(3);
/// Period at which `stop` is called.
const LOOK: Duration = Duration::from_millis(2);
/// Longest wait for files that another program may be making.
const YOUNG: Duration = Duration::from_millis(600);
/// Period at which leftovers of other programs are cleared up.
const CLEAR: Duration = Duration::from_millis(100);

/// Returns true if the service cannot be opened yet because another program is making it.
fn is_in_creation(why: &Error) -> bool {
    why.kind() == Kind::Service && why.to_string().contains("InCreation")
}

/// The services of a scene to open, by their names.
#[derive(Debug, Clone)]
pub(crate) struct Opening {
    pub leftovers: Leftovers,
    pub label: String,
    pub names: Vec<String>,
}

impl Opening {
    /// Opens them; calls `stop` every 2 ms, and ends if it returns true.
    ///
    /// # Errors
    /// That of `open`, or the cause that blocks it; [`Kind::Stopped`] if `stop` returned true.
    pub(crate) fn within<T: Send + 'static>(
        &self,
        mut stop: impl FnMut() -> bool,
        open: impl Fn() -> Result<T> + Send + 'static,
    ) -> Result<T> {
        // Clear up first: iceoryx2 gives up on a half-made file before it is old enough to be removed.
        let start = Instant::now();
        while self.leftovers.clear() && start.elapsed() < YOUNG && !stop() {
            thread::sleep(LOOK);
        }
        let (done, opened) = channel();
        // Open in a thread. One that never returns ends with the process.
        let thread = thread::Builder::new().name("opening".into()).spawn(move || {
            // iceoryx2 gives up on a service that another program is slow to make: try again.
            let opened = loop {
                match open() {
                    Err(why) if is_in_creation(&why) && start.elapsed() < AGAIN => {
                        thread::sleep(LOOK);
                    }
                    opened => break opened,
                }
            };
            // If nobody waits any more, the opened services are closed.
            let _ = done.send(opened);
        });
        thread.map_err(|why| Error::new(Kind::Memory, format!("cannot begin a thread: {why}")))?;
        let mut cleared = Instant::now();
        // Poll for the end: a blocking wait would leave a thread's handle in a program of C.
        loop {
            match opened.try_recv() {
                Ok(Err(why)) if why.kind() == Kind::Service => return Err(self.refusal(Some(why))),
                Ok(done) => return done,
                Err(TryRecvError::Disconnected) => return Err(self.refusal(None)),
                Err(TryRecvError::Empty) => {}
            }
            if stop() {
                let text = format!("asked to stop before {} was open", self.label);
                return Err(Error::new(Kind::Stopped, text));
            }
            if start.elapsed() >= LIMIT {
                return Err(self.refusal(None));
            }
            if cleared.elapsed() >= CLEAR {
                cleared = Instant::now();
                self.leftovers.clear();
            }
            thread::sleep(LOOK);
        }
    }

    /// Returns the cause that blocks the services, else the error of iceoryx2.
    fn refusal(&self, why: Option<Error>) -> Error {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let text = match (self.leftovers.cause(&names), why) {
            (Some(Cause::Gone { process }), _) => format!(
                "its files in /dev/shm are gone, although process {process} has it open: somebody \
                 removed them; end process {process} and start it again"
            ),
            (Some(Cause::Unfinished { path, process: Some(process) }), _) => format!(
                "process {process} began to make {} and does not go on: let it go on, or end it",
                path.display()
            ),
            (_, Some(why)) => return why,
            (Some(Cause::Unfinished { path, process: None }), None) => {
                format!("nobody finishes {}: remove it", path.display())
            }
            (None, None) => format!(
                "iceoryx2 has not opened it within {} s: end the programs that use it",
                LIMIT.as_secs()
            ),
        };
        Error::new(Kind::Service, format!("cannot open {}: {text}", self.label))
    }
}
