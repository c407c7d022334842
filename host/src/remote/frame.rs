//! Messages from a mirror to its follower, on a stream of bytes.
//!
//! ```text
//! stream     8 bytes "CHAINMIR", 4 bytes version (1), then frames
//! frame      1 byte kind, 4 bytes length n, n bytes content, 4 bytes CRC-32 of all before
//! 1 begun    header and parts of the trace
//! 2 model    the model's image
//! 3 start    4 bytes number of records before it, 4 bytes what identifies the session up to there, 8 bytes last
//!            tick of the trace before it, 0 for none, then a snapshot of the session
//! 4 records  4 bytes index of the first one, 4 bytes number of records that the trace has, then whole records
//! 5 alive    4 bytes number of records that the trace has
//! 6 end      4 bytes number of records that the trace has, 4 bytes 1 if its writer has ended it, 0 if it was killed
//! 7 refused  a sentence
//! 8 ask      sent to a mirror that listens, see [`Ask`]: 4 bytes what it names (the sum of 1 a place, 2 a model,
//!            4 packed records), 4 bytes seal, 4 bytes index of the next record, 4 bytes checksum of the model
//! 9 packed   4 bytes index of the first record, 4 bytes number of records that the trace has, then records as
//!            [`pack`] packs them, for a follower that asks for it
//! ```
//!
//! All numbers are little-endian. A record is the trace's: 48 bytes with its own checksum, which counts its
//! number and the trace's header.

use std::io::{self, Read, Write};

use super::pack::{pack, unpack};
use crate::checksum::CRC_32;

/// Kind of packed records.
const PACKED: u8 = 9;
const MAGIC: [u8; 8] = *b"CHAINMIR";
const VERSION: u32 = 1;
/// Largest content of a frame \[bytes\]: that of a model.
const CONTENT_BYTES_MAX: u32 = 1 << 30;
/// Largest part of a content for which memory is taken before its bytes have come.
const STEP_BYTES: usize = 1 << 20;

/// A message to a follower.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Frame {
    /// The bytes that the trace begins with: header and parts.
    Begun(Vec<u8>),
    /// Image of the model.
    Model(Vec<u8>),
    /// A snapshot from which to begin.
    Start {
        /// Number of records before it.
        records: u32,
        /// What identifies the session up to there, see
        /// [`Tail::seal`](crate::files::recording::Tail::seal).
        seal: u32,
        /// Last tick of the trace before it, 0 for none.
        last_tick: u64,
        /// Bytes of the snapshot's file.
        snapshot: Vec<u8>,
    },
    /// Records of the trace.
    Records {
        /// Index of the first one.
        first: u32,
        /// Number of records that the trace has.
        newest: u32,
        /// Bytes of the records.
        bytes: Vec<u8>,
    },
    /// The mirror is there.
    Alive {
        /// Number of records that the trace has.
        newest: u32,
    },
    /// Nothing is recorded any more.
    End {
        /// Number of records that the trace has.
        newest: u32,
        /// True if its writer has ended it, false if that was killed.
        is_whole: bool,
    },
    /// Why the mirror sends nothing further.
    Refused(String),
    /// What a follower asks for.
    Ask(Ask),
}

/// What a follower asks for: all of a session, or what it misses of one that it has begun.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ask {
    /// What identifies the session so far, see [`Tail::seal`](crate::files::recording::Tail::seal), and the index
    /// of the record that comes next.
    pub goes_on: Option<(u32, u32)>,
    /// Checksum of the model that the follower has.
    pub model: Option<u32>,
    /// True for packed records.
    pub packed: bool,
}

impl Ask {
    /// The words of a command line that ask for it.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if let Some((seal, record)) = self.goes_on {
            words.push(format!("--goes-on={seal:08x}:{record}"));
        }
        words.extend(self.model.map(|model| format!("--has-model={model:08x}")));
        words.extend(self.packed.then(|| "--packed".to_owned()));
        words
    }

    /// Writes a frame, its records packed where that is asked for.
    ///
    /// # Errors
    /// The stream's error.
    pub fn write(&self, frame: &Frame, to: &mut impl Write) -> io::Result<()> {
        if self.packed { frame.write_packed(to) } else { frame.write(to) }
    }

    /// Reads the value of `--goes-on`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn goes_on_of(text: &str) -> Result<(u32, u32), String> {
        let (seal, record) = text.split_once(':').ok_or("it is SEAL:RECORD")?;
        Ok((Self::model_of(seal)?, record.parse().map_err(|why| format!("{why}"))?))
    }

    /// Reads the value of `--has-model`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn model_of(text: &str) -> Result<u32, String> {
        u32::from_str_radix(text, 16).map_err(|why| why.to_string())
    }
}

