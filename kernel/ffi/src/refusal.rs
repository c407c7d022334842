//! The kernel's errors as result codes.

use chaincell_kernel::float_env::FloatEnvironmentError;
use chaincell_kernel::image::{FORMAT_VERSION, kind};
use chaincell_kernel::snapshot::{SNAPSHOT_VERSION, SnapshotError};
use chaincell_kernel::stage::StageError;
use chaincell_kernel::{ContactError, PinError};
use chaincell_kernel::{ModelError, ResetError, SettingsError, StateError};

use crate::code::{Code, Refusal};

impl From<StageError> for Code {
    fn from(why: StageError) -> Self {
        match why {
            StageError::Tick => Self::StageTick,
            StageError::Coupling => Self::StageCoupling,
            StageError::Passivity => Self::StagePassivity,
            StageError::Slew => Self::StageSlew,
            StageError::MaxForce => Self::StageMaxForce,
            StageError::MaxSpeed => Self::StageMaxSpeed,
            StageError::Ticks => Self::StageTicks,
        }
    }
}

impl From<ModelError> for Refusal {
    fn from(why: ModelError) -> Self {
        match why {
            ModelError::Misaligned => Code::ModelMisaligned.into(),
            ModelError::Truncated => Code::ModelTruncated.into(),
            ModelError::Magic => Code::ModelMagic.into(),
            ModelError::Version(found) => {
                Refusal::sizes(Code::ModelVersion, FORMAT_VERSION as usize, found as usize)
            }
            ModelError::Checksum => Code::ModelChecksum.into(),
            ModelError::Layout => Code::ModelLayout.into(),
            ModelError::Missing(kind) => Refusal::section(Code::ModelMissing, kind, 0),
            ModelError::SectionVersion(kind) => {
                Refusal::section(Code::ModelSectionVersion, kind, 0)
            }
            ModelError::Unbuilt(kind) => Refusal::section(Code::ModelSectionVersion, kind, 0),
            ModelError::SectionSize(kind) => Refusal::section(Code::ModelSectionSize, kind, 0),
            ModelError::Parameter(word) => {
                Refusal::section(Code::ModelParameter, kind::PARAMS, word)
            }
            ModelError::Index(kind, at) => Refusal::section(Code::ModelIndex, kind, at),
            ModelError::Value(kind, at) => Refusal::section(Code::ModelValue, kind, at),
            ModelError::Float(why) => why.into(),
        }
    }
}

impl From<SettingsError> for Refusal {
    fn from(why: SettingsError) -> Self {
        match why {
            SettingsError::Sweeps => Code::SettingsSweeps.into(),
            SettingsError::Step { max } => Refusal::limit(Code::SettingsStep, max),
            SettingsError::TickTime { min } => Refusal::limit(Code::SettingsTickTime, min),
            SettingsError::MaxToolStep => Code::SettingsMaxToolStep.into(),
            SettingsError::Unloading => Code::SettingsUnloading.into(),
            SettingsError::MaxForce => Code::SettingsMaxForce.into(),
        }
    }
}

impl From<ResetError> for Refusal {
    fn from(why: ResetError) -> Self {
        match why {
            ResetError::Capacity { needed, capacity } => {
                Refusal::sizes(Code::ResetCapacity, needed, capacity)
            }
            ResetError::CoarseRoom { needed, room } => {
                Refusal::sizes(Code::ResetCoarse, needed, room)
            }
            // The storage has room for the states and the memory of every model that it admits.
            ResetError::States { needed, capacity }
            | ResetError::Memory { needed, room: capacity } => {
                Refusal::sizes(Code::ResetCapacity, needed, capacity)
            }
            ResetError::Shapes => Code::ResetShapes.into(),
            ResetError::Range(why) => Refusal::limit(Code::ResetRange, why.limit()),
            ResetError::Float(why) => why.into(),
        }
    }
}

impl From<FloatEnvironmentError> for Refusal {
    fn from(why: FloatEnvironmentError) -> Self {
        match why {
            FloatEnvironmentError::FlushToZero => Code::FloatFlushToZero.into(),
            FloatEnvironmentError::Rounding => Code::FloatRounding.into(),
            FloatEnvironmentError::Trap => Code::FloatTrap.into(),
        }
    }
}

