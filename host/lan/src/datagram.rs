//! The datagrams, little-endian, byte for byte: a head, a body, and HMAC-SHA-256 over both.
//!
//! | offset | field |
//! |---|---|
//! | 0 | `chL` and the version, 1 |
//! | 4 | kind u8, tools u8 and poses u8 of the body, 0 |
//! | 8, 24 | random numbers of this session, of the hand and of the agent, 16 bytes each |
//! | 40 | number of the datagram u64, upwards from 1 for each sender in a session |
//! | 48 | send time by the sender's clock u64 \[ns\] |
//! | 56 | send time in the newest datagram of the other side u64, 0 for none \[ns\] |
//! | 64 | time from its arrival until this datagram was sent u64 \[ns\] |
//! | 72 | body |
//! | last 32 | the code |
//!
//! The body of [`Message::Poses`] is the number of the newest pose u64, then for each pose, the newest first, its
//! age u64 \[ns\] and its tools, each as [`ToolPose`]: position f32 x 3, orientation f32 x 4, engaged u16, opening
//! u16. That of [`Message::Forces`] is [`ToolForces`] without `reserved` and the tools that are not in use. That of
//! [`Message::Refused`] is the round trip u64 \[ns\].

use chaincell_client::ToolPose;
use chaincell_client::tools::{OneToolForce, TOOLS_MAX, ToolForces};

use crate::key::Key;

/// First bytes of every datagram; the last of them is the version.
const BEGIN: [u8; 4] = *b"chL\x01";
/// Length of a head, and of a code \[bytes\].
const HEAD_BYTES: usize = 72;
const CODE_BYTES: usize = 32;
/// Longest datagram: below that of a wired LAN \[bytes\].
pub const DATAGRAM_BYTES_MAX: usize = 1400;
/// Most poses in a datagram.
pub const POSES_MAX: usize = 4;

/// A random number that names one side of a session.
pub type Nonce = [u8; 16];

/// All of a datagram but its kind and its body.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Head {
    /// The hand's random number.
    pub hand: Nonce,
    /// The agent's random number, zero before the hand knows it.
    pub agent: Nonce,
    /// Number of the datagram.
    pub sequence: u64,
    /// Send time \[ns\].
    pub stamp_ns: u64,
    /// Send time of the newest datagram of the other side, 0 for none \[ns\].
    pub echo_ns: u64,
    /// Time since its arrival \[ns\].
    pub hold_ns: u64,
}

/// One tick of the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AgedPose {
    /// Time since it was first sent \[ns\].
    pub age_ns: u64,
    /// Its tools, number 0 first; not engaged beyond those in use.
    pub tools: [ToolPose; TOOLS_MAX],
}

impl AgedPose {
    /// No tool is engaged.
    pub const AWAY: Self = Self { age_ns: 0, tools: [ToolPose::AWAY; TOOLS_MAX] };
}

/// The last ticks of the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastPoses {
    /// Number of the newest; the others count downwards from it.
    pub newest: u64,
    /// Number of poses, 1 to [`POSES_MAX`].
    pub poses: usize,
    /// Number of tools of each, 1 to [`TOOLS_MAX`].
    pub tools: usize,
    /// The poses, the newest first.
    pub each: [AgedPose; POSES_MAX],
}

/// The body of a datagram.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// The hand is there, and sends no pose.
    Hello,
    /// Poses of the hand.
    Poses(Box<LastPoses>),
    /// The agent is free: begin with its random number.
    Challenge,
    /// Another hand has the agent.
    Occupied,
    /// The agent measures the round trip, and hands on no pose yet.
    Measuring,
    /// The agent hands on poses.
    Open,
    /// The agent hands on no pose: the p99.9 of the round trip is too long \[ns\].
    Refused(u64),
    /// The answer to a pose; `tick` and `force_tick` are the hand's numbers, `send_ns` is of the hand's clock.
    Forces(Box<ToolForces>),
}

impl Message {
    /// Returns true if a hand sends it; an agent sends the others.
    #[must_use]
    pub fn is_of_hand(&self) -> bool {
        matches!(self, Self::Hello | Self::Poses(_))
    }

