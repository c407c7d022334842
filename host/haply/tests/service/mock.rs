//! A mock of the Haply service: a WebSocket in a thread that answers each message by one state.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chaincell_haply::link::ACCEPT;
use serde_json::Value;
use tungstenite::protocol::{Message, Role};
use tungstenite::{Error, WebSocket};

/// Longest wait for a client, and for its next message.
const LIMIT: Duration = Duration::from_secs(60);

/// The one device.
pub const DEVICE: &str = "049D";

/// What the service does on a message.
pub enum Act {
    /// A state with the device at this height \[m\].
    At(f32),
    /// This text.
    Say(&'static str),
    /// Nothing.
    Silence,
    /// It cuts the connection.
    Cut,
}

/// All that the service got.
#[derive(Debug, Default)]
pub struct Seen {
    /// Size of the force of each message \[N\].
    pub forces_n: Vec<f64>,
    /// Time from each message to the one before.
    pub gaps: Vec<Duration>,
    /// True if the client closed the connection by a message.
    pub was_closed: bool,
}

/// A running mock.
pub struct Mock {
    /// For `--service`.
    pub address: String,
    thread: JoinHandle<Seen>,
}

impl Mock {
    /// Waits for one client and answers message n, from 1, by `act(n)`; `act(0)` is said first.
    pub fn start(act: impl Fn(usize) -> Act + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("ws://{}", listener.local_addr().unwrap());
        let thread = std::thread::spawn(move || serve(&listener, act));
        Self { address, thread }
    }

    /// All that it got, once the client is gone.
    pub fn seen(self) -> Seen {
        self.thread.join().unwrap()
    }
}

fn state(z_m: f32) -> String {
    format!(
        r#"{{"session_id":7,"inverse3":[{{"device_id":"{DEVICE}","status":{{"ready":true,"calibrated":true}},
            "state":{{"cursor_position":{{"x":0.01,"y":-0.12,"z":{z_m}}},
                      "cursor_velocity":{{"x":0,"y":0,"z":0}}}}}}],"verse_grip":[]}}"#
    )
}

fn serve(listener: &TcpListener, act: impl Fn(usize) -> Act) -> Seen {
    let (mut stream, _) = listener.accept().unwrap();
    stream.set_read_timeout(Some(LIMIT)).unwrap();
    stream.set_nodelay(true).unwrap();
    shake_hands(&mut stream);
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
    let mut seen = Seen::default();
    let mut last = Instant::now();
    loop {
        // A client that is about to end may be gone.
        let _ = match act(seen.forces_n.len()) {
            Act::At(z_m) => socket.send(Message::text(state(z_m))),
            Act::Say(text) => socket.send(Message::text(text)),
            Act::Silence => Ok(()),
            Act::Cut => return seen,
        };
        loop {
            match socket.read() {
                Ok(Message::Text(text)) => {
                    let now = Instant::now();
                    seen.gaps.push(now - last);
                    last = now;
                    break seen.forces_n.push(force_n(text.as_str()));
                }
                Ok(Message::Close(_)) => seen.was_closed = true,
                Err(Error::ConnectionClosed | Error::Io(_) | Error::Protocol(_)) => return seen,
                other => panic!("{other:?}"),
            }
        }
    }
}

fn shake_hands(stream: &mut TcpStream) {
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).unwrap();
        head.extend(byte);
    }
    let answer = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {ACCEPT}\r\n\r\n"
    );
    stream.write_all(answer.as_bytes()).unwrap();
}

/// Size of the force in a message, which is one of the protocol.
fn force_n(text: &str) -> f64 {
    let message: Value = serde_json::from_str(text).unwrap();
    let device = &message["inverse3"][0];
    assert_eq!(device["device_id"], DEVICE);
    let vector = &device["commands"]["set_cursor_force"]["vector"];
    ["x", "y", "z"].iter().map(|axis| vector[axis].as_f64().unwrap().powi(2)).sum::<f64>().sqrt()
}
