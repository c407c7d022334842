//! What travels: keys, and frames as bytes.

use chaincell_host::error::{Error, Result};
use chaincell_host::remote::frame::Frame;

/// Longest name of a session \[bytes\].
const NAME_BYTES_MAX: usize = 64;
/// Bytes before a published frame.
const SEAL_BYTES: usize = 4;

/// The keys of a session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Keys {
    /// Records are published here.
    pub records: String,
    /// Questions are answered here.
    pub ask: String,
}

impl Keys {
    /// The keys of the session of this name: letters, digits, `-`, `_` and `.`.
    ///
    /// # Errors
    /// A name that is empty, too long, or has other characters.
    pub fn new(name: &str) -> Result<Self> {
        let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
        if name.is_empty() || name.len() > NAME_BYTES_MAX || !name.bytes().all(is_plain) {
            return Err(Error::input(format!(
                "the name `{name}`: take up to {NAME_BYTES_MAX} letters, digits, -, _ and ."
            )));
        }
        let (records, ask) = (format!("chaincell/{name}/records"), format!("chaincell/{name}/ask"));
        Ok(Self { records, ask })
    }
}

/// A frame that is published, with its place in the session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// What identifies the session up to the frame's first record, or up to the number of records that it states;
    /// see [`Tail::seal`](chaincell_host::files::recording::Tail::seal).
    pub seal: u32,
    /// The frame.
    pub frame: Frame,
}

impl Message {
    /// The bytes of a message.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.seal.to_le_bytes().to_vec();
        bytes.extend(to_bytes(&self.frame));
        bytes
    }

    /// The message of these bytes; `None` for bytes that are none.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let (seal, frame) = bytes.split_first_chunk::<SEAL_BYTES>()?;
        Some(Self { seal: u32::from_le_bytes(*seal), frame: frame_of(frame)? })
    }
}

/// The bytes of a frame, records packed.
#[must_use]
pub fn to_bytes(frame: &Frame) -> Vec<u8> {
    let mut bytes = Vec::new();
    // A vector takes all.
    let _ = frame.write_packed(&mut bytes);
    bytes
}

/// The frame of these bytes; `None` for bytes that are none.
#[must_use]
pub fn frame_of(mut bytes: &[u8]) -> Option<Frame> {
    Frame::read(&mut bytes).ok().filter(|_| bytes.is_empty())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

    use super::*;

    #[test]
    fn messages_are_read_as_they_were_written_and_damaged_ones_are_none() {
        let frame = Frame::Records { first: 3, newest: 5, bytes: vec![5; 96] };
        let message = Message { seal: 0xab, frame };
        let bytes = message.to_bytes();
        assert_eq!(Message::of(&bytes), Some(message));
        // The first four bytes are compared with those of the records before.
        for at in SEAL_BYTES..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            assert_eq!(Message::of(&flipped), None, "byte {at}");
        }
        assert_eq!(Message::of(&bytes[..bytes.len() - 1]), None);
        assert_eq!(Message::of(&[&bytes[..], &[0]].concat()), None);
    }

    #[test]
    fn a_name_is_one_part_of_a_key() {
        assert_eq!(Keys::new("left-1").unwrap().records, "chaincell/left-1/records");
        for bad in ["", "*", "a/b", "a#b", "a b", "ä", &"a".repeat(65)] {
            assert!(Keys::new(bad).is_err(), "{bad}");
        }
    }
}
