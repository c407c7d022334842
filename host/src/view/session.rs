//! A recorded session for the page: what the kernel got in each tick, without output stage and checksums.
//!
//! The trace is played once, and what its tissue was given is written down; the page's kernel plays that to the
//! same states. All words are little-endian and of 32 bits, as they are in memory of the kernel's C interface:
//!
//! ```text
//! 0        1    magic "CSES"
//! 1        1    version of this layout: 2
//! 2        1    scheme, a code of `chaincell_scheme`
//! 3        8    settings, a `chaincell_settings`
//! 11       1    coefficient of friction (f32 bits)
//! 12       1    T = number of tools, 0 with held cells
//! 13       1    P = number of their parts
//! 14       1    H = number of held cells
//! 15       1    S = bytes of the snapshot that the session begins from, 0 at rest
//! 16       2    number of the first tick: low word, high word
//! 18       1    number of the last tick less the first
//!          T    number of parts of each tool
//!     11 * P    parts, each a `chaincell_tool_part`
//!          H    input ids of the held cells
//!      S / 4    snapshot for `chaincell_tissue_restore`, rounded up to a word with zeros
//! then events up to the end, each after a word: kind in bits 0 to 7, flags in bits 8 to 15, sweeps in bits 16 to 31
//! 1 tick        number less that of the first tick; max(T, 1) poses, each a `chaincell_tool_pose`; with flag 1
//!               two words of the state hash after it, low and high. Sweeps count with flag 2: 0 for a late tick,
//!               else at most so many; without flag 2 all of the settings
//! 2 still tick  number less that of the first tick: answered in a pause, nothing moved
//! 3 settings    8 words, a `chaincell_settings` from here on
//! 4 reset       the body at rest, the tools let go
//! 5 grip        number of the tool
//! 6 let go      number of the tool, ticks in which the pull falls to 0
//! 7 pin         number of the tool that holds the tissue, stiffness (f32 bits), infinite for a rigid pin
//! 8 pin at      x, y, z, radius and stiffness (f32 bits)
//! 9 unpin       number of the pin, ticks in which its force falls to 0
//! ```

use chaincell_kernel::trace::{Command, Reader, Record};
use chaincell_kernel::{Arithmetic, Choice, Cutting, Scheme, Settings, ToolPart, ToolPose};

use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::{Contact, Engine};
use crate::error::{Error, Result};
use crate::files::recording::{self, Played, Start, Step, Stop};

const MAGIC: u32 = u32::from_le_bytes(*b"CSES");
const VERSION: u32 = 2;
/// Words before the lists, and the place of the two numbers that are known at the end.
const HEAD_WORDS: usize = 19;
const FIRST_TICK_WORD: usize = 16;
/// A state hash goes along with every tick whose number this divides, and with the last.
const HASH_TICKS: u64 = 20;
const TICK: u32 = 1;
const STILL: u32 = 2;
const SETTINGS: u32 = 3;
const RESET: u32 = 4;
const GRIP: u32 = 5;
const LET_GO: u32 = 6;
const PIN: u32 = 7;
const PIN_AT: u32 = 8;
const UNPIN: u32 = 9;
const HAS_HASH: u32 = 1 << 8;
const HAS_SWEEPS: u32 = 1 << 9;

/// Plays a session and returns it in this layout, with the number of its ticks. `tissue` is where the session
/// starts.
///
/// # Errors
/// A session that does not come to its recorded states, that holds no tick, or that spans more than 49 days.
pub fn packed(
    trace: &Reader<'_>,
    tissue: &mut Staged<'_>,
    (scheme, precision): (Scheme, Arithmetic),
    start: Start,
) -> Result<(Vec<u8>, u32)> {
    let mut session = Session::begin(tissue, c_scheme(scheme, precision)?, start)?;
    let mut played = Played::default();
    let mut problem = None;
    let ended = recording::play(trace, tissue, start, &mut played, |tissue, step| {
        problem = session.add(tissue, step).err();
        problem.is_none()
    });
    match (ended, problem) {
        (_, Some(why)) => Err(why),
        (Err(Stop::Differs(why)), None) => Err(Error::check(why)),
        (Err(why), None) => Err(Error::input(format!("it cannot be played: {why:?}"))),
        (Ok(_), None) if session.first.is_none() => {
            Err(Error::input("it holds no tick: record again"))
        }
        (Ok(_), None) => Ok((session.finish(), played.ticks)),
    }
}

/// A `chaincell_settings`: there `cut` has a word of its own, behind the others.
fn page_words(settings: Settings) -> [u32; Settings::WORDS + 1] {
    let mut words = [u32::from(settings.cut.code()); Settings::WORDS + 1];
    words[..Settings::WORDS].copy_from_slice(&Settings { cut: Cutting::On, ..settings }.words());
    words
}

/// The words under way.
struct Session {
    words: Vec<u32>,
    tools: usize,
    first: Option<u64>,
    last: u64,
    /// Where the last tick and its hash stand.
    last_tick: Option<(usize, u64)>,
}

impl Session {
    fn begin(tissue: &mut Staged<'_>, scheme: u32, start: Start) -> Result<Self> {
        let engine = tissue.engine();
        let (contact, settings) = (engine.contact(), *engine.network().settings());
        let mut words = vec![MAGIC, VERSION, scheme];
        words.extend(page_words(settings));
        let (counts, parts, friction) = match contact {
            Contact::Tools { tools, friction } => {
                let counts = tools.iter().map(|tool| tool.len() as u32).collect();
                (counts, tools.concat(), *friction)
            }
            Contact::Cells(_) => (Vec::new(), Vec::new(), 0.0),
        };
        let held = held_ids(engine);
        let snapshot =
            if start.behind.is_some() { tissue.engine_mut().save()? } else { Vec::new() };
        words.push(friction.to_bits());
        words.extend(
            [counts.len(), parts.len(), held.len(), snapshot.len()].map(|count| count as u32),
        );
        words.resize(HEAD_WORDS, 0);
        words.extend(&counts);
        words.extend(parts.iter().flat_map(part_words));
        words.extend(held);
        words.extend(snapshot.chunks(4).map(|bytes| {
            let mut word = [0; 4];
            word[..bytes.len()].copy_from_slice(bytes);
            u32::from_le_bytes(word)
        }));
        Ok(Self { words, tools: counts.len(), first: None, last: 0, last_tick: None })
    }

