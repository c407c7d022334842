//! Commands: the changes of a run between two ticks.
//!
//! In a record of kind 2, or 5 for those of a tool and of pins, the eight bytes from 0 hold the number of the last tick
//! before the command, 8 the command, 12 the parameter, 16 the value (f32 bits), 20 zero. That of a pin at a point has
//! there its command, the point (f32 bits x 3), and at 36 its radius and at 40 its stiffness (f32 bits). The hash,
//! the flag for it and the checksum are those of a sample's record.

use core::fmt;

use super::{KIND_COMMAND, KIND_TOOL_COMMAND};
use crate::tick::choice::Choice;
use crate::tick::choices::{Cutting, Unloading};
use crate::tick::settings::Settings;

/// A change of a run between two ticks.
///
/// ```
/// # use chaincell_kernel::{Model, Settings, include_model};
/// use chaincell_kernel::trace::Command;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
///
/// let command = Command::MaxForceN(3.0); // [N]
/// assert_eq!(command.words(), [4, 2, 3.0_f32.to_bits()]); // as in a trace or a message
/// assert_eq!(Command::from_words(command.words()), Ok(command));
/// let settings = command.settings(Settings::for_model(&model));
/// assert_eq!(settings.max_force_n, 3.0);
/// # Ok::<(), chaincell_kernel::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// Returns to rest, with the tool released and the settings in force.
    Reset,
    /// Samples are answered without a tick from now on: no cell moves.
    Pause,
    /// Ticks continue.
    Resume,
    /// Changes [`Settings::sweeps`].
    Sweeps(u16),
    /// Changes [`Settings::max_force_n`]; infinite means no limit \[N\].
    MaxForceN(f32),
    /// Changes [`Settings::max_tool_step_m`] \[m\].
    MaxToolStepM(f32),
    /// Changes [`Settings::unloading`].
    Unloading(Unloading),
    /// Changes [`Settings::cut`].
    Cut(Cutting),
    /// A tool grips what it is in contact with, see [`TissueMut::grip`](crate::TissueMut::grip).
    Grip {
        /// Number of the tool.
        tool: u32,
    },
    /// A tool lets go of what it grips, see [`TissueMut::let_go`](crate::TissueMut::let_go).
    LetGo {
        /// Number of the tool.
        tool: u32,
        /// Ticks in which the pull falls to 0, at least 1.
        ticks: u16,
    },
    /// Pins the tissue that a tool grips or touches, see [`TissueMut::pin_held`](crate::TissueMut::pin_held).
    Pin {
        /// Number of the tool.
        tool: u32,
        /// Stiffness of the pin; infinite is rigid [N/m].
        stiffness_n_per_m: f32,
    },
    /// Releases a pin, see [`TissueMut::unpin`](crate::TissueMut::unpin).
    Unpin {
        /// Number of the pin.
        pin: u16,
        /// Ticks in which its force falls to 0, at least 1.
        ticks: u16,
    },
    /// Pins the surface around a point, see [`TissueMut::pin_at`](crate::TissueMut::pin_at). Its five
    /// numbers are more than [`Self::words`] returns.
    PinAt {
        /// The point in the frame of the input mesh \[m\].
        point_m: [f32; 3],
        /// Radius around it \[m\].
        radius_m: f32,
        /// Stiffness of the pin; infinite is rigid [N/m].
        stiffness_n_per_m: f32,
    },
    /// A snapshot was taken here. Before all ticks of a trace: the trace begins from this snapshot.
    Snapshot {
        /// CRC-32 of the snapshot's file; 0 in a request for a snapshot.
        checksum: u32,
    },
}

/// The reason for which numbers are no command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandError {
    /// No command has this number.
    Kind,
    /// No parameter has this number, or the command takes none.
    Parameter,
    /// The parameter is fixed for a run.
    Fixed,
    /// The parameter does not take this value.
    Value,
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Kind => {
                "unknown command: reset, pause, resume, set, grip, let-go, snapshot, pin and unpin are known"
            }
            Self::Parameter => {
                "unknown parameter: sweeps, max_force_n, max_tool_step_m, unloading and cut may be set"
            }
            Self::Fixed => "this parameter is fixed for a run: start another one",
            Self::Value => "the value is out of the parameter's range",
        })
    }
}

impl core::error::Error for CommandError {}

/// Numbers of the parameters; 5 (step) and 6 (time a tick) are fixed for a run.
const SWEEPS: u32 = 1;
const MAX_FORCE: u32 = 2;
const MAX_TOOL_STEP: u32 = 3;
const UNLOADING: u32 = 4;
const CUT: u32 = 7;

/// Number of the command that pins around a point.
const PIN_AT: u32 = 10;

