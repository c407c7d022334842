//! A page's WebSocket: sends it frames and notices, and takes its messages.
//!
//! A page says `seen` after each frame. At most [`UNSEEN_MAX`] frames are on their way to a page; meanwhile
//! further ones are skipped, and the newest one follows.

use std::io::{self, ErrorKind, Write};
use std::net::TcpStream;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha1_smol::Sha1;
use tungstenite::error::Error;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, Message, Role, WebSocketConfig};
use tungstenite::{Utf8Bytes, WebSocket};

use super::access::PROTOCOL;
use super::feed::Place;
use super::refusal::Refusal;
use super::request::Request;
use super::site::Live;

/// Largest message of a page \[bytes\].
const MESSAGE_BYTES_MAX: usize = 4 << 10;
/// Frames on their way to a page.
const UNSEEN_MAX: u64 = 2;
/// Message of a page that has taken a frame.
const SEEN: &str = "seen";
/// The word of a page that shows the stress, at least once a second.
const STRESS: &str = "stress";
/// The fixed text of the handshake, RFC 6455.
const HANDSHAKE: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
/// The text for a page without a place.
const FULL: &str = "eight pages are open already: close one, and reload this one";

/// Checks that a request asks for a WebSocket, and returns its key.
///
/// # Errors
/// Another request.
pub(super) fn key(request: &Request) -> Result<&str, Refusal> {
    let is_upgrade = request.lists("upgrade", "websocket")?
        && request.lists("connection", "upgrade")?
        && request.field("sec-websocket-version")? == Some("13");
    let key = request.field("sec-websocket-key")?.filter(|_| is_upgrade);
    key.ok_or(Refusal::NO_UPGRADE)
}

/// Serves a page until it closes.
///
/// # Errors
/// A connection that fails.
pub(super) fn serve(mut stream: &TcpStream, key: &str, live: &Live) -> io::Result<()> {
    let accept = STANDARD.encode(Sha1::from(format!("{key}{HANDSHAKE}")).digest().bytes());
    let head = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accept}\r\nSec-WebSocket-Protocol: {PROTOCOL}\r\n\r\n"
    );
    stream.write_all(head.as_bytes())?;
    stream.set_nodelay(true)?;
    let config = WebSocketConfig::default()
        .read_buffer_size(MESSAGE_BYTES_MAX)
        .write_buffer_size(0)
        .max_message_size(Some(MESSAGE_BYTES_MAX))
        .max_frame_size(Some(MESSAGE_BYTES_MAX));
    let socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
    let place = live.feed.join()?;
    stream.set_nonblocking(place.is_some())?;
    let mut page =
        Page { socket, live, seen_frame: 0, seen_notice: 0, unseen: 0, is_blocked: false };
    let ended = match &place {
        Some(place) => page.run(place),
        None => page.close(CloseCode::Again, FULL),
    };
    match ended {
        Err(Error::Io(why)) => Err(why),
        _ => Ok(()),
    }
}

/// An open page.
struct Page<'a> {
    socket: WebSocket<&'a TcpStream>,
    live: &'a Live,
    /// Numbers of the last frame and notice that were sent.
    seen_frame: u64,
    seen_notice: u64,
    /// Frames sent that the page has not taken.
    unseen: u64,
    /// True if the socket takes no further bytes at present.
    is_blocked: bool,
}

/// The end of a page, as an error or as a close that both sides know of.
type Ended = Result<(), Error>;

impl Page<'_> {
    fn run(&mut self, place: &Place<'_>) -> Ended {
        loop {
            place.bell.clear();
            if self.live.feed.has_ended() {
                return self.close(CloseCode::Away, "chaincell has ended");
            }
            self.take_messages()?;
            self.send_news()?;
            place.bell.wait(self.socket.get_ref(), self.is_blocked).map_err(Error::Io)?;
        }
    }

    /// Takes all messages that have come.
    fn take_messages(&mut self) -> Ended {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) if text.as_str() == SEEN => {
                    self.unseen = self.unseen.saturating_sub(1);
                }
                Ok(Message::Text(text)) if text.as_str() == STRESS => {
                    self.live.feed.ask_for_stress();
                }
                Ok(Message::Text(text)) => {
                    if let Some(reply) = (self.live.reply)(text.as_str()) {
                        self.send(Message::text(reply))?;
                    }
                }
                Ok(Message::Binary(_)) => {
                    return self.close(CloseCode::Unsupported, "a page sends text alone");
                }
                // Answered by the next call.
                Ok(_) => {}
                Err(Error::Io(why)) if why.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(Error::Capacity(_)) => {
                    return self.close(CloseCode::Size, "a message has at most 4 kB");
                }
                Err(why) => return Err(why),
            }
        }
    }

    /// Sends a new notice and the newest frame, if the page can take them.
    fn send_news(&mut self) -> Ended {
        if self.is_blocked {
            let flushed = self.socket.flush();
            self.note(flushed)?;
        }
        let feed = &self.live.feed;
        if !self.is_blocked
            && let Some((number, notice)) = feed.notice_unlike(self.seen_notice)
        {
            self.seen_notice = number;
            self.send(Message::Text(notice))?;
        }
        if !self.is_blocked
            && self.unseen < UNSEEN_MAX
            && let Some((number, frame)) = feed.frame_unlike(self.seen_frame)
        {
            self.seen_frame = number;
            self.unseen += 1;
            self.send(Message::Binary(frame))?;
        }
        Ok(())
    }

    fn send(&mut self, message: Message) -> Ended {
        let sent = self.socket.send(message);
        self.note(sent)
    }

    /// Notes whether the socket took all bytes; it keeps the others for later.
    fn note(&mut self, written: Ended) -> Ended {
        self.is_blocked = match written {
            Ok(()) => false,
            Err(Error::Io(why)) if why.kind() == ErrorKind::WouldBlock => true,
            Err(why) => return Err(why),
        };
        Ok(())
    }

    fn close(&mut self, code: CloseCode, reason: &'static str) -> Ended {
        let reason = Utf8Bytes::from_static(reason);
        let closed = self.socket.close(Some(CloseFrame { code, reason }));
        closed.and_then(|()| self.socket.flush())
    }
}
