//! Lines for the runner through semihosting, put together without `core::fmt`.

use chaincell_kernel::trace::RECORD_BYTES;
use heapless::Vec;
use log::{LevelFilter, Log, Metadata, Record};
use semihosting::io::{Write, stdout};

/// Longest line: a name of 15 bytes and a record of a trace in digits. What does not fit is cut.
type Line = Vec<u8, { 17 + 2 * RECORD_BYTES }>;

fn put(line: &mut Line, text: &[u8]) {
    for &byte in text {
        // A full line stays as it is.
        let _ = line.push(byte);
    }
}

fn send(line: &Line) {
    if let Ok(mut to) = stdout() {
        // Nobody is there to be told that nobody listens.
        let _ = to.write_all(line);
    }
}

/// `name text`.
pub fn say(name: &str, text: &str) {
    let mut line = Line::new();
    put(&mut line, name.as_bytes());
    put(&mut line, b" ");
    put(&mut line, text.as_bytes());
    put(&mut line, b"\n");
    send(&line);
}

/// `name value`, decimal.
pub fn number(name: &str, value: u32) {
    let mut digits = [b'0'; 10];
    let mut left = value;
    let mut first = digits.len() - 1;
    for (at, digit) in digits.iter_mut().enumerate().rev() {
        *digit = b'0' + (left % 10) as u8;
        left /= 10;
        if left == 0 {
            first = at;
            break;
        }
    }
    put_line(name, digits.get(first..).unwrap_or(&[]));
}

/// `name value`, 16 hexadecimal digits.
pub fn bits(name: &str, value: u64) {
    let digits = value.to_be_bytes().map(digits_of);
    put_line(name, digits.as_flattened());
}

/// The two hexadecimal digits of a byte.
pub fn digits_of(byte: u8) -> [u8; 2] {
    [byte >> 4, byte & 15].map(|digit| if digit < 10 { b'0' + digit } else { b'a' - 10 + digit })
}

/// `name digits`.
pub fn put_line(name: &str, digits: &[u8]) {
    let mut line = Line::new();
    put(&mut line, name.as_bytes());
    put(&mut line, b" ");
    put(&mut line, digits);
    put(&mut line, b"\n");
    send(&line);
}

/// The kernel's log, on the same channel: its messages are plain text.
struct Console;

static CONSOLE: Console = Console;

impl Log for Console {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &Record<'_>) {
        say("log", record.args().as_str().unwrap_or("a message with values"));
    }

    fn flush(&self) {}
}

/// Sends the log here.
pub fn log_here() {
    if log::set_logger(&CONSOLE).is_ok() {
        log::set_max_level(LevelFilter::Debug);
    }
}