impl Command {
    /// Returns the number of the command (1 reset, 2 pause, 3 resume, 4 set, 5 grip, 6 let go, 7 snapshot, 8 pin,
    /// 9 unpin, 10 pin at a point), the parameter (0 none; for set 1 sweeps, 2 largest force, 3 largest tool step, 4
    /// unloading, 7 cut; for grip, let go and pin the tool, for unpin the pin, for a snapshot its checksum) and the
    /// bits of the value (for let go and unpin the ticks, for pin the stiffness). Those of a pin at a point are not
    /// all.
    #[must_use]
    pub fn words(&self) -> [u32; 3] {
        let (parameter, value) = match *self {
            Self::Reset => return [1, 0, 0],
            Self::Pause => return [2, 0, 0],
            Self::Resume => return [3, 0, 0],
            Self::Grip { tool } => return [5, tool, 0],
            Self::LetGo { tool, ticks } => return [6, tool, f32::from(ticks).to_bits()],
            Self::Snapshot { checksum } => return [7, checksum, 0],
            Self::Pin { tool, stiffness_n_per_m } => return [8, tool, stiffness_n_per_m.to_bits()],
            Self::Unpin { pin, ticks } => return [9, pin.into(), f32::from(ticks).to_bits()],
            Self::PinAt { point_m: [x, y, _], .. } => return [PIN_AT, x.to_bits(), y.to_bits()],
            Self::Sweeps(sweeps) => (SWEEPS, f32::from(sweeps)),
            Self::MaxForceN(force_n) => (MAX_FORCE, force_n),
            Self::MaxToolStepM(step_m) => (MAX_TOOL_STEP, step_m),
            Self::Unloading(unloading) => (UNLOADING, f32::from(unloading.code())),
            Self::Cut(cut) => (CUT, f32::from(cut.code())),
        };
        [4, parameter, value.to_bits()]
    }

    /// Returns the command of these numbers. [`Network::new`](crate::Network::new) checks later that
    /// the value fits the model.
    ///
    /// # Errors
    /// The number that has no meaning.
    pub fn from_words([kind, parameter, value]: [u32; 3]) -> Result<Self, CommandError> {
        let plain = |command| match (parameter, value) {
            (0, 0) => Ok(command),
            (0, _) => Err(CommandError::Value),
            _ => Err(CommandError::Parameter),
        };
        match kind {
            1 => plain(Self::Reset),
            2 => plain(Self::Pause),
            3 => plain(Self::Resume),
            4 => Self::set(parameter, f32::from_bits(value)),
            5 if value == 0 => Ok(Self::Grip { tool: parameter }),
            5 => Err(CommandError::Value),
            6 => match whole(f32::from_bits(value)) {
                Some(ticks @ 1..) => Ok(Self::LetGo { tool: parameter, ticks }),
                _ => Err(CommandError::Value),
            },
            7 if value == 0 => Ok(Self::Snapshot { checksum: parameter }),
            7 => Err(CommandError::Value),
            8 if f32::from_bits(value) > 0.0 => {
                Ok(Self::Pin { tool: parameter, stiffness_n_per_m: f32::from_bits(value) })
            }
            8 => Err(CommandError::Value),
            9 => match (u16::try_from(parameter), whole(f32::from_bits(value))) {
                (Err(_), _) => Err(CommandError::Parameter),
                (Ok(pin), Some(ticks @ 1..)) => Ok(Self::Unpin { pin, ticks }),
                _ => Err(CommandError::Value),
            },
            _ => Err(CommandError::Kind),
        }
    }

    fn set(parameter: u32, value: f32) -> Result<Self, CommandError> {
        match parameter {
            SWEEPS => whole(value).map(Self::Sweeps).ok_or(CommandError::Value),
            MAX_FORCE => Ok(Self::MaxForceN(value)),
            MAX_TOOL_STEP => Ok(Self::MaxToolStepM(value)),
            UNLOADING => {
                let unloading = whole(value).and_then(Unloading::from_code);
                unloading.map(Self::Unloading).ok_or(CommandError::Value)
            }
            CUT => {
                let cut = whole(value).and_then(Cutting::from_code);
                cut.map(Self::Cut).ok_or(CommandError::Value)
            }
            5 | 6 => Err(CommandError::Fixed),
            _ => Err(CommandError::Parameter),
        }
    }

    /// Returns the kind of the command's record.
    pub(super) fn record_kind(&self) -> u16 {
        match self {
            Self::Grip { .. }
            | Self::LetGo { .. }
            | Self::Pin { .. }
            | Self::Unpin { .. }
            | Self::PinAt { .. } => KIND_TOOL_COMMAND,
            _ => KIND_COMMAND,
        }
    }

