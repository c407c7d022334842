//! Reads one request: bounded in size and in time.

use std::io::{ErrorKind, Read};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::refusal::Refusal;

/// Largest head: cookies of other programs on this machine are sent along \[bytes\].
const HEAD_BYTES_MAX: usize = 16 << 10;
/// Largest body \[bytes\].
const BODY_BYTES_MAX: usize = 4 << 10;
/// Most header fields.
const FIELDS_MAX: usize = 64;
/// Time in which a request has to be complete.
const LIMIT: Duration = Duration::from_secs(5);

/// A complete request.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) method: String,
    /// Path without the query.
    pub(super) path: String,
    fields: Vec<(String, String)>,
    pub(super) body: Vec<u8>,
}

/// Head of a request, and its length in bytes.
struct Head {
    request: Request,
    bytes: usize,
}

impl Request {
    /// Reads a request; `None` if the other side closed, or stayed silent, without having sent a byte.
    ///
    /// # Errors
    /// No request by the rules of HTTP; one that is too large, or too slow.
    pub(super) fn read(stream: &TcpStream) -> Result<Option<Self>, Refusal> {
        let mut input = Input { stream, bytes: Vec::new(), end: Instant::now() + LIMIT };
        let head = loop {
            if let Some(head) = parse(&input.bytes)? {
                break head;
            }
            if input.bytes.len() >= HEAD_BYTES_MAX {
                return Err(Refusal::HEAD_TOO_LARGE);
            }
            match input.more() {
                Ok(()) => {}
                Err(_) if input.bytes.is_empty() => return Ok(None),
                Err(why) => return Err(why),
            }
        };
        let Head { mut request, bytes } = head;
        let length = request.body_bytes()?;
        while input.bytes.len() < bytes + length {
            input.more()?;
        }
        // A second request is not read: each has a connection of its own.
        request.body = input.bytes[bytes..bytes + length].to_vec();
        Ok(Some(request))
    }

    /// The only field of a name, `None` without one.
    ///
    /// # Errors
    /// Two of them, which programs read in different ways.
    pub(super) fn field(&self, name: &str) -> Result<Option<&str>, Refusal> {
        let mut of_name = self.fields.iter().filter(|(own, _)| own.eq_ignore_ascii_case(name));
        let first = of_name.next().map(|(_, value)| value.as_str());
        if of_name.next().is_some() { Err(Refusal::BAD_REQUEST) } else { Ok(first) }
    }

    /// Returns true if the comma-separated list of a field has this word.
    pub(super) fn lists(&self, name: &str, word: &str) -> Result<bool, Refusal> {
        let words = self.field(name)?.unwrap_or_default().split(',');
        Ok(words.map(str::trim).any(|of| of.eq_ignore_ascii_case(word)))
    }

    fn body_bytes(&self) -> Result<usize, Refusal> {
        if self.field("transfer-encoding")?.is_some() {
            return Err(Refusal::LENGTH_REQUIRED);
        }
        let Some(length) = self.field("content-length")? else { return Ok(0) };
        if !length.bytes().all(|byte| byte.is_ascii_digit()) || length.is_empty() {
            return Err(Refusal::BAD_REQUEST);
        }
        let length = length.parse().ok().filter(|&bytes| bytes <= BODY_BYTES_MAX);
        length.ok_or(Refusal::BODY_TOO_LARGE)
    }
}

/// Parses a head; `None` if it is not complete yet.
fn parse(bytes: &[u8]) -> Result<Option<Head>, Refusal> {
    let mut fields = [httparse::EMPTY_HEADER; FIELDS_MAX];
    let mut parsed = httparse::Request::new(&mut fields);
    let bytes = match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(bytes)) => bytes,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => return Err(Refusal::HEAD_TOO_LARGE),
        Err(_) => return Err(Refusal::BAD_REQUEST),
    };
    if bytes > HEAD_BYTES_MAX {
        return Err(Refusal::HEAD_TOO_LARGE);
    }
    let target = parsed.path.unwrap_or_default();
    if !target.starts_with('/') {
        return Err(Refusal::BAD_REQUEST);
    }
    let text = |field: &httparse::Header<'_>| {
        // Fields that are no UTF-8 matter to nobody here.
        (field.name.to_owned(), String::from_utf8_lossy(field.value).into_owned())
    };
    let request = Request {
        method: parsed.method.unwrap_or_default().to_owned(),
        path: target.split('?').next().unwrap_or_default().to_owned(),
        fields: parsed.headers.iter().map(text).collect(),
        body: Vec::new(),
    };
    Ok(Some(Head { request, bytes }))
}

/// Bytes of a connection, until a moment.
struct Input<'a> {
    stream: &'a TcpStream,
    bytes: Vec<u8>,
    end: Instant,
}

impl Input<'_> {
    /// Waits for further bytes.
    fn more(&mut self) -> Result<(), Refusal> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() || self.stream.set_read_timeout(Some(left)).is_err() {
            return Err(Refusal::TOO_SLOW);
        }
        let mut chunk = [0; 4096];
        match self.stream.read(&mut chunk) {
            Ok(0) => Err(Refusal::BAD_REQUEST),
            Ok(count) => {
                self.bytes.extend_from_slice(&chunk[..count]);
                Ok(())
            }
            Err(why) if why.kind() == ErrorKind::Interrupted => Ok(()),
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                Err(Refusal::TOO_SLOW)
            }
            Err(_) => Err(Refusal::BAD_REQUEST),
        }
    }
}
