//! The WebSocket to the service, without TLS.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use chaincell_client::clock::now_ns;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use tungstenite::protocol::{Message, Role, WebSocketConfig};
use tungstenite::{Error, WebSocket};

use crate::drive::Service;

/// Longest wait for a connection, and for each part of its handshake.
const CONNECT: Duration = Duration::from_secs(2);
/// Key of the handshake and its answer: the example of RFC 6455, section 1.3. A key protects caches between
/// both ends, and there are none on one machine.
const KEY: &str = "dGhlIHNhbXBsZSBub25jZQ==";
/// The answer to that key.
pub const ACCEPT: &str = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";
/// Largest head of an answer, and largest message \[bytes\].
const HEAD_BYTES_MAX: usize = 8 << 10;
const MESSAGE_BYTES_MAX: usize = 1 << 20;

/// An open connection.
#[derive(Debug)]
pub struct Link {
    socket: WebSocket<TcpStream>,
}

impl Link {
    /// Connects to `ws://HOST:PORT[/PATH]`.
    ///
    /// # Errors
    /// Another address; nobody there; somebody who speaks no WebSocket.
    pub fn open(address: &str) -> Result<Self, String> {
        let Some((host, path)) = parts(address) else {
            return Err(format!("--service {address}: give ws://HOST:PORT"));
        };
        let absent = |why: &dyn std::fmt::Display| {
            format!(
                "no service at {address} ({why}): is the Haply service running? Start Haply Hub or \
                 haply-inverse-service, or name another with --service ws://HOST:PORT"
            )
        };
        let mut stream = connect(host).map_err(|why| absent(&why))?;
        let shaken = shake_hands(&mut stream, host, path);
        shaken.map_err(|why| format!("{address} is no WebSocket ({why}): is --service right?"))?;
        stream.set_nonblocking(true).map_err(|why| absent(&why))?;
        let config = WebSocketConfig::default()
            .write_buffer_size(0)
            .max_message_size(Some(MESSAGE_BYTES_MAX))
            .max_frame_size(Some(MESSAGE_BYTES_MAX));
        Ok(Self { socket: WebSocket::from_raw_socket(stream, Role::Client, Some(config)) })
    }

    /// Returns the next text that has come; a message in bytes is an empty text.
    fn take(&mut self) -> Result<Option<String>, String> {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => return Ok(Some(text.as_str().to_owned())),
                Ok(Message::Binary(_)) => return Ok(Some(String::new())),
                Ok(Message::Close(_)) => return Err("it closed the connection".to_owned()),
                // A ping is answered by the next call.
                Ok(_) => {}
                Err(Error::Io(why)) if why.kind() == ErrorKind::WouldBlock => return Ok(None),
                Err(why) => return Err(why.to_string()),
            }
        }
    }
}

impl Service for Link {
    fn send(&mut self, message: &str) -> Result<(), String> {
        // One that takes no bytes would get an old force later.
        self.socket.send(Message::text(message)).map_err(|why| why.to_string())
    }

    fn receive(&mut self, end_ns: u64) -> Result<Option<String>, String> {
        loop {
            let mut newest = None;
            while let Some(text) = self.take()? {
                newest = Some(text);
            }
            let left_ns = end_ns.saturating_sub(now_ns());
            if newest.is_some() || left_ns == 0 {
                return Ok(newest);
            }
            let mut ready = [PollFd::new(self.socket.get_ref(), PollFlags::IN)];
            let left = Timespec {
                tv_sec: (left_ns / 1_000_000_000).cast_signed(),
                tv_nsec: (left_ns % 1_000_000_000).cast_signed(),
            };
            // A signal ends the wait early; the clock is looked at again.
            let _ = poll(&mut ready, Some(&left));
        }
    }

    fn close(&mut self) {
        let stream = self.socket.get_ref();
        let _ = stream.set_nonblocking(false);
        let _ = stream.set_write_timeout(Some(CONNECT));
        let _ = self.socket.close(None);
        let _ = self.socket.flush();
    }
}

/// Returns the host with its port, and the path.
fn parts(address: &str) -> Option<(&str, &str)> {
    let rest = address.strip_prefix("ws://")?;
    let (host, path) = match rest.find('/') {
        Some(at) => rest.split_at(at),
        None => (rest, "/"),
    };
    let (name, port) = host.rsplit_once(':')?;
    let is_plain = rest.bytes().all(|byte| byte.is_ascii_graphic());
    (is_plain && !name.is_empty() && port.parse::<u16>().is_ok()).then_some((host, path))
}

/// Connects to the first address of the host that answers.
fn connect(host: &str) -> std::io::Result<TcpStream> {
    let mut last = std::io::Error::from(ErrorKind::NotFound);
    for address in host.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(CONNECT))?;
                stream.set_write_timeout(Some(CONNECT))?;
                return Ok(stream);
            }
            Err(why) => last = why,
        }
    }
    Err(last)
}

fn shake_hands(stream: &mut TcpStream, host: &str, path: &str) -> Result<(), String> {
    let head = format!(
        "GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {KEY}\r\n\r\n"
    );
    stream.write_all(head.as_bytes()).map_err(|why| why.to_string())?;
    let mut answer = Vec::new();
    while !answer.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).map_err(|why| why.to_string())?;
        answer.extend(byte);
        if answer.len() > HEAD_BYTES_MAX {
            return Err("an answer without an end".to_owned());
        }
    }
    let answer = String::from_utf8_lossy(&answer);
    let first = answer.lines().next().unwrap_or_default();
    let accepts = answer.lines().filter_map(|line| line.split_once(':')).any(|(name, value)| {
        name.eq_ignore_ascii_case("sec-websocket-accept") && value.trim() == ACCEPT
    });
    if first.split(' ').nth(1) == Some("101") && accepts {
        Ok(())
    } else {
        Err(format!("it answers {first:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_host_and_a_port() {
        assert_eq!(parts("ws://localhost:10001"), Some(("localhost:10001", "/")));
        assert_eq!(parts("ws://[::1]:7/a/b"), Some(("[::1]:7", "/a/b")));
        let bad = ["", "localhost:1", "wss://a:1", "ws://a", "ws://:1", "ws://a:b", "ws://a:70000"];
        for address in bad.into_iter().chain(["ws://a:1/\r\nb: c", "ws://a b:1"]) {
            assert_eq!(parts(address), None, "{address}");
            let text = Link::open(address).unwrap_err();
            assert!(text.starts_with("--service ") && text.contains("give ws://"), "{text}");
        }
    }
}