    fn add(&mut self, tissue: &mut Staged<'_>, step: Step<'_>) -> Result<()> {
        match step {
            Step::Tick { record, output: Some(_), .. } => self.add_tick(tissue, record)?,
            Step::Tick { record, output: None, .. } => {
                let offset = self.offset(record.tick)?;
                self.words.extend([STILL, offset]);
            }
            Step::Command(record) => match record.command {
                Command::Pause | Command::Resume | Command::Snapshot { .. } => {}
                Command::Reset => self.words.push(RESET),
                Command::Grip { tool } => self.words.extend([GRIP, tool]),
                Command::LetGo { tool, ticks } => self.words.extend([LET_GO, tool, ticks.into()]),
                Command::Pin { tool, stiffness_n_per_m } => {
                    self.words.extend([PIN, tool, stiffness_n_per_m.to_bits()]);
                }
                Command::PinAt { point_m: [x, y, z], radius_m, stiffness_n_per_m } => {
                    self.words.push(PIN_AT);
                    self.words.extend([x, y, z, radius_m, stiffness_n_per_m].map(f32::to_bits));
                }
                Command::Unpin { pin, ticks } => {
                    self.words.extend([UNPIN, pin.into(), ticks.into()])
                }
                Command::Sweeps(_)
                | Command::MaxForceN(_)
                | Command::MaxToolStepM(_)
                | Command::Unloading(_)
                | Command::Cut(_) => {
                    self.words.push(SETTINGS);
                    self.words.extend(page_words(*tissue.engine().network().settings()));
                }
            },
        }
        Ok(())
    }

    fn add_tick(&mut self, tissue: &mut Staged<'_>, record: &Record) -> Result<()> {
        let hash = tissue.state_hash();
        let has_hash = if record.tick.is_multiple_of(HASH_TICKS) { HAS_HASH } else { 0 };
        let sweeps = record.sweeps.map_or(0, |sweeps| HAS_SWEEPS | u32::from(sweeps) << 16);
        let offset = self.offset(record.tick)?;
        self.last_tick = Some((self.words.len(), hash));
        self.words.extend([TICK | has_hash | sweeps, offset]);
        let poses = tissue.passed().each().iter().take(self.tools.max(1));
        self.words.extend(poses.flat_map(pose_words));
        if has_hash != 0 {
            self.words.extend([hash as u32, (hash >> 32) as u32]);
        }
        Ok(())
    }

    /// The number of a tick less that of the first.
    fn offset(&mut self, tick: u64) -> Result<u32> {
        let first = *self.first.get_or_insert(tick);
        self.last = tick;
        let offset = tick.checked_sub(first).and_then(|offset| u32::try_from(offset).ok());
        offset.ok_or_else(|| {
            Error::input(format!("its ticks go from {first} to {tick}: the page shows 49 days"))
        })
    }

    fn finish(mut self) -> Vec<u8> {
        let first = self.first.unwrap_or_default();
        let numbers = [first as u32, (first >> 32) as u32, (self.last - first) as u32];
        self.words[FIRST_TICK_WORD..HEAD_WORDS].copy_from_slice(&numbers);
        // The last tick has its hash, wherever it stands.
        if let Some((at, hash)) = self.last_tick
            && self.words[at] & HAS_HASH == 0
        {
            self.words[at] |= HAS_HASH;
            let end = at + 2 + 8 * self.tools.max(1);
            self.words.splice(end..end, [hash as u32, (hash >> 32) as u32]);
        }
        self.words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }
}

/// The scheme in the C interface.
fn c_scheme(scheme: Scheme, precision: Arithmetic) -> Result<u32> {
    match (scheme, precision) {
        (scheme, Arithmetic::F32) => Ok(u32::from(scheme.code())),
        (Scheme::Track, Arithmetic::Fixed) => Ok(5),
        (Scheme::Euler, Arithmetic::Fixed) => Ok(6),
        _ => Err(Error::input(format!(
            "the page's kernel has no scheme {} in {}",
            scheme.name(),
            precision.name()
        ))),
    }
}

/// A `chaincell_tool_part`.
fn part_words(part: &ToolPart) -> [u32; 11] {
    let ToolPart { centre_m: [x, y, z], orientation: [i, j, k, w], half_m: [a, b, c], radius_m } =
        *part;
    [x, y, z, i, j, k, w, a, b, c, radius_m].map(f32::to_bits)
}

/// A `chaincell_tool_pose`.
fn pose_words(pose: &ToolPose) -> [u32; 8] {
    let ([x, y, z], [i, j, k, w]): ([f32; 3], _) = (pose.position_m.into(), pose.orientation);
    let [x, y, z, i, j, k, w] = [x, y, z, i, j, k, w].map(f32::to_bits);
    let acting = u32::from(pose.engaged) | u32::from(pose.opening_turns_q16) << 16;
    [x, y, z, i, j, k, w, acting]
}

/// Input ids of the held cells.
fn held_ids(engine: &Engine<'_>) -> Vec<u32> {
    let ids = engine.network().model().input_id();
    engine.contacts().iter().filter_map(|&cell| ids.get(usize::from(cell)).copied()).collect()
}
