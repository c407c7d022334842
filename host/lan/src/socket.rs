//! A UDP socket, and waits for it.

use std::io::ErrorKind;
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};

use chaincell_client::clock::{SECOND_NS, now_ns};
use chaincell_client::{Error, Kind, Result};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::datagram::DATAGRAM_BYTES_MAX;

/// A datagram that has come, and its sender.
#[derive(Debug)]
pub struct Arrived {
    bytes: [u8; DATAGRAM_BYTES_MAX + 1],
    length: usize,
    /// Address of the sender.
    pub from: SocketAddr,
}

impl Arrived {
    /// Returns its bytes; one too long is cut, and has no right code.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

/// A socket that never blocks.
#[derive(Debug)]
pub struct Socket(UdpSocket);

impl Socket {
    /// Listens at `ADDRESS:PORT`.
    ///
    /// # Errors
    /// No such address of this machine, or a port in use.
    pub fn listen(address: &str) -> Result<Self> {
        let refused = |why: &dyn std::fmt::Display, remedy: &str| {
            Error::new(Kind::Argument, format!("--listen {address}: {why}; {remedy}"))
        };
        let places = address.to_socket_addrs().map_err(|why| {
            refused(&why, "give an address of this machine and a port, as 0.0.0.0:7200")
        })?;
        let places: Vec<SocketAddr> = places.collect();
        let socket = UdpSocket::bind(&places[..]).map_err(|why| {
            let remedy = match why.kind() {
                ErrorKind::AddrInUse => "end the other program there, or take another port",
                ErrorKind::PermissionDenied => "take a port from 1024 on",
                _ => "give an address of this machine, as `ip address` lists them",
            };
            refused(&why, remedy)
        })?;
        socket.set_nonblocking(true).map_err(|why| refused(&why, "try again"))?;
        Ok(Self(socket))
    }

    /// Talks to `ADDRESS:PORT` alone.
    ///
    /// # Errors
    /// No such host, or no way to it.
    pub fn connect(address: &str) -> Result<Self> {
        let refused = |why: std::io::Error| {
            let text =
                format!("{address}: {why}; give host and port of the agent, as 10.0.0.5:7200");
            Error::new(Kind::Argument, text)
        };
        let place = address.to_socket_addrs().map_err(refused)?.next();
        let place = place.ok_or_else(|| refused(ErrorKind::NotFound.into()))?;
        let any = if place.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
        let socket = UdpSocket::bind(any).map_err(refused)?;
        socket.connect(place).map_err(refused)?;
        socket.set_nonblocking(true).map_err(refused)?;
        Ok(Self(socket))
    }

    /// Returns the own address.
    ///
    /// # Errors
    /// A socket that the system has closed.
    pub fn address(&self) -> Result<SocketAddr> {
        self.0.local_addr().map_err(|why| Error::new(Kind::Connection, why))
    }

    /// Sends to the other side of [`Self::connect`]. A datagram that cannot be sent is one that is lost.
    pub fn send(&self, bytes: &[u8]) {
        let _ = self.0.send(bytes);
    }

    /// Sends to an address. A datagram that cannot be sent is one that is lost.
    pub fn send_to(&self, bytes: &[u8], to: SocketAddr) {
        let _ = self.0.send_to(bytes, to);
    }

    /// Returns the next datagram that has come.
    #[must_use]
    pub fn take(&self) -> Option<Arrived> {
        let mut bytes = [0; DATAGRAM_BYTES_MAX + 1];
        // A port without a program answers by an error, once for each datagram sent to it.
        let (length, from) = self.0.recv_from(&mut bytes).ok()?;
        Some(Arrived { bytes, length, from })
    }

    /// Waits until a datagram has come or the time is `end_ns`; a signal ends the wait early.
    pub fn wait(&self, end_ns: u64) {
        let left_ns = end_ns.saturating_sub(now_ns());
        if left_ns == 0 {
            return;
        }
        let left = Timespec {
            tv_sec: (left_ns / SECOND_NS).cast_signed(),
            tv_nsec: (left_ns % SECOND_NS).cast_signed(),
        };
        let mut ready = [PollFd::new(&self.0, PollFlags::IN)];
        let _ = poll(&mut ready, Some(&left));
    }
}
