//! States and samples that no body and no tool should come to: what every target must survive, with
//! the same bits.
//!
//! The body is put into each of the [`STATES`] and left alone; then the tool takes hold and jumps
//! from place to place, then samples are any bits at all, then the tool is gone. The whole is
//! integer and plain `f32` arithmetic.

use chaincell_kernel::{Dynamics, Flags, Model, Number, TickOutput, TissueMut, ToolPose};
use nalgebra::Vector3;

use crate::{Run, RunError, Scene};

/// Names of the states, in the order in which they are played.
pub const STATES: [&str; 4] = ["coincident", "flattened", "inverted", "scattered"];
/// Ticks of each part.
const PART: u32 = 6;
/// Ticks from a state on.
pub const STATE_TICKS: u32 = 6 * PART;
/// How far the scattered cells lie from the centre [mean link lengths].
const SCATTER: f32 = 1.0e5;
/// How far the tool jumps \[m\].
const JUMP_M: f32 = 10.0;

/// What went wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wrong {
    /// The scene is refused, or a state.
    Refused,
    /// Positions that are not finite are taken, or change the state.
    Taken,
    /// Force, energy or a position is not finite.
    NotFinite,
    /// The level rises while nothing acts from outside.
    Rises,
}

impl Wrong {
    /// In a word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Refused => "refused",
            Self::Taken => "taken",
            Self::NotFinite => "not_finite",
            Self::Rises => "rises",
        }
    }
}

/// Where and what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdverseError {
    /// Name of the state.
    pub state: &'static str,
    /// Tick after it.
    pub tick: u32,
    /// What went wrong.
    pub what: Wrong,
}

impl core::fmt::Display for AdverseError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { state, tick, what } = self;
        write!(f, "{state}, tick {tick}: {}", what.name())
    }
}

impl core::error::Error for AdverseError {}

/// A well-mixed word for each pair of numbers.
fn mixed(a: u32, b: u32) -> u32 {
    let mut x = a.wrapping_mul(0x9E37_79B9) ^ b.wrapping_mul(0x85EB_CA6B) ^ 0x5BD1_E995;
    for _ in 0..2 {
        x = (x ^ (x >> 16)).wrapping_mul(0x7FEB_352D);
    }
    x ^ (x >> 15)
}

/// From -1 to 1, the same for each pair of numbers.
fn part_of_one(a: u32, b: u32) -> f32 {
    (mixed(a, b) >> 8) as f32 / 8_388_608.0 - 1.0
}

/// A cell's place in a state [mean link lengths].
fn position(model: &Model<'_>, state: &str, cell: usize) -> [f32; 3] {
    let rest = model.rest_position(cell);
    match state {
        "coincident" => [0.25, -0.5, 0.125],
        // A plane body becomes a line.
        "flattened" => [rest[0], 0.0, rest[2]],
        "inverted" => rest.map(|x| -x),
        _ => [0, 1, 2].map(|axis| SCATTER * part_of_one(cell as u32, axis)),
    }
}

/// The sample of a tick after a state: away, jumping, any bits, bad until the safe state, away.
fn sample(tick: u32) -> ToolPose {
    let jump = [0, 1, 2].map(|axis| JUMP_M * part_of_one(tick, axis));
    let bits = [3, 4, 5].map(|axis| f32::from_bits(mixed(tick, axis)));
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX];
    let (position, engaged) = match tick / PART {
        1 => (jump, 1),
        2 => (bits, [1, 1, 2, u32::MAX].get(tick as usize % 4).copied().unwrap_or(1)),
        3 | 4 => (jump.map(|_| bad.get(tick as usize % 4).copied().unwrap_or(0.0)), 1 + tick % 2),
        _ => (jump, 0),
    };
    ToolPose::at(Vector3::from(position), engaged)
}

impl<D: Dynamics> Run<'_, D> {
    /// Puts the body into a state; `room` has a place for each cell.
    fn put(&mut self, state: &'static str, room: &mut [[f32; 3]]) -> Result<(), Wrong> {
        let model = *self.network.model();
        let room = room.get_mut(..model.cells()).ok_or(Wrong::Refused)?;
        for (cell, place) in room.iter_mut().enumerate() {
            *place = position(&model, state, cell);
        }
        // One place that is none must leave all as it is.
        let before = self.tissue.state_hash(&model);
        for bad in [f32::NAN, f32::NEG_INFINITY] {
            let Some(last) = room.last_mut() else { return Err(Wrong::Refused) };
            let good = core::mem::replace(last, [0.0, bad, 0.0]);
            let taken = self.tissue.set_positions(&self.network, room).is_ok();
            if taken || self.tissue.state_hash(&model) != before {
                return Err(Wrong::Taken);
            }
            if let Some(last) = room.last_mut() {
                *last = good;
            }
        }
        self.tissue.set_positions(&self.network, room).map_err(|_| Wrong::Refused)
    }

    fn is_finite(&self, output: &TickOutput) -> bool {
        let model = self.network.model();
        let finite = |cell| {
            let position = self.tissue.position(model, cell);
            position.is_some_and(|position| position.iter().all(|x| x.single().is_finite()))
        };
        output.force_n.iter().all(|x| x.is_finite())
            && output.energy_j.is_finite()
            && (0..model.cells()).all(finite)
    }

    /// Plays a state's ticks.
    fn endure(&mut self) -> Result<(), (u32, Wrong)> {
        let mut before: Option<TickOutput> = None;
        for tick in 0..STATE_TICKS {
            let (output, _) = self.tick_with(&sample(tick));
            if !self.is_finite(&output) {
                return Err((tick, Wrong::NotFinite));
            }
            // Bands that close are an act from outside.
            let closed = |output: &TickOutput| output.flags.contains(Flags::BAND_CLOSED);
            let rises = before.is_some_and(|before| {
                let alone = before.contacts == 0 && output.contacts == 0;
                alone && closed(&before) == closed(&output) && output.energy_j > before.energy_j
            });
            if rises {
                return Err((tick, Wrong::Rises));
            }
            before = Some(output);
        }
        Ok(())
    }
}

/// Plays all states in `tissue`; `room` has a place for each cell. Tells `each` the digest of all
/// ticks so far after each state.
///
/// Not for `euler`, whose level is the energy of its last pass and may rise by rounding.
///
/// # Errors
/// The first thing that goes wrong.
pub fn endure<D: Dynamics>(
    scene: &'static Scene,
    tissue: TissueMut<'_, D>,
    room: &mut [[f32; 3]],
    mut each: impl FnMut(&'static str, u64),
) -> Result<(), AdverseError> {
    let refused = |_: RunError| AdverseError { state: "rest", tick: 0, what: Wrong::Refused };
    let mut run = Run::new(scene, tissue).map_err(refused)?;
    for state in STATES {
        run.put(state, room).map_err(|what| AdverseError { state, tick: 0, what })?;
        run.endure().map_err(|(tick, what)| AdverseError { state, tick, what })?;
        each(state, run.digest());
    }
    Ok(())
}
