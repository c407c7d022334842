//! The half-links of a cell on the floating-point unit of Armv7E-M. Every operation is that of
//! [`Gathered::add`] and of `Ends::push_each`, in its order.

#![allow(unsafe_code)]

use core::arch::asm;
use core::mem::MaybeUninit;

use super::matrix::Matrix;
use super::sums::Gathered;
use crate::energy::state::Quad;
use crate::model::image::nodal;
use crate::model::nodal::SlotNumbers;
use crate::number::two_float::LANES;

// The code below reads these at fixed offsets.
const _: () = assert!(nodal::AREA == 0 && nodal::SPREAD == 3 && size_of::<SlotNumbers>() == 128);
const _: () = assert!(LANES == 8 && size_of::<[u16; LANES]>() == 16 && size_of::<Quad>() == 16);
const _: () = assert!(size_of::<Gathered<f32>>() == 52 && size_of::<Matrix<f32>>() == 36);

/// Initial sums.
static ZEROS: [f32; 13] = [0.0; 13];

/// Sums over the half-links of a lane.
///
/// # Safety
/// Every id is an index of `displacements`, `slots` has as many groups as `ids`, and `lane` is below eight.
#[inline(always)]
pub(super) unsafe fn sums(
    slots: &[SlotNumbers],
    ids: &[[u16; LANES]],
    lane: usize,
    here: &Quad,
    displacements: &[Quad],
) -> Gathered<f32> {
    let mut sums = MaybeUninit::uninit();
    // SAFETY: the caller's promise; the code writes the sums, all of them, and nothing else, and does not touch
    // the stack.
    unsafe {
        asm!(
            "vldmia {here}, {{s13-s15}}; vldmia {other}, {{s0-s12}}",
            "cmp {left}, #0; beq 3f",
            "2: ldrh {other}, [{ids}], #16",
            "add {other}, {displacements}, {other}, lsl #4; vldmia {other}, {{s16-s18}}",
            "vldr s19, [{slots}]; vldr s20, [{slots}, #32]; vldr s21, [{slots}, #64]",
            "vldr s22, [{slots}, #96]; add {slots}, {slots}, #128",
            "vsub.f32 s16, s16, s13; vsub.f32 s17, s17, s14; vsub.f32 s18, s18, s15",
            // The slope.
            "vmla.f32 s0, s16, s19; vmla.f32 s1, s16, s20; vmla.f32 s2, s16, s21",
            "vmla.f32 s3, s17, s19; vmla.f32 s4, s17, s20; vmla.f32 s5, s17, s21",
            "vmla.f32 s6, s18, s19; vmla.f32 s7, s18, s20; vmla.f32 s8, s18, s21",
            // The pull and the spread.
            "vmul.f32 s19, s22, s16; vmul.f32 s20, s22, s17; vmul.f32 s21, s22, s18",
            "vadd.f32 s9, s9, s19; vadd.f32 s10, s10, s20; vadd.f32 s11, s11, s21",
            "vmul.f32 s22, s19, s16; vmla.f32 s22, s20, s17; vmla.f32 s22, s21, s18",
            "vadd.f32 s12, s12, s22",
            "subs {left}, {left}, #1; bne 2b",
            "3: vstmia {sums}, {{s0-s12}}",
            here = in(reg) here.as_ptr(),
            sums = in(reg) sums.as_mut_ptr(),
            ids = inout(reg) ids.as_ptr().cast::<u16>().add(lane) => _,
            slots = inout(reg) slots.as_ptr().cast::<f32>().add(lane) => _,
            displacements = in(reg) displacements.as_ptr(),
            left = inout(reg) ids.len() => _,
            other = inout(reg) ZEROS.as_ptr() => _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _,
            out("s6") _, out("s7") _, out("s8") _, out("s9") _, out("s10") _, out("s11") _,
            out("s12") _, out("s13") _, out("s14") _, out("s15") _, out("s16") _, out("s17") _,
            out("s18") _, out("s19") _, out("s20") _, out("s21") _, out("s22") _,
            options(nostack),
        );
        sums.assume_init()
    }
}

/// The force of a lane on its neighbour in a group.
macro_rules! lane {
    ($x:literal, $y:literal, $z:literal) => {
        concat!(
            "ldrh {other}, [{ids}], #2; add {other}, {forces}, {other}, lsl #4\n",
            "vldmia {from}!, {{s0-s8}}\n",
            "vldr s9, [{slots}, #",
            $x,
            "]; vldr s10, [{slots}, #",
            $y,
            "]\n",
            "vldr s11, [{slots}, #",
            $z,
            "]; vldmia {other}, {{s12-s14}}\n",
            "vmul.f32 s0, s0, s9; vmul.f32 s3, s3, s9; vmul.f32 s6, s6, s9\n",
            "vmla.f32 s0, s1, s10; vmla.f32 s3, s4, s10; vmla.f32 s6, s7, s10\n",
            "vmla.f32 s0, s2, s11; vmla.f32 s3, s5, s11; vmla.f32 s6, s8, s11\n",
            "vsub.f32 s12, s12, s0; vsub.f32 s13, s13, s3; vsub.f32 s14, s14, s6\n",
            "vstmia {other}, {{s12-s14}}"
        )
    };
}

/// Takes the forces of the cells of a slice from their neighbours', in the order of groups and lanes. The fourth
/// lane of a force stays.
///
/// # Safety
/// Every id is an index of `forces`, and `slots` has as many groups as `ids`.
pub(super) unsafe fn push(
    slots: &[SlotNumbers],
    ids: &[[u16; LANES]],
    stresses: &[Matrix<f32>; LANES],
    forces: &[Quad],
) {
    if ids.is_empty() {
        return;
    }
    // SAFETY: the caller's promise; the code writes only forces, which are `Cell`s, and does not touch the
    // stack.
    unsafe {
        asm!(
            "2: mov {from}, {stresses}",
            lane!("0", "32", "64"),
            lane!("4", "36", "68"),
            lane!("8", "40", "72"),
            lane!("12", "44", "76"),
            lane!("16", "48", "80"),
            lane!("20", "52", "84"),
            lane!("24", "56", "88"),
            lane!("28", "60", "92"),
            "add {slots}, {slots}, #128; subs {left}, {left}, #1; bne 2b",
            from = out(reg) _,
            stresses = in(reg) stresses.as_ptr(),
            ids = inout(reg) ids.as_ptr() => _,
            slots = inout(reg) slots.as_ptr() => _,
            forces = in(reg) forces.as_ptr(),
            left = inout(reg) ids.len() => _,
            other = out(reg) _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _,
            out("s6") _, out("s7") _, out("s8") _, out("s9") _, out("s10") _, out("s11") _,
            out("s12") _, out("s13") _, out("s14") _,
            options(nostack),
        );
    }
}
