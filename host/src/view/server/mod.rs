//! A web server for a browser of this user on this machine.
//!
//! **Access**: the server is bound to 127.0.0.1. Requests for another host are refused, so that no name of the
//! internet can be bent to it, and so are those that another page makes, by their origin. Other users of the
//! machine can load the page, which has no secret; model, states and commands need the token of 128 random
//! bits in the fragment of the printed address.
//!
//! **Limits**: at most [`PAGES_MAX`] pages, a thread each, and `CONNECTIONS_MAX` connections in all; a
//! request of at most 16 kB and a body of 4 kB within 5 s; messages of at most 4 kB; at most two frames on
//! their way to a page. A page cannot delay the scene: it takes the newest frame when it can.

mod access;
mod bell;
mod connection;
mod feed;
mod refusal;
mod request;
mod response;
mod site;
mod socket;
#[cfg(test)]
mod tests;
mod token;

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

pub use feed::{Feed, PAGES_MAX};
pub use site::{Answer, Live, Reply, Site};
pub use token::Token;

use crate::error::{Error, Result};
use access::Access;
use bell::Bell;

/// Connections at a time: pages and requests.
const CONNECTIONS_MAX: usize = 32;
/// Pause after a connection that cannot be accepted, and between looks at pages that close.
const LOOK: Duration = Duration::from_millis(5);
/// Longest wait for pages that close.
const CLOSE: Duration = Duration::from_millis(500);

/// A running server; dropping it ends it.
#[derive(Debug)]
pub struct Server {
    shared: Arc<Shared>,
    accepting: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    access: Access,
    site: Site,
    stop: Bell,
    has_ended: AtomicBool,
    connections: AtomicUsize,
}

impl Server {
    /// Serves a site on a port of 127.0.0.1, 0 for a free one.
    ///
    /// # Errors
    /// A port that is taken; too few files or threads.
    pub fn start(port: u16, site: Site) -> Result<Self> {
        let failed = |why: io::Error| {
            let remedy = match why.kind() {
                ErrorKind::AddrInUse => "another program has it",
                ErrorKind::PermissionDenied => "ports below 1024 are the system's",
                _ => "it cannot be opened",
            };
            Error::input(format!(
                "`port` {port}: {remedy} ({why}); give another one, or leave it out for a free one"
            ))
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        listener.set_nonblocking(true).map_err(failed)?;
        let shared = Arc::new(Shared {
            access: Access { port, token: Token::new()? },
            site,
            stop: Bell::new().map_err(failed)?,
            has_ended: AtomicBool::new(false),
            connections: AtomicUsize::new(0),
        });
        let accepting = {
            let shared = Arc::clone(&shared);
            thread::Builder::new().name("view".into()).spawn(move || shared.accept(&listener))
        };
        Ok(Self { shared, accepting: Some(accepting.map_err(failed)?) })
    }

    /// Address of the page, with the token.
    #[must_use]
    pub fn address(&self) -> String {
        let Access { port, token } = &self.shared.access;
        format!("http://127.0.0.1:{port}/#{}", token.text())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.has_ended.store(true, Ordering::Release);
        self.shared.stop.ring();
        if let Some(live) = &self.shared.site.live {
            live.feed.end();
        }
        if let Some(accepting) = self.accepting.take() {
            let _ = accepting.join();
        }
        // Pages are closed with a reason, if they take it.
        let start = Instant::now();
        let pages = || self.shared.site.live.as_ref().map_or(0, |live| live.feed.pages());
        while pages() > 0 && start.elapsed() < CLOSE {
            thread::sleep(LOOK);
        }
    }
}

impl Shared {
    /// Accepts connections, a thread each, until the end.
    fn accept(self: &Arc<Self>, listener: &TcpListener) {
        while !self.has_ended.load(Ordering::Acquire) {
            match listener.accept() {
                Ok((stream, _)) => self.begin(stream),
                Err(why) if why.kind() == ErrorKind::WouldBlock => {
                    if self.stop.wait(listener, false).is_err() {
                        return;
                    }
                }
                // No files are left for a connection, or it is gone already.
                Err(_) => thread::sleep(LOOK),
            }
        }
    }

    fn begin(self: &Arc<Self>, stream: TcpStream) {
        let place = Taken::new(self);
        if place.shared.connections.load(Ordering::Relaxed) > CONNECTIONS_MAX {
            return;
        }
        // Without a thread the connection is closed.
        let _ = thread::Builder::new().name("page".into()).spawn(move || {
            let Shared { access, site, .. } = &*place.shared;
            if stream.set_nonblocking(false).is_ok() {
                // A connection that fails concerns its page alone.
                let _ = connection::answer(&stream, access, site);
            }
        });
    }
}

/// The place of a connection, free again when this is dropped.
struct Taken {
    shared: Arc<Shared>,
}

impl Taken {
    fn new(shared: &Arc<Shared>) -> Self {
        shared.connections.fetch_add(1, Ordering::Relaxed);
        Self { shared: Arc::clone(shared) }
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.shared.connections.fetch_sub(1, Ordering::Relaxed);
    }
}