impl From<ContactError> for Refusal {
    fn from(why: ContactError) -> Self {
        match why {
            ContactError::Capacity { needed, capacity } => {
                Refusal::sizes(Code::ContactCapacity, needed, capacity)
            }
            ContactError::Unknown(at) => Refusal::position(Code::ContactUnknown, at),
            ContactError::Fixed(at) => Refusal::position(Code::ContactFixed, at),
            ContactError::Order(at) => Refusal::position(Code::ContactRepeated, at),
            ContactError::Model => Code::ContactModel.into(),
            ContactError::CoarseRoom { needed, room } | ContactError::ToolRoom { needed, room } => {
                Refusal::sizes(Code::ContactCoarse, needed, room)
            }
            ContactError::Engaged => Code::ContactEngaged.into(),
            ContactError::SurfaceUnbuilt | ContactError::SurfaceScheme => {
                Code::ContactScheme.into()
            }
            ContactError::NoContactSurface => Code::ContactNoSurface.into(),
            ContactError::Tools { needed, capacity } => {
                Refusal::sizes(Code::ContactTools, needed, capacity)
            }
            ContactError::Parts { tool, most } => {
                Refusal::position(Code::ContactParts, tool).with_sizes(0, most)
            }
            ContactError::Part { part, .. } | ContactError::Edge { part, .. } => {
                Refusal::position(Code::ContactPart, part)
            }
            ContactError::CannotCut => Code::CutRoom.into(),
            ContactError::Friction { max } => Refusal::limit(Code::ContactFriction, max),
            ContactError::AnchorRoom => Code::ContactSamples.into(),
            ContactError::SurfaceRoom { needed, capacity } => {
                Refusal::sizes(Code::ContactRoom, needed, capacity)
            }
            ContactError::RadiusMin { min_m } => Refusal::limit(Code::ContactRadiusMin, min_m),
        }
    }
}

impl From<PinError> for Refusal {
    fn from(why: PinError) -> Self {
        match why {
            PinError::Model => Code::ContactModel.into(),
            PinError::Unbuilt => Refusal::sizes(Code::PinRoom, 1, 0),
            PinError::NoTools => Code::PinTools.into(),
            PinError::Value => Code::PinValue.into(),
            PinError::Reach { nearest_m } => Refusal::limit(Code::PinReach, nearest_m),
            PinError::Room { needed, capacity } => Refusal::sizes(Code::PinRoom, needed, capacity),
            PinError::NothingHeld(tool) => Refusal::position(Code::PinNothingHeld, tool),
            PinError::Unknown(_) => Code::PinUnknown.into(),
        }
    }
}

impl From<StateError> for Refusal {
    fn from(why: StateError) -> Self {
        match why {
            StateError::Model => Code::StateModel.into(),
            StateError::Count { needed, given } => Refusal::sizes(Code::StateCount, needed, given),
            StateError::Position(cell) => Refusal::position(Code::StatePosition, cell),
        }
    }
}

impl From<SnapshotError> for Refusal {
    fn from(why: SnapshotError) -> Self {
        match why {
            // A tissue of this interface has been reset.
            SnapshotError::NotReset => Code::SnapshotModel.into(),
            SnapshotError::Buffer { needed, given } => {
                Refusal::sizes(Code::SnapshotBuffer, needed, given)
            }
            SnapshotError::Magic => Code::SnapshotMagic.into(),
            SnapshotError::Version(found) => {
                Refusal::sizes(Code::SnapshotVersion, SNAPSHOT_VERSION as usize, found as usize)
            }
            SnapshotError::Layout => Code::SnapshotLayout.into(),
            SnapshotError::Model(_) => Code::SnapshotModel.into(),
            SnapshotError::Length => Code::SnapshotLength.into(),
            SnapshotError::Checksum => Code::SnapshotChecksum.into(),
            SnapshotError::Value(word) => Refusal::position(Code::SnapshotValue, word as usize),
            SnapshotError::Room { needed, room } => {
                Refusal::sizes(Code::SnapshotRoom, needed, room)
            }
            SnapshotError::Reset(why) => why.into(),
        }
    }
}
