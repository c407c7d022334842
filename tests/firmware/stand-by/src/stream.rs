//! The stream of `chaincell mirror`, whose layout is in `host/src/remote/frame.rs`: each frame has a checksum.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

const HEAD: [u8; 12] = *b"CHAINMIR\x01\0\0\0";

pub static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Why the board follows no further.
pub enum Stop {
    /// Nothing has come for long: the sender is gone.
    Silent,
    /// The sender's program was killed: the mirror reports it.
    Killed,
    /// The session has ended by itself.
    Ended,
    /// This came out otherwise, or is not for this board: the session may go on elsewhere.
    Refused(&'static str),
}

/// Frames of a line.
pub struct Stream<N> {
    /// The next byte; `None` in a silence.
    next: N,
    /// Checksum of the frame so far.
    digest: Digest<'static, u32, Table<1>>,
    /// Bytes of the frame's content that have not been taken.
    left: usize,
}

impl<N: FnMut() -> Option<u8>> Stream<N> {
    /// Reads what a stream begins with.
    pub fn begin(next: N) -> Result<Self, Stop> {
        let mut stream = Self { next, digest: CRC.digest(), left: 0 };
        for byte in HEAD {
            if stream.byte()? != byte {
                return Err(Stop::Refused(
                    "it is no stream of chaincell mirror, or another version",
                ));
            }
        }
        Ok(stream)
    }

    fn byte(&mut self) -> Result<u8, Stop> {
        (self.next)().ok_or(Stop::Silent)
    }

    fn bytes<const COUNT: usize>(&mut self) -> Result<[u8; COUNT], Stop> {
        let mut bytes = [0; COUNT];
        for byte in &mut bytes {
            *byte = self.byte()?;
        }
        Ok(bytes)
    }

    /// Begins the next frame, and returns its kind.
    pub fn frame(&mut self) -> Result<u8, Stop> {
        let head: [u8; 5] = self.bytes()?;
        self.digest = CRC.digest();
        self.digest.update(&head);
        let [kind, length @ ..] = head;
        self.left = u32::from_le_bytes(length) as usize;
        Ok(kind)
    }

    /// Bytes of the frame's content that have not been taken.
    pub fn left(&self) -> usize {
        self.left
    }

    /// Takes bytes of the frame's content. They may be damaged, until [`Self::end`] says that they are not.
    pub fn take(&mut self, to: &mut [u8]) -> Result<(), Stop> {
        let left = self.left.checked_sub(to.len());
        self.left = left.ok_or(Stop::Refused("a frame is too short: the stream is damaged"))?;
        for byte in &mut *to {
            *byte = self.byte()?;
        }
        self.digest.update(to);
        Ok(())
    }

    /// Takes a number of the frame's content.
    pub fn number(&mut self) -> Result<u32, Stop> {
        let mut bytes = [0; 4];
        self.take(&mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }

    /// Takes the rest of the frame's content to the front of `to`, and ends the frame.
    pub fn rest<'t>(&mut self, to: &'t mut [u8]) -> Result<&'t [u8], Stop> {
        let rest = to.get_mut(..self.left);
        let rest = rest.ok_or(Stop::Refused("a frame is too long for this board, or damaged"))?;
        self.take(rest)?;
        self.end()?;
        Ok(rest)
    }

    /// Ends the frame: its content is as it was sent.
    pub fn end(&mut self) -> Result<(), Stop> {
        let is_whole = self.left == 0;
        let sum = self.digest.clone().finalize();
        match u32::from_le_bytes(self.bytes()?) == sum && is_whole {
            true => Ok(()),
            false => Err(Stop::Refused("a frame's checksum does not match: the stream is damaged")),
        }
    }
}
