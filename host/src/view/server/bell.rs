//! Wakes a thread that waits for a socket.

use std::io::{self, Error};
use std::os::fd::{AsFd, OwnedFd};

use rustix::event::{EventfdFlags, PollFd, PollFlags, eventfd, poll};

/// A bell that rings until it is cleared.
#[derive(Debug)]
pub(crate) struct Bell(OwnedFd);

impl Bell {
    /// Makes a bell that does not ring.
    pub(crate) fn new() -> io::Result<Self> {
        Ok(Self(eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?))
    }

    /// Rings. A bell that rings already needs no second time.
    pub(crate) fn ring(&self) {
        let _ = rustix::io::write(&self.0, &1_u64.to_ne_bytes());
    }

    /// Ends the ringing.
    pub(crate) fn clear(&self) {
        let _ = rustix::io::read(&self.0, &mut [0_u8; 8]);
    }

    /// Waits until the bell rings or `socket` can be read, or written too if it `is_blocked`.
    pub(crate) fn wait(&self, socket: impl AsFd, is_blocked: bool) -> io::Result<()> {
        let write = if is_blocked { PollFlags::OUT } else { PollFlags::empty() };
        let mut both =
            [PollFd::new(&socket, PollFlags::IN | write), PollFd::new(&self.0, PollFlags::IN)];
        match poll(&mut both, None) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(why) => Err(Error::from(why)),
        }
    }
}