/// Writes what every stream begins with.
///
/// # Errors
/// The stream's error.
pub fn write_head(to: &mut impl Write) -> io::Result<()> {
    to.write_all(&MAGIC)?;
    to.write_all(&VERSION.to_le_bytes())
}

/// Reads what every stream begins with.
///
/// # Errors
/// The stream's error; a stream that is none of a mirror, or of another version.
pub fn read_head(from: &mut impl Read) -> io::Result<()> {
    let mut head = [0; 12];
    from.read_exact(&mut head)?;
    let (magic, version) = head.split_at(MAGIC.len());
    if magic != MAGIC {
        return Err(bad("it is no stream of chaincell mirror"));
    }
    if version != VERSION.to_le_bytes() {
        return Err(bad("it has another version: take the same release on both sides"));
    }
    Ok(())
}

/// Writes a frame of its parts.
fn write(to: &mut impl Write, kind: u8, numbers: &[u32], content: &[u8]) -> io::Result<()> {
    let length = (4 * numbers.len() + content.len()) as u32;
    let mut bytes = vec![kind];
    bytes.extend(length.to_le_bytes());
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend(content);
    bytes.extend(CRC_32.checksum(&bytes).to_le_bytes());
    to.write_all(&bytes)
}

fn bad(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}

impl Frame {
    /// Writes the frame.
    ///
    /// # Errors
    /// The stream's error.
    pub fn write(&self, to: &mut impl Write) -> io::Result<()> {
        let (kind, numbers, content) = self.parts();
        write(to, kind, &numbers, content)
    }

