//! Which records of a session a receiver has, and what it misses.

use chaincell_host::files::recording::{seal_of, seal_of_begun};
use chaincell_host::remote::frame::{Ask, Frame};
use chaincell_kernel::trace::RECORD_BYTES;

use crate::message::Message;

/// A receiver's place in a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Position {
    /// Index of the record that comes next.
    next: u32,
    /// What identifies the session up to there.
    seal: u32,
}

/// What a published message is to a receiver.
#[derive(Debug, PartialEq, Eq)]
pub enum Heard {
    /// The frame comes next.
    Next(Frame),
    /// Its records are there already.
    Old,
    /// Records before it are missing, or it is of another session: ask.
    Missing,
}

/// Puts the records of messages and answers in one sequence, each once.
#[derive(Debug)]
pub struct Sequence {
    position: Option<Position>,
    model: Option<u32>,
    /// Frames of an answer before the receiver knows its place.
    held: Vec<Frame>,
    begun_seal: u32,
}

impl Sequence {
    /// A receiver that asks for this first: all of a session, or what it misses of one that it has begun.
    #[must_use]
    pub fn new(ask: &Ask) -> Self {
        let position = ask.goes_on.map(|(seal, next)| Position { next, seal });
        Self { position, model: ask.model, held: Vec::new(), begun_seal: 0 }
    }

    /// Returns what to ask for now. Frames of an answer that broke off before the first record are let go.
    pub fn ask(&mut self) -> Ask {
        self.held.clear();
        Ask {
            goes_on: self.position.map(|Position { next, seal }| (seal, next)),
            model: self.model,
            packed: false,
        }
    }

    /// Takes a published message.
    pub fn hear(&mut self, message: Message) -> Heard {
        let Some(position) = self.position else { return Heard::Missing };
        let Message { seal, frame } = message;
        if let Some(next) = stated(&frame) {
            let is_here = Position { next, seal } == position;
            return if is_here { Heard::Next(frame) } else { Heard::Missing };
        }
        // Somebody else published another frame.
        let Frame::Records { first, newest, bytes } = frame else { return Heard::Old };
        let end = u64::from(first) + (bytes.len() / RECORD_BYTES) as u64;
        if first <= position.next && end <= u64::from(position.next) {
            return Heard::Old;
        }
        self.add(seal, first, newest, &bytes).map_or(Heard::Missing, Heard::Next)
    }

    /// Takes a frame of an answer, in the order in which it was sent; returns what comes next.
    pub fn answer(&mut self, frame: Frame) -> Vec<Frame> {
        let Some(position) = self.position else { return self.begin(frame) };
        match frame {
            Frame::Records { first, newest, bytes } => {
                self.add(position.seal, first, newest, &bytes).into_iter().collect()
            }
            Frame::Refused(_) => vec![frame],
            _ if stated(&frame) == Some(position.next) => vec![frame],
            // The session's beginning is there.
            _ => Vec::new(),
        }
    }

    /// Takes a frame of an answer before the first record: all is held, since the answer may break off.
    fn begin(&mut self, frame: Frame) -> Vec<Frame> {
        if let Frame::Begun(begun) = &frame {
            self.begun_seal = seal_of_begun(begun);
        }
        match frame {
            Frame::Begun(_) | Frame::Model(_) | Frame::Start { .. } => {
                self.held.push(frame);
                Vec::new()
            }
            Frame::Records { .. } | Frame::Alive { .. } | Frame::End { .. } => {
                self.position = self.start(&frame);
                if self.position.is_none() {
                    return Vec::new();
                }
                let mut frames = std::mem::take(&mut self.held);
                frames.extend(self.answer(frame));
                frames
            }
            Frame::Refused(_) => vec![frame],
            Frame::Ask(_) => Vec::new(),
        }
    }

    /// The place at which a session begins for this receiver, before the first frame after the held ones.
    fn start(&self, first_frame: &Frame) -> Option<Position> {
        let has_begun = self.held.iter().any(|frame| matches!(frame, Frame::Begun(_)));
        if let Some(&Frame::Start { records, seal, .. }) = self.held.last() {
            return Some(Position { next: records, seal });
        }
        let next = match *first_frame {
            Frame::Records { first, .. } => Some(first),
            _ => stated(first_frame),
        };
        next.filter(|_| has_begun).map(|next| Position { next, seal: self.begun_seal })
    }

    /// Adds records from `first` on, before which `seal` identifies the session, without those that are there.
    /// Returns those that are new; `None` if there are none, others before them are missing, or the session is
    /// another one.
    fn add(&mut self, seal: u32, first: u32, newest: u32, bytes: &[u8]) -> Option<Frame> {
        let position = self.position?;
        let (records, _) = bytes.as_chunks::<RECORD_BYTES>();
        let known = position.next.checked_sub(first)? as usize;
        let fresh = records.get(known..).filter(|fresh| !fresh.is_empty())?;
        // The record before the new ones has to be the last that is there.
        let before = match known.checked_sub(1) {
            Some(last) => records.get(last).map_or(seal, seal_of),
            None => seal,
        };
        if before != position.seal {
            return None;
        }
        let next = position.next.checked_add(u32::try_from(fresh.len()).ok()?)?;
        self.position = Some(Position { next, seal: fresh.last().map_or(seal, seal_of) });
        Some(Frame::Records { first: position.next, newest, bytes: fresh.concat() })
    }
}

/// The number of records that a frame states which has none of them.
fn stated(frame: &Frame) -> Option<u32> {
    match *frame {
        Frame::Alive { newest } | Frame::End { newest, .. } => Some(newest),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
