//! The output stage: what stands between a tissue's answer and a hand.

pub use chaincell_kernel::stage::PlainStageSettings as StageSettings;
use chaincell_kernel::stage::{Device, Stage};
use chaincell_kernel::{Choice, Flags, TickOutput};

use crate::code::{Code, Refusal};
use crate::memory;
use crate::tick::{KernelPose, Output, ToolPose, answer_to};

/// Words of a `chaincell_stage`.
pub const STAGE_WORDS: usize = 160;

/// Storage of an output stage. Its content is nobody's business; it may be copied, and refers to
/// nothing.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct StageStorage {
    /// Not for use.
    pub opaque: [u32; STAGE_WORDS],
}

impl StageStorage {
    /// Storage without a stage.
    pub const EMPTY: Self = Self { opaque: [0; STAGE_WORDS] };
}

/// "CHst": a stage stands in the storage.
const STAGE_TAG: u32 = u32::from_le_bytes(*b"CHst");

/// What stands in a [`StageStorage`].
#[repr(C)]
struct Slot {
    tag: u32,
    stage: Stage,
}

const _: () = assert!(size_of::<Slot>() <= size_of::<StageStorage>());
const _: () = assert!(align_of::<Slot>() <= align_of::<StageStorage>());

/// The stage in its storage.
///
/// # Safety
/// A pointer that is not null and aligned points to a `StageStorage`, which nobody else uses for
/// `'a`.
unsafe fn stage<'a>(storage: *mut StageStorage) -> Result<&'a mut Stage, Code> {
    memory::check(storage)?;
    let slot = storage.cast::<Slot>();
    // SAFETY: a slot fits into the storage by size and alignment, and its tag is a plain word.
    if unsafe { (&raw const (*slot).tag).read() } != STAGE_TAG {
        return Err(Code::NotInitialised);
    }
    // SAFETY: the tag was written with a whole stage, which nobody but this library writes.
    Ok(unsafe { &mut (*slot).stage })
}

/// The settings for a device (one of `chaincell_device`) at 1 kHz whose force acts a tick late:
/// every stage on.
///
/// # Safety
/// `settings` is storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_stage_default(
    device: i32,
    settings: *mut StageSettings,
) -> Code {
    let device = u16::try_from(device).ok().and_then(Device::from_code);
    let Some(device) = device else { return Code::StageDevice };
    let value = chaincell_kernel::stage::StageSettings::for_device(device).plain();
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { memory::write(settings, value) })
}

/// Puts a stage at rest into storage. Unless the answer is 0 there is no stage afterwards.
///
/// # Safety
/// `stage` is storage for a stage, `settings` are settings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_stage_init(
    stage: *mut StageStorage,
    settings: *const StageSettings,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    if let Err(code) = unsafe { memory::write(stage, StageStorage::EMPTY) } {
        return code;
    }
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { memory::read(settings) }.and_then(|settings| {
        let value = settings.settings().and_then(Stage::new).map_err(Code::from)?;
        // SAFETY: a slot fits into the storage by size and alignment, and the storage was written.
        unsafe { stage.cast::<Slot>().write(Slot { tag: STAGE_TAG, stage: value }) };
        Ok(())
    }))
}

/// What a stage has to know of the time since its last sample.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct StageNews {
    /// Ticks from a sample to the device's pushing with its answer, as they were measured; negative where
    /// nobody did. What is shown follows the mean of the last 256 or so.
    pub delay_ticks: i32,
    /// Other than 0 where the device did not feel what was computed: its force was let fall, or it was given
    /// none, as in a pause or before a restored session. The ramp begins anew.
    pub restarts_ramp: u32,
    /// No force is above this from here on, besides the stage's own largest: for the `max_force_n` of the
    /// tissue's settings, which shortens the tissue's force alone while a coupling shows its own. Up to a
    /// higher one the force may grow by the device's largest within `ramp_ticks` \[N\]. 0 leaves it.
    pub max_force_n: f32,
}

impl StageNews {
    /// Tells the stage.
    fn tell(&self, stage: &mut Stage) -> Result<(), Code> {
        if self.max_force_n.is_nan() || self.max_force_n < 0.0 {
            return Err(Code::StageMaxForce);
        }
        if self.max_force_n > 0.0 {
            stage.limit_force(self.max_force_n);
        }
        if self.restarts_ramp != 0 {
            stage.restart_ramp();
        }
        if let Ok(ticks) = u32::try_from(self.delay_ticks) {
            stage.delayed(u16::try_from(ticks).unwrap_or(u16::MAX));
        }
        Ok(())
    }
}

