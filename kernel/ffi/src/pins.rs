//! Pins: regions of the surface that are held to the world.

use crate::code::{Code, Detail, Refusal};
use crate::layout::{self, Parts, Tissue, by_touching_scheme};
use crate::memory;

/// What a pin bears.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct PinOutput {
    /// Force of the tissue on the pin; no limit clamps it \[N\].
    pub force_n: [f32; 3],
    /// The mean of the places at which its samples are pinned, in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// How far the tissue has moved from there, the mean of its samples \[m\].
    pub given_m: [f32; 3],
    /// Its present stiffness, which falls to 0 while it is released \[N/m\].
    pub stiffness_n_per_m: f32,
    /// Energy of its springs \[J\].
    pub energy_j: f32,
    /// Samples of the surface that it holds.
    pub samples: u32,
}

/// Pins the surface within `radius_m` of a point, 3 numbers, where it is now: its samples there are held in the world
/// by springs of this stiffness in all \[N/m\]; `INFINITY` makes a rigid pin, 200 times as stiff as tissue of one edge
/// length in depth, on a body of links 10 times. `pin` is its number, the lowest free one.
///
/// Pinning makes no force. Between two ticks. A pin holds until `chaincell_unpin`, and until a reset or a choice of
/// cells. Tools must have been chosen, on a tissue with room for `pins`; none needs to be engaged. `detail` may be
/// null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `point_m` are three numbers, `pin` is
/// storage for the answer, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_pin_at(
    tissue: *mut Tissue,
    point_m: *const f32,
    radius_m: f32,
    stiffness_n_per_m: f32,
    pin: *mut u32,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            check_room(sizes.touch.pins())?;
            memory::check(pin)?;
            let point_m: [f32; 3] = memory::read(point_m.cast())?;
            let set = by_touching_scheme!(scheme, D => {
                let Parts { network, tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                body.pin_at(network, point_m, radius_m, stiffness_n_per_m)
            });
            Ok(memory::write(pin, u32::from(set?))?)
        })
    }
}

/// Pins what a tool, from 0, grips, or what it touches if it grips nothing; else as `chaincell_pin_at`. The tool keeps
/// its grip: `chaincell_let_go` frees it, and its pull passes to the pin along that ramp.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `pin` is storage for the answer, `detail`
/// is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_pin_held(
    tissue: *mut Tissue,
    tool: u32,
    stiffness_n_per_m: f32,
    pin: *mut u32,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            check_room(sizes.touch.pins())?;
            memory::check(pin)?;
            let set = by_touching_scheme!(scheme, D => {
                let Parts { network, tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                body.pin_held(network, tool as usize, stiffness_n_per_m)
            });
            Ok(memory::write(pin, u32::from(set?))?)
        })
    }
}

/// Releases a pin within so many ticks, at most 65,535: its force falls to 0 without a jump, and then it is gone. 0 is
/// as 1.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_unpin(tissue: *mut Tissue, pin: u32, ticks: u32) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(core::ptr::null_mut(), || {
            let (scheme, sizes) = layout::front(tissue)?;
            check_room(sizes.touch.pins())?;
            let ticks = u16::try_from(ticks).map_err(|_| Code::Range)?;
            let pin = u16::try_from(pin).map_err(|_| Code::PinUnknown)?;
            by_touching_scheme!(scheme, D => {
                let Parts { tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                Ok(body.unpin(pin, ticks)?)
            })
        })
    }
}

/// What a pin bears in the published state; `CHAINCELL_CODE_PIN_UNKNOWN` where no pin has this number.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `output` is storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_pin_force(
    tissue: *mut Tissue,
    pin: u32,
    output: *mut PinOutput,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(core::ptr::null_mut(), || {
            let (scheme, sizes) = layout::front(tissue)?;
            check_room(sizes.touch.pins())?;
            memory::check(output)?;
            let pin = u16::try_from(pin).map_err(|_| Code::PinUnknown)?;
            let found = by_touching_scheme!(scheme, D => {
                let Parts { network, tissue: body, .. } = layout::parts::<D>(tissue, sizes);
                body.pin_output(network, pin)
            });
            let found = found.ok_or(Code::PinUnknown)?;
            Ok(memory::write(output, PinOutput::of(&found))?)
        })
    }
}

/// Refuses a tissue without room for pins.
fn check_room(samples: usize) -> Result<(), Refusal> {
    if samples > 0 { Ok(()) } else { Err(Refusal::sizes(Code::PinRoom, 1, 0)) }
}

impl PinOutput {
    fn of(kernel: &chaincell_kernel::PinOutput) -> Self {
        Self {
            force_n: kernel.force_n.into(),
            position_m: kernel.position_m,
            given_m: kernel.given_m,
            stiffness_n_per_m: kernel.stiffness_n_per_m,
            energy_j: kernel.energy_j,
            samples: kernel.samples,
        }
    }
}