    /// Returns the number of its kind, of its tools and of its poses.
    fn words(&self) -> [u8; 3] {
        match self {
            Self::Hello => [1, 0, 0],
            Self::Poses(last) => [2, last.tools as u8, last.poses as u8],
            Self::Challenge => [3, 0, 0],
            Self::Occupied => [4, 0, 0],
            Self::Measuring => [5, 0, 0],
            Self::Open => [6, 0, 0],
            Self::Refused(_) => [7, 0, 0],
            Self::Forces(forces) => [8, forces.tools as u8, 0],
        }
    }
}

/// The reason for which a datagram is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// It is of another program or version.
    Foreign,
    /// Its code is wrong: another key, or damage.
    Forged,
}

/// Returns the bytes of a datagram.
///
/// ```
/// use chaincell_lan::datagram::{Fault, Head, Message, open, seal};
/// use chaincell_lan::key::Key;
///
/// let key = Key::from_hex(&"5a".repeat(32))?;
/// let mut bytes = seal(&key, &Head { sequence: 7, ..Head::default() }, &Message::Hello);
/// assert_eq!(open(&key, &bytes).map(|(head, _)| head.sequence), Ok(7));
/// bytes[40] ^= 1;
/// assert_eq!(open(&key, &bytes), Err(Fault::Forged));
/// # Ok::<(), String>(())
/// ```
#[must_use]
pub fn seal(key: &Key, head: &Head, message: &Message) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(DATAGRAM_BYTES_MAX);
    bytes.extend(BEGIN);
    bytes.extend(message.words());
    bytes.push(0);
    bytes.extend(head.hand);
    bytes.extend(head.agent);
    for word in [head.sequence, head.stamp_ns, head.echo_ns, head.hold_ns] {
        bytes.extend(word.to_le_bytes());
    }
    match message {
        Message::Poses(last) => put_poses(&mut bytes, last),
        Message::Refused(p999_ns) => bytes.extend(p999_ns.to_le_bytes()),
        Message::Forces(forces) => put_forces(&mut bytes, forces),
        _ => {}
    }
    bytes.extend(key.code(&bytes));
    bytes
}

fn put_poses(bytes: &mut Vec<u8>, last: &LastPoses) {
    bytes.extend(last.newest.to_le_bytes());
    for pose in last.each.iter().take(last.poses) {
        bytes.extend(pose.age_ns.to_le_bytes());
        for tool in pose.tools.iter().take(last.tools) {
            let position_m: [f32; 3] = tool.position_m.into();
            for number in position_m.iter().chain(&tool.orientation) {
                bytes.extend(number.to_le_bytes());
            }
            bytes.extend(tool.engaged.to_le_bytes());
            bytes.extend(tool.opening_turns_q16.to_le_bytes());
        }
    }
}

fn put_forces(bytes: &mut Vec<u8>, forces: &ToolForces) {
    let ToolForces { tick, session_id, force_tick, send_ns, state_hash, .. } = *forces;
    for word in [tick, session_id, force_tick, send_ns, state_hash] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(forces.energy_j.to_le_bytes());
    for word in [forces.flags, forces.step_ns, forces.sweeps] {
        bytes.extend(word.to_le_bytes());
    }
    for tool in forces.each.iter().take(forces.tools as usize) {
        for word in [tool.number, tool.contacts, tool.flags] {
            bytes.extend(word.to_le_bytes());
        }
        for number in tool
            .force_n
            .iter()
            .chain(&tool.torque_n_m)
            .chain([&tool.force_error_n, &tool.torque_error_n_m])
        {
            bytes.extend(number.to_le_bytes());
        }
    }
}

/// Checks the code of a datagram, and reads it.
///
/// # Errors
/// A datagram of another program, version or key, or a damaged one.
pub fn open(key: &Key, bytes: &[u8]) -> Result<(Head, Message), Fault> {
    if !bytes.starts_with(&BEGIN) || bytes.len() < HEAD_BYTES + CODE_BYTES {
        return Err(Fault::Foreign);
    }
    let Some((text, code)) = bytes.split_last_chunk::<CODE_BYTES>() else {
        return Err(Fault::Foreign);
    };
    if !key.is_code(text, code) {
        return Err(Fault::Forged);
    }
    let mut reader = Reader(&text[BEGIN.len()..]);
    let read = read(&mut reader).filter(|_| reader.0.is_empty());
    read.ok_or(Fault::Foreign)
}

