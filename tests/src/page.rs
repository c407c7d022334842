//! A browser's page on `chaincell view`: its WebSocket, and what it reads there.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::Value;
use tungstenite::WebSocket;
use tungstenite::protocol::{Message, Role};

/// Longest wait for a message.
const LIMIT: Duration = Duration::from_secs(60);

/// An open page.
#[derive(Debug)]
pub struct Page(WebSocket<TcpStream>);

/// What a test looks at in a frame, by the layout in `chaincell_host::view::live`.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Checksum of the model.
    pub checksum: u32,
    /// Number of the last answered tick.
    pub tick: u64,
    /// State hash.
    pub hash: u64,
    /// Sweeps of the tick.
    pub sweeps: u32,
    /// Position of tool 0 \[m\], and the force on it \[N\].
    pub tool: ([f32; 3], [f32; 3]),
    /// Ticks of the points of the curves.
    pub points: Vec<u64>,
    /// Positions of the cells \[m\], and of the copies after them.
    pub positions_m: Vec<[f32; 3]>,
    /// Of a body with copies the triangles of its surface: three cells, and those that these were made from.
    pub triangles: Vec<[u32; 6]>,
}

impl Page {
    /// Opens the page of an address with its token.
    #[must_use]
    pub fn open(address: &str) -> Self {
        let (host, token) = address.strip_prefix("http://").unwrap().split_once("/#").unwrap();
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(LIMIT)).unwrap();
        let head = format!(
            "GET /live HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nUpgrade: websocket\r\n\
             Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             Sec-WebSocket-Protocol: chaincell, {token}\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            answer.extend(byte);
        }
        assert!(answer.starts_with(b"HTTP/1.1 101 "), "{}", String::from_utf8_lossy(&answer));
        Self(WebSocket::from_raw_socket(stream, Role::Client, None))
    }

    /// Sends a message.
    pub fn say(&mut self, message: &str) {
        self.0.send(Message::text(message)).unwrap();
    }

    /// The next frame that is wanted, past all other messages.
    pub fn frame(&mut self, wanted: impl Fn(&Frame) -> bool) -> Frame {
        loop {
            if let Message::Binary(bytes) = self.0.read().unwrap() {
                self.say("seen");
                let frame = Frame::read(&bytes);
                if wanted(&frame) {
                    return frame;
                }
            }
        }
    }

    /// The next text with this field, past all other messages.
    pub fn text(&mut self, field: &str) -> Value {
        loop {
            match self.0.read().unwrap() {
                Message::Binary(_) => self.say("seen"),
                Message::Text(text) => {
                    let text: Value = serde_json::from_str(text.as_str()).unwrap();
                    if text.get(field).is_some() {
                        return text;
                    }
                }
                other => panic!("{other:?}"),
            }
        }
    }

    /// Waits for a notice of this status; its words.
    pub fn status(&mut self, status: &str) -> String {
        loop {
            let notice = self.text("status");
            if notice["status"] == status {
                return notice["text"].as_str().unwrap().to_owned();
            }
        }
    }
}

impl Frame {
    fn read(bytes: &[u8]) -> Self {
        let whole = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let long = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let vector = |at: usize| [0, 4, 8].map(|axis| f32::from_bits(whole(at + axis)));
        let [tools, points, cells, contacts, stresses] =
            [48, 52, 56, 60, 64].map(|at| whole(at) as usize);
        let first_point = 68 + 72 * tools;
        let first_contact = first_point + 36 * points;
        let first_cell = first_contact + 20 * contacts + 4 * stresses;
        let first_triangle = first_cell + 12 * cells;
        let triangles = bytes.len().checked_sub(first_triangle).unwrap();
        assert!(whole(0) == 4 && triangles.is_multiple_of(24));
        for contact in 0..contacts {
            assert!((whole(first_contact + 20 * contact) as usize) < cells);
        }
        Self {
            checksum: whole(4),
            tick: long(8),
            hash: long(24),
            sweeps: whole(36),
            tool: (vector(76), vector(104)),
            points: (0..points).map(|point| long(first_point + 36 * point)).collect(),
            positions_m: (0..cells).map(|cell| vector(first_cell + 12 * cell)).collect(),
            triangles: (first_triangle..bytes.len())
                .step_by(24)
                .map(|at| [0, 4, 8, 12, 16, 20].map(|word| whole(at + word)))
                .collect(),
        }
    }
}
