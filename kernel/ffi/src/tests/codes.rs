//! The numbers of the codes are a promise, and every error of the kernel has one.

use std::collections::BTreeSet;
use std::ffi::CStr;
use std::string::String;
use std::vec::Vec;

use chaincell_kernel::ContactError;
use chaincell_kernel::float_env::FloatEnvironmentError;
use chaincell_kernel::{ModelError, PinError, RangeError, ResetError, SettingsError, StateError};

use super::call;
use crate::code::Refusal;
use crate::{
    Budget, Code, ContactForce, Detail, Output, Room, Settings, ToolOutput, ToolPart, ToolPose,
    VERSION, chaincell_code_text, chaincell_version,
};

fn text(code: i32) -> String {
    let text = chaincell_code_text(code);
    assert!(!text.is_null());
    // SAFETY: the function promises a string that is always there.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().into()
}

// REQ-CIF-06
#[test]
fn numbers_do_not_change() {
    let numbers: Vec<i32> = Code::ALL.iter().map(|&(code, ..)| code as i32).collect();
    let promised = (0..=8).chain(20..=31).chain(40..=47).chain(60..=61);
    let promised: Vec<i32> = promised
        .chain(63..=67)
        .chain(80..=86)
        .chain(90..=98)
        .chain(100..=102)
        .chain(120..=127)
        .chain(140..=148)
        .chain(160..=162)
        .chain(180..=185)
        .map(|number: i32| -number)
        .collect();
    assert_eq!(numbers, promised);
    let named = [
        (Code::Null, -1),
        (Code::UnknownId, -7),
        (Code::NoStress, -8),
        (Code::ModelMisaligned, -20),
        (Code::ModelValue, -31),
        (Code::SettingsSweeps, -40),
        (Code::SettingsUnloading, -45),
        (Code::SettingsDrive, -46),
        (Code::SettingsCut, -47),
        (Code::ResetCapacity, -60),
        (Code::FloatRounding, -64),
        (Code::FloatTrap, -67),
        (Code::ContactCapacity, -80),
        (Code::ContactEngaged, -86),
        (Code::ContactScheme, -90),
        (Code::ContactNoSurface, -91),
        (Code::ContactRadiusMin, -98),
        (Code::StatePosition, -102),
        (Code::StageTick, -120),
        (Code::StageDevice, -126),
        (Code::StageMaxSpeed, -127),
        (Code::SnapshotBuffer, -140),
        (Code::SnapshotRoom, -148),
        (Code::CutModel, -160),
        (Code::CutFace, -162),
        (Code::PinTools, -180),
        (Code::PinValue, -181),
        (Code::PinReach, -182),
        (Code::PinRoom, -183),
        (Code::PinNothingHeld, -184),
        (Code::PinUnknown, -185),
    ];
    assert!(named.iter().all(|&(code, number)| code as i32 == number));
}

#[test]
fn every_code_has_words_of_its_own() {
    let texts: BTreeSet<String> = Code::ALL.iter().map(|&(code, ..)| text(code as i32)).collect();
    assert!(!texts.contains("unknown code"));
    // Two codes say that a tissue is of another model.
    assert_eq!(texts.len(), Code::ALL.len() - 1);
    assert_eq!(text(0), "ok");
    for unknown in [1, -9, -103, -128, i32::MIN, i32::MAX] {
        assert_eq!(text(unknown), "unknown code");
    }
}

/// A program built against another layout learns it from the version before it reads a byte.
#[test]
fn the_version_names_the_layout() {
    let sizes = [size_of::<Budget>(), size_of::<Output>(), size_of::<Settings>()];
    assert_eq!((chaincell_version(), sizes), (0x0b00, [4 * size_of::<usize>(), 60, 32]));
    let of_tools = [size_of::<ToolPart>(), size_of::<ToolPose>(), size_of::<ToolOutput>()];
    assert_eq!((of_tools, size_of::<ContactForce>(), size_of::<Room>()), ([44, 32, 32], 60, 24));
    assert_eq!(chaincell_version(), VERSION);
}

fn at(section: u32, position: u32) -> Detail {
    Detail { section, position, ..Detail::default() }
}

fn sizes(needed: usize, available: usize) -> Detail {
    Detail { needed, available, ..Detail::default() }
}

#[track_caller]
fn becomes(why: impl Into<Refusal>, code: Code, detail: Detail) {
    assert_eq!(why.into(), Refusal { code, detail });
}