    /// Writes the frame, records packed.
    ///
    /// # Errors
    /// The stream's error.
    pub fn write_packed(&self, to: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Records { first, newest, bytes } => {
                write(to, PACKED, &[*first, *newest], &pack(bytes))
            }
            other => other.write(to),
        }
    }

    /// Kind, numbers and content.
    fn parts(&self) -> (u8, Vec<u32>, &[u8]) {
        match self {
            Self::Begun(begun) => (1, vec![], begun),
            Self::Model(image) => (2, vec![], image),
            Self::Start { records, seal, last_tick, snapshot } => {
                let [low, high] = [*last_tick as u32, (*last_tick >> 32) as u32];
                (3, vec![*records, *seal, low, high], snapshot)
            }
            Self::Records { first, newest, bytes } => (4, vec![*first, *newest], bytes),
            Self::Alive { newest } => (5, vec![*newest], &[]),
            Self::End { newest, is_whole } => (6, vec![*newest, u32::from(*is_whole)], &[]),
            Self::Refused(why) => (7, vec![], why.as_bytes()),
            Self::Ask(Ask { goes_on, model, packed }) => {
                let (seal, record) = goes_on.unwrap_or_default();
                let has = [goes_on.is_some(), model.is_some(), *packed].map(u32::from);
                let has = has[0] | has[1] << 1 | has[2] << 2;
                (8, vec![has, seal, record, model.unwrap_or_default()], &[])
            }
        }
    }

    /// Reads the next frame.
    ///
    /// # Errors
    /// The stream's error, at its end [`io::ErrorKind::UnexpectedEof`]; a frame that is damaged or unknown.
    pub fn read(from: &mut impl Read) -> io::Result<Self> {
        // Kind and length.
        let mut head = [0; 5];
        from.read_exact(&mut head)?;
        let [kind, length @ ..] = head;
        let length = u32::from_le_bytes(length);
        if length > CONTENT_BYTES_MAX {
            return Err(bad("a frame is too long: the stream is damaged"));
        }
        // The content, in steps: a damaged length takes no memory that no bytes come for.
        let (mut content, mut left) = (Vec::new(), length as usize);
        while left > 0 {
            let (at, step) = (content.len(), left.min(STEP_BYTES));
            content.resize(at + step, 0);
            from.read_exact(&mut content[at..])?;
            left -= step;
        }
        // The checksum.
        let mut sum = [0; 4];
        from.read_exact(&mut sum)?;
        let mut digest = CRC_32.digest();
        digest.update(&head);
        digest.update(&content);
        if digest.finalize() != u32::from_le_bytes(sum) {
            return Err(bad("a frame's checksum does not match: the stream is damaged"));
        }
        Self::of(kind, &content)
            .ok_or_else(|| bad("a frame is unknown: take the same release on both sides"))
    }

    /// The frame of a kind; `None` for content that is none.
    fn of(kind: u8, content: &[u8]) -> Option<Self> {
        let number = |at: usize| Some(u32::from_le_bytes(*content.get(4 * at..)?.first_chunk()?));
        let behind = |numbers: usize| content.get(4 * numbers..).map(<[u8]>::to_vec);
        Some(match kind {
            1 => Self::Begun(content.to_vec()),
            2 => Self::Model(content.to_vec()),
            3 => {
                let last_tick = u64::from(number(2)?) | u64::from(number(3)?) << 32;
                let (records, seal) = (number(0)?, number(1)?);
                Self::Start { records, seal, last_tick, snapshot: behind(4)? }
            }
            4 => Self::Records { first: number(0)?, newest: number(1)?, bytes: behind(2)? },
            5 => Self::Alive { newest: number(0)? },
            6 => Self::End { newest: number(0)?, is_whole: number(1)? != 0 },
            7 => Self::Refused(String::from_utf8_lossy(content).into_owned()),
            8 => {
                let (has, goes_on) = (number(0)?, (number(1)?, number(2)?));
                let model = number(3).filter(|_| has & 2 != 0);
                let goes_on = Some(goes_on).filter(|_| has & 1 != 0);
                Self::Ask(Ask { goes_on, model, packed: has & 4 != 0 })
            }
            PACKED => {
                let bytes = unpack(content.get(8..)?)?;
                Self::Records { first: number(0)?, newest: number(1)?, bytes }
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames() -> Vec<Frame> {
        vec![
            Frame::Begun(vec![1, 2, 3]),
            Frame::Model(vec![9; 3 << 20]),
            Frame::Start { records: 40, seal: 3, last_tick: 1 << 40 | 7, snapshot: vec![4; 100] },
            Frame::Records { first: 3, newest: 5, bytes: vec![5; 96] },
            Frame::Alive { newest: 5 },
            Frame::End { newest: 6, is_whole: true },
            Frame::Refused("no".into()),
            Frame::Ask(Ask::default()),
            Frame::Ask(Ask { goes_on: Some((0, 0)), ..Ask::default() }),
            Frame::Ask(Ask { packed: true, ..Ask::default() }),
            Frame::Ask(Ask { goes_on: Some((0xab, 12)), model: Some(3), packed: true }),
        ]
    }

    fn read_all(mut bytes: &[u8]) -> (Vec<Frame>, io::Error) {
        let mut read = Vec::new();
        loop {
            match Frame::read(&mut bytes) {
                Ok(frame) => read.push(frame),
                Err(why) => return (read, why),
            }
        }
    }

    #[test]
    fn frames_are_read_as_they_were_written() {
        let mut bytes = Vec::new();
        write_head(&mut bytes).unwrap();
        frames().iter().for_each(|frame| frame.write(&mut bytes).unwrap());
        frames().iter().for_each(|frame| frame.write_packed(&mut bytes).unwrap());
        let mut rest = &bytes[..];
        read_head(&mut rest).unwrap();
        let (read, why) = read_all(rest);
        assert!(read == [frames(), frames()].concat());
        assert_eq!(why.kind(), io::ErrorKind::UnexpectedEof);
    }

    #[test]
    fn a_damaged_stream_is_named() {
        let sent = Frame::Records { first: 3, newest: 5, bytes: vec![5; 96] };
        let (mut plain, mut packed) = (Vec::new(), Vec::new());
        sent.write(&mut plain).unwrap();
        sent.write_packed(&mut packed).unwrap();
        for bytes in [plain, packed] {
            for at in 0..bytes.len() {
                let mut flipped = bytes.clone();
                flipped[at] ^= 1 << (at % 8);
                assert!(read_all(&flipped).0.is_empty(), "byte {at}");
            }
        }
        for (head, part) in [(*b"CHAINMIR\x02\0\0\0", "version"), (*b"HTTP/1.1 200", "no stream")] {
            let why = read_head(&mut &head[..]).unwrap_err().to_string();
            assert!(why.contains(part), "{why}");
        }
    }

    #[test]
    fn words_ask_for_the_same() {
        let ask = Ask { goes_on: Some((0xab, 12)), model: Some(3), packed: true };
        assert_eq!(ask.words(), ["--goes-on=000000ab:12", "--has-model=00000003", "--packed"]);
        assert!(Ask::default().words().is_empty());
        assert_eq!(Ask::goes_on_of("000000ab:12"), Ok((0xab, 12)));
        assert_eq!(Ask::model_of("00000003"), Ok(3));
        for bad in ["ab", "x:1", "1:x", ""] {
            assert!(Ask::goes_on_of(bad).is_err(), "{bad}");
        }
    }
}
