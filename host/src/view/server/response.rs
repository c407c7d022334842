//! Writes responses: each closes its connection.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use super::refusal::Refusal;
use crate::view::page::POLICY;

/// Time in which a response has to be taken.
const LIMIT: Duration = Duration::from_secs(30);
/// Time for the other side to close after a refusal.
const LINGER: Duration = Duration::from_secs(1);

/// Kind of a body.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Html,
    Gzip,
    Text,
}

/// Writes a response with a body.
pub(super) fn respond(stream: &TcpStream, kind: Kind, body: &[u8]) -> io::Result<()> {
    write_all(stream, "200 OK", kind, body)
}

/// Writes a refusal, and takes what the other side still sends, so that it reads the refusal.
pub(super) fn refuse(mut stream: &TcpStream, refusal: &Refusal) -> io::Result<()> {
    refuse_in_words(stream, refusal.status, refusal.text)?;
    stream.shutdown(Shutdown::Write)?;
    let end = Instant::now() + LINGER;
    let mut unread = [0; 4096];
    loop {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(());
        }
        stream.set_read_timeout(Some(left))?;
        if stream.read(&mut unread)? == 0 {
            return Ok(());
        }
    }
}

/// Writes a refusal with a status of HTTP and its reason in words.
pub(super) fn refuse_in_words(stream: &TcpStream, status: &str, text: &str) -> io::Result<()> {
    write_all(stream, status, Kind::Text, format!("{text}\n").as_bytes())
}

fn write_all(mut stream: &TcpStream, status: &str, kind: Kind, body: &[u8]) -> io::Result<()> {
    let content_type = match kind {
        Kind::Html => "text/html; charset=utf-8",
        Kind::Gzip => "application/gzip",
        Kind::Text => "text/plain; charset=utf-8",
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {content_type}\r\nContent-Length: {}\r\n\
         Content-Security-Policy: {POLICY}; frame-ancestors 'none'\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Opener-Policy: same-origin\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\n\
         Connection: close\r\n\r\n",
        body.len()
    );
    let end = Instant::now() + LIMIT;
    let bytes = [head.as_bytes(), body].concat();
    let mut unsent = bytes.as_slice();
    // The time is looked at after each write: a reader that takes a little now and then is slow, too.
    while !unsent.is_empty() {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        stream.set_write_timeout(Some(left))?;
        match stream.write(unsent) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(count) => unsent = &unsent[count..],
            Err(why) if why.kind() == ErrorKind::Interrupted => {}
            Err(why) => return Err(why),
        }
    }
    Ok(())
}