/// What the tissue is to be given for what the device has measured: the tool behind the coupling.
/// `device` and `tool` may be one pose; the orientation goes through as it is. `news` is null where there
/// are none. A refused call changes nothing.
///
/// # Safety
/// `stage` was made by `chaincell_stage_init` and no other thread uses it; `device` is a pose, `news` is
/// null or news, `tool` is storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_stage_sample(
    stage: *mut StageStorage,
    device: *const ToolPose,
    news: *const StageNews,
    tool: *mut ToolPose,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { self::stage(stage) }.and_then(|stage| {
        // SAFETY: the caller's promises are handed on.
        let ToolPose { position_m, orientation, engaged, opening_turns_q16 } =
            unsafe { memory::read(device) }?;
        memory::check(tool)?;
        if !news.is_null() {
            // SAFETY: the caller's promises are handed on.
            unsafe { memory::read(news) }?.tell(stage)?;
        }
        let position_m = position_m.into();
        let device = KernelPose { position_m, orientation, engaged, opening_turns_q16 };
        // The stage leaves the opening as it is.
        let KernelPose { position_m, orientation, engaged, .. } = stage.sample(&device);
        let position_m = position_m.into();
        let value = ToolPose { position_m, orientation, engaged, opening_turns_q16 };
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(tool, value) }
    }))
}

/// The kernel's answer of an output.
pub(crate) fn answer_of(output: &Output) -> TickOutput {
    TickOutput {
        force_n: output.tool.force_n.into(),
        energy_j: output.energy_j,
        work_j: output.work_j,
        stiffness_n_per_m: output.stiffness_n_per_m,
        contacts: output.tool.contacts,
        sweeps: u16::try_from(output.sweeps).unwrap_or(u16::MAX),
        flags: Flags(output.tool.flags),
    }
}

/// A torque on the stage's ramp; none where the force is none, and of what is no number.
fn torque(stage: &Stage, tissue: &Output, flags: u32) -> [f32; 3] {
    let torque_n_m = tissue.tool.torque_n_m.map(|x| x * stage.share());
    let is_felt = flags & Flags::SAFE_STATE.0 == 0 && torque_n_m.iter().all(|x| x.is_finite());
    if is_felt { torque_n_m } else { [0.0; 3] }
}

/// What the device is given for what the tissue has answered to the tool of
/// `chaincell_stage_sample`; a torque goes along the force's ramp. `tissue` and `output` may be one output.
/// A null `tissue` is a tick without a sample, in which the tissue has no tick either.
///
/// A tissue under a current tells neither work nor stiffness: a stage with coupling or passivity
/// control then gives force 0 with `CHAINCELL_FLAG_SAFE_STATE`.
///
/// Where a pointer is bad the stage stays as it is, and an `output` that can be written says the
/// same.
///
/// # Safety
/// `stage` was made by `chaincell_stage_init` and no other thread uses it; `tissue` is null or an output,
/// `output` is storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_stage_output(
    stage: *mut StageStorage,
    tissue: *const Output,
    output: *mut Output,
) -> Code {
    let tissue = match tissue.is_null() {
        true => Ok(None),
        // SAFETY: the caller's promises are handed on.
        false => unsafe { memory::read(tissue) }.map(Some),
    };
    let work = |outputs: &mut [Output]| {
        // SAFETY: the caller's promises are handed on.
        let (stage, tissue) = (unsafe { self::stage(stage) }?, tissue?);
        for output in outputs {
            *output = match &tissue {
                Some(tissue) => Output::of(&stage.output(&answer_of(tissue))),
                None => Output::of(&stage.missed()),
            };
            if let Some(tissue) = &tissue {
                output.tool.torque_n_m = torque(stage, tissue, output.tool.flags);
                (output.relaxed_j, output.force_error_n) = (tissue.relaxed_j, tissue.force_error_n);
                output.torque_error_n_m = tissue.torque_error_n_m;
            }
        }
        Ok(())
    };
    // SAFETY: the caller's promises are handed on.
    unsafe { answer_to(output, 1, work) }
}

/// Saves all that the stage knows but its settings into `bytes` bytes at `snapshot`; `written` says how
/// many it took and may be null. A null `snapshot` of 0 bytes asks how many it would take.
///
/// # Safety
/// `stage` was made by `chaincell_stage_init` and no other thread uses it; `snapshot` is storage of `bytes`
/// bytes, `written` is null or storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_stage_save(
    stage: *mut StageStorage,
    snapshot: *mut u8,
    bytes: usize,
    written: *mut usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { self::stage(stage) }.and_then(|stage| {
        let asks = snapshot.is_null() && bytes == 0;
        // SAFETY: the caller's promises are handed on.
        let snapshot = unsafe { memory::slice_mut(snapshot, bytes) }?;
        if !asks {
            stage.save(snapshot).map_err(|why| Refusal::from(why).code)?;
        }
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write_if_asked(written, stage.snapshot_bytes()) }
    }))
}

/// Goes on from a stage's snapshot: with the same settings, samples and answers to the same forces. A
/// snapshot that is refused changes nothing.
///
/// # Safety
/// `stage` was made by `chaincell_stage_init` and no other thread uses it; `snapshot` points to `bytes`
/// bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_stage_restore(
    stage: *mut StageStorage,
    snapshot: *const u8,
    bytes: usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { self::stage(stage) }.and_then(|stage| {
        // SAFETY: the caller's promises are handed on.
        let snapshot = unsafe { memory::slice(snapshot, bytes) }?;
        stage.restore(snapshot).map_err(|why| Refusal::from(why).code)
    }))
}