    /// Returns the words of its record after [`Self::words`]: 0 but for a pin at a point.
    pub(super) fn further_words(&self) -> [u32; 3] {
        match *self {
            Self::PinAt { point_m: [.., z], radius_m, stiffness_n_per_m } => {
                [z, radius_m, stiffness_n_per_m].map(f32::to_bits)
            }
            _ => [0; 3],
        }
    }

    /// Returns the command of these words of a record; `None` if they are none.
    pub(super) fn of_record(words: [u32; 3], further: [u32; 3]) -> Option<Self> {
        if let [PIN_AT, x, y] = words {
            let [z, radius_m, stiffness_n_per_m] = further.map(f32::from_bits);
            let point_m = [f32::from_bits(x), f32::from_bits(y), z];
            return Some(Self::PinAt { point_m, radius_m, stiffness_n_per_m });
        }
        Self::from_words(words).ok().filter(|_| further == [0; 3])
    }

    /// Returns the settings after the command.
    #[must_use]
    pub fn settings(&self, before: Settings) -> Settings {
        match *self {
            Self::Reset
            | Self::Pause
            | Self::Resume
            | Self::Grip { .. }
            | Self::LetGo { .. }
            | Self::Pin { .. }
            | Self::Unpin { .. }
            | Self::PinAt { .. }
            | Self::Snapshot { .. } => before,
            Self::Sweeps(sweeps) => Settings { sweeps, ..before },
            Self::MaxForceN(max_force_n) => Settings { max_force_n, ..before },
            Self::MaxToolStepM(max_tool_step_m) => Settings { max_tool_step_m, ..before },
            Self::Unloading(unloading) => Settings { unloading, ..before },
            Self::Cut(cut) => Settings { cut, ..before },
        }
    }
}

/// Returns the value as a whole number of 16 bits, if it is one.
fn whole(value: f32) -> Option<u16> {
    Some(value as u16).filter(|whole| f32::from(*whole) == value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_mean_commands_and_back() {
        for command in [
            Command::Reset,
            Command::Pause,
            Command::Resume,
            Command::Sweeps(0),
            Command::Sweeps(65_535),
            Command::MaxForceN(f32::INFINITY),
            Command::MaxToolStepM(0.002),
            Command::Unloading(Unloading::Off),
            Command::Unloading(Unloading::Release),
            Command::Unloading(Unloading::Retreat),
            Command::Cut(Cutting::On),
            Command::Cut(Cutting::Off),
            Command::Grip { tool: 0 },
            Command::Grip { tool: 7 },
            Command::LetGo { tool: 3, ticks: 1 },
            Command::LetGo { tool: 0, ticks: 65_535 },
            Command::Pin { tool: 1, stiffness_n_per_m: f32::INFINITY },
            Command::Pin { tool: 0, stiffness_n_per_m: 20.0 },
            Command::Unpin { pin: 65_535, ticks: 20 },
            Command::Snapshot { checksum: 0 },
            Command::Snapshot { checksum: 0x7fa0_0001 },
        ] {
            assert_eq!(Command::from_words(command.words()), Ok(command));
        }
    }

    #[test]
    fn other_numbers_are_refused_by_what_is_wrong_with_them() {
        let bits = f32::to_bits;
        for (words, why) in [
            ([0, 0, 0], CommandError::Kind),
            ([11, 0, 0], CommandError::Kind),
            ([10, 0, 0], CommandError::Kind),
            ([8, 0, 0], CommandError::Value),
            ([8, 0, bits(f32::NAN)], CommandError::Value),
            ([9, 65_536, bits(1.0)], CommandError::Parameter),
            ([9, 0, 0], CommandError::Value),
            ([7, 1, 1], CommandError::Value),
            ([5, 0, 1], CommandError::Value),
            ([6, 0, 0], CommandError::Value),
            ([6, 0, bits(0.5)], CommandError::Value),
            ([6, 0, bits(65_536.0)], CommandError::Value),
            ([1, 1, 0], CommandError::Parameter),
            ([2, 0, 1], CommandError::Value),
            ([4, 0, 0], CommandError::Parameter),
            ([4, 8, 0], CommandError::Parameter),
            ([4, 5, bits(0.1)], CommandError::Fixed),
            ([4, 1, bits(2.5)], CommandError::Value),
            ([4, 1, bits(-1.0)], CommandError::Value),
            ([4, 1, bits(65_536.0)], CommandError::Value),
            ([4, 1, bits(f32::NAN)], CommandError::Value),
            ([4, 4, bits(3.0)], CommandError::Value),
            ([4, 7, bits(2.0)], CommandError::Value),
        ] {
            assert_eq!(Command::from_words(words), Err(why), "{words:?}");
        }
    }
}