fn read(reader: &mut Reader<'_>) -> Option<(Head, Message)> {
    let [kind, tools, poses, _] = reader.take()?;
    let head = Head {
        hand: reader.take()?,
        agent: reader.take()?,
        sequence: reader.u64()?,
        stamp_ns: reader.u64()?,
        echo_ns: reader.u64()?,
        hold_ns: reader.u64()?,
    };
    let message = match kind {
        1 => Message::Hello,
        2 => Message::Poses(Box::new(reader.poses(tools.into(), poses.into())?)),
        3 => Message::Challenge,
        4 => Message::Occupied,
        5 => Message::Measuring,
        6 => Message::Open,
        7 => Message::Refused(reader.u64()?),
        8 => Message::Forces(Box::new(reader.forces(tools.into())?)),
        _ => return None,
    };
    // Of the numbers that a kind does not use none is set.
    (message.words() == [kind, tools, poses]).then_some((head, message))
}

/// The bytes that were not read yet.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn floats<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut floats = [0.0; N];
        for float in &mut floats {
            *float = self.take().map(f32::from_le_bytes)?;
        }
        Some(floats)
    }

    fn poses(&mut self, tools: usize, poses: usize) -> Option<LastPoses> {
        if !(1..=TOOLS_MAX).contains(&tools) || !(1..=POSES_MAX).contains(&poses) {
            return None;
        }
        let newest = self.u64()?;
        let mut each = [AgedPose::AWAY; POSES_MAX];
        for pose in each.iter_mut().take(poses) {
            pose.age_ns = self.u64()?;
            for tool in pose.tools.iter_mut().take(tools) {
                tool.position_m = self.floats::<3>()?.into();
                tool.orientation = self.floats()?;
                (tool.engaged, tool.opening_turns_q16) = (self.u16()?, self.u16()?);
            }
        }
        Some(LastPoses { newest, poses, tools, each })
    }

    fn forces(&mut self, tools: usize) -> Option<ToolForces> {
        if tools > TOOLS_MAX {
            return None;
        }
        let mut forces = ToolForces {
            tick: self.u64()?,
            session_id: self.u64()?,
            force_tick: self.u64()?,
            send_ns: self.u64()?,
            state_hash: self.u64()?,
            energy_j: self.floats::<1>()?[0],
            flags: self.u32()?,
            step_ns: self.u32()?,
            sweeps: self.u32()?,
            tools: tools as u32,
            ..ToolForces::default()
        };
        for tool in forces.each.iter_mut().take(tools) {
            *tool = OneToolForce {
                number: self.u32()?,
                contacts: self.u32()?,
                flags: self.u32()?,
                force_n: self.floats()?,
                torque_n_m: self.floats()?,
                force_error_n: self.floats::<1>()?[0],
                torque_error_n_m: self.floats::<1>()?[0],
            };
        }
        Some(forces)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn key(digits: &str) -> Key {
        Key::from_hex(&digits.repeat(32)).unwrap()
    }

    fn head() -> Head {
        Head { hand: [3; 16], agent: [4; 16], sequence: 5, stamp_ns: 6, echo_ns: 7, hold_ns: 8 }
    }

    fn poses(tools: usize, poses: usize) -> Message {
        let mut last = LastPoses { newest: 9, poses, tools, each: [AgedPose::AWAY; POSES_MAX] };
        for (at, pose) in last.each.iter_mut().take(poses).enumerate() {
            pose.age_ns = 1_000_000 * at as u64;
            for (tool, place) in pose.tools.iter_mut().take(tools).enumerate() {
                *place = ToolPose::at([at as f32, tool as f32, -0.5].into(), 1);
                place.orientation = [0.0, 0.6, 0.0, 0.8];
                *place = place.with_opening_rad(0.5);
            }
        }
        Message::Poses(Box::new(last))
    }

    fn forces(tools: u32) -> Message {
        let mut forces =
            ToolForces { tick: 9, session_id: 10, force_tick: 8, send_ns: 7, ..Default::default() };
        (forces.state_hash, forces.energy_j, forces.flags) = (11, 0.5, 257);
        (forces.step_ns, forces.sweeps, forces.tools) = (400_000, 4, tools);
        for (number, tool) in (0..tools).zip(&mut forces.each) {
            let force_n = [number as f32, 2.0, -3.0];
            *tool = OneToolForce {
                number,
                contacts: 5,
                force_n,
                torque_n_m: [0.5; 3],
                flags: 8,
                force_error_n: -1.0,
                torque_error_n_m: 0.25,
            };
        }
        Message::Forces(Box::new(forces))
    }

    fn all() -> Vec<Message> {
        let plain = [Message::Hello, Message::Challenge, Message::Occupied, Message::Measuring];
        let long = [poses(1, 1), poses(8, 4), poses(3, 2), forces(0), forces(1), forces(8)];
        plain.into_iter().chain(long).chain([Message::Open, Message::Refused(7_000_000)]).collect()
    }

    #[test]
    fn each_message_comes_back_and_fits_into_a_datagram() {
        for message in all() {
            let bytes = seal(&key("5a"), &head(), &message);
            assert!(bytes.len() <= DATAGRAM_BYTES_MAX, "{} bytes: {message:?}", bytes.len());
            assert_eq!(open(&key("5a"), &bytes), Ok((head(), message)));
        }
    }

    #[test]
    fn a_changed_bit_a_cut_and_another_key_are_seen() {
        for message in all() {
            let bytes = seal(&key("5a"), &head(), &message);
            assert_eq!(open(&key("5b"), &bytes), Err(Fault::Forged));
            for bit in (0..8 * bytes.len()).filter(|bit| bytes.len() < 200 || bit % 7 == 0) {
                let mut bytes = bytes.clone();
                bytes[bit / 8] ^= 1 << (bit % 8);
                assert!(open(&key("5a"), &bytes).is_err(), "bit {bit} of {message:?}");
            }
            for length in (0..bytes.len()).step_by(3) {
                assert!(open(&key("5a"), &bytes[..length]).is_err(), "{length} of {message:?}");
            }
        }
    }

    #[test]
    fn counts_beyond_their_limits_are_refused_with_the_right_key_too() {
        let counts = |tools, poses| {
            let each = [AgedPose::AWAY; POSES_MAX];
            Message::Poses(Box::new(LastPoses { newest: 9, poses, tools, each }))
        };
        for (tools, count) in [(0, 1), (9, 1), (1, 0), (1, 5)] {
            let bytes = seal(&key("5a"), &head(), &counts(tools, count));
            assert_eq!(open(&key("5a"), &bytes), Err(Fault::Foreign), "{tools} {count}");
        }
        // Unknown kinds, and counts of a kind that has none.
        for (at, count) in [(4, 0), (4, 9), (5, 1), (6, 1)] {
            let bytes = seal(&key("5a"), &head(), &Message::Hello);
            let mut text = bytes[..bytes.len() - CODE_BYTES].to_vec();
            text[at] = count;
            text.extend(key("5a").code(&text));
            assert_eq!(open(&key("5a"), &text), Err(Fault::Foreign), "byte {at}: {count}");
        }
    }

    proptest! {
        /// Bytes of anybody who has the key.
        #[test]
        fn any_bytes_with_the_right_code_are_read_or_refused(
            body in proptest::collection::vec(any::<u8>(), 0..1300),
            kind in 0u8..10,
        ) {
            let mut text = BEGIN.to_vec();
            text.push(kind);
            text.extend(body);
            text.extend(key("5a").code(&text));
            if let Ok((head, message)) = open(&key("5a"), &text) {
                let again = open(&key("5a"), &seal(&key("5a"), &head, &message));
                prop_assert_eq!(again.map(|(head, _)| head), Ok(head));
            }
        }
    }
}