// REQ-CIF-06
#[test]
fn every_error_of_the_kernel_keeps_what_it_names() {
    let none = Detail::default();
    becomes(ModelError::Misaligned, Code::ModelMisaligned, none);
    becomes(ModelError::Truncated, Code::ModelTruncated, none);
    becomes(ModelError::Magic, Code::ModelMagic, none);
    becomes(ModelError::Version(7), Code::ModelVersion, sizes(1, 7));
    becomes(ModelError::Checksum, Code::ModelChecksum, none);
    becomes(ModelError::Layout, Code::ModelLayout, none);
    becomes(ModelError::Missing(4), Code::ModelMissing, at(4, 0));
    becomes(ModelError::SectionVersion(5), Code::ModelSectionVersion, at(5, 0));
    becomes(ModelError::SectionSize(6), Code::ModelSectionSize, at(6, 0));
    becomes(ModelError::Parameter(9), Code::ModelParameter, at(1, 9));
    becomes(ModelError::Index(4, 17), Code::ModelIndex, at(4, 17));
    becomes(ModelError::Value(2, 18), Code::ModelValue, at(2, 18));
    becomes(SettingsError::Sweeps, Code::SettingsSweeps, none);
    let limit = Detail { limit: 0.25, ..none };
    becomes(SettingsError::Step { max: 0.25 }, Code::SettingsStep, limit);
    becomes(SettingsError::TickTime { min: 0.25 }, Code::SettingsTickTime, limit);
    becomes(SettingsError::MaxToolStep, Code::SettingsMaxToolStep, none);
    becomes(SettingsError::Unloading, Code::SettingsUnloading, none);
    becomes(SettingsError::MaxForce, Code::SettingsMaxForce, none);
    let capacity = ResetError::Capacity { needed: 81, capacity: 80 };
    becomes(capacity, Code::ResetCapacity, sizes(81, 80));
    becomes(ResetError::CoarseRoom { needed: 3, room: 2 }, Code::ResetCoarse, sizes(3, 2));
    becomes(ResetError::Shapes, Code::ResetShapes, none);
    let flush = FloatEnvironmentError::FlushToZero;
    becomes(ResetError::Float(flush), Code::FloatFlushToZero, none);
    becomes(ResetError::Float(FloatEnvironmentError::Rounding), Code::FloatRounding, none);
    becomes(ModelError::Float(FloatEnvironmentError::Trap), Code::FloatTrap, none);
    let range = RangeError::Saturation { k: 64.0, max: 63.0 };
    becomes(ResetError::Range(range), Code::ResetRange, Detail { limit: 63.0, ..none });
    let capacity = ContactError::Capacity { needed: 5, capacity: 4 };
    becomes(capacity, Code::ContactCapacity, sizes(5, 4));
    becomes(ContactError::Unknown(3), Code::ContactUnknown, at(0, 3));
    becomes(ContactError::Fixed(2), Code::ContactFixed, at(0, 2));
    becomes(ContactError::Order(1), Code::ContactRepeated, at(0, 1));
    becomes(ContactError::Model, Code::ContactModel, none);
    becomes(ContactError::CoarseRoom { needed: 9, room: 8 }, Code::ContactCoarse, sizes(9, 8));
    becomes(ContactError::Engaged, Code::ContactEngaged, none);
    becomes(ContactError::ToolRoom { needed: 7, room: 6 }, Code::ContactCoarse, sizes(7, 6));
    becomes(ContactError::SurfaceUnbuilt, Code::ContactScheme, none);
    becomes(ContactError::SurfaceScheme, Code::ContactScheme, none);
    becomes(ContactError::NoContactSurface, Code::ContactNoSurface, none);
    let tools = ContactError::Tools { needed: 3, capacity: 2 };
    becomes(tools, Code::ContactTools, sizes(3, 2));
    let parts = Detail { position: 1, available: 8, ..none };
    becomes(ContactError::Parts { tool: 1, most: 8 }, Code::ContactParts, parts);
    becomes(ContactError::Part { tool: 0, part: 2 }, Code::ContactPart, at(0, 2));
    let most = Detail { limit: 10.0, ..none };
    becomes(ContactError::Friction { max: 10.0 }, Code::ContactFriction, most);
    becomes(ContactError::AnchorRoom, Code::ContactSamples, none);
    let room = ContactError::SurfaceRoom { needed: 144, capacity: 0 };
    becomes(room, Code::ContactRoom, sizes(144, 0));
    let least = Detail { limit: 0.5, ..none };
    becomes(ContactError::RadiusMin { min_m: 0.5 }, Code::ContactRadiusMin, least);
    becomes(ContactError::CannotCut, Code::CutRoom, none);
    becomes(PinError::Model, Code::ContactModel, none);
    becomes(PinError::Unbuilt, Code::PinRoom, sizes(1, 0));
    becomes(PinError::NoTools, Code::PinTools, none);
    becomes(PinError::Value, Code::PinValue, none);
    becomes(PinError::Reach { nearest_m: 0.25 }, Code::PinReach, limit);
    becomes(PinError::Room { needed: 9, capacity: 8 }, Code::PinRoom, sizes(9, 8));
    becomes(PinError::NothingHeld(3), Code::PinNothingHeld, at(0, 3));
    becomes(PinError::Unknown(3), Code::PinUnknown, none);
    becomes(StateError::Model, Code::StateModel, none);
    becomes(StateError::Count { needed: 81, given: 8 }, Code::StateCount, sizes(81, 8));
    becomes(StateError::Position(80), Code::StatePosition, at(0, 80));
}

/// Arithmetic that other libraries leave behind is refused, and the body stays as it is.
#[cfg(target_arch = "x86_64")]
// REQ-BIT-06
#[test]
#[allow(deprecated)]
fn arithmetic_that_is_not_to_nearest_is_refused() {
    use std::arch::x86_64::{_mm_getcsr, _mm_setcsr};

    let made = super::make(super::BOX, crate::Scheme::Track, 1);
    super::choose(made.tissue, &[64]);
    super::tick(made.tissue, super::sample(0));
    super::tick(made.tissue, super::sample(9));
    let before = super::hash(made.tissue);
    let seen = [0x8000, 0x4000].map(|bits| {
        let mut detail = Detail { needed: 1, ..Detail::default() };
        // SAFETY: the register is restored before anything else runs on this thread.
        let kept = unsafe {
            let kept = _mm_getcsr();
            _mm_setcsr(kept | bits);
            kept
        };
        let code = call!(chaincell_tissue_reset(made.tissue, &mut detail));
        // SAFETY: as above.
        unsafe { _mm_setcsr(kept) };
        (code, detail)
    });
    let none = Detail::default();
    assert_eq!(seen, [(Code::FloatFlushToZero, none), (Code::FloatRounding, none)]);
    assert_eq!(super::hash(made.tissue), before);
}
