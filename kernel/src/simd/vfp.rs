//! The link pass for the floating-point unit of Armv7E-M, link by link with as few instructions
//! as its registers allow: loads and stores of several registers, no way through the core's.
//!
//! Every operation is that of [`link::pull`](crate::link), in its order; VMLA and VMLS round the
//! product and the sum, as two instructions would.

#![allow(unsafe_code)]

use core::arch::asm;

use crate::awake::SliceSet;
use crate::cell::{Cell, sub};
use crate::link::{Band, COINCIDENT, pull};
use crate::model::Model;
use crate::two_float::LANES;

/// What a row's links are compared with, in the order that [`run`] loads it.
#[repr(C)]
struct Limits {
    high: f32,
    high_squared: f32,
    low: f32,
    low_squared: f32,
    coincident: f32,
}

/// Adds every link's pull to both its ends, as [`accumulate`](crate::access::accumulate) does;
/// one band for all links, all of weight 1. Does nothing where an array is shorter than the model.
pub(crate) fn accumulate(
    model: &Model<'_>,
    band: Band,
    awake: &SliceSet,
    at: &[Cell],
    sum: &mut [Cell],
) {
    let cells = model.cells();
    if at.len() < cells || sum.len() < cells {
        return;
    }
    let slices = model.slice_count();
    for slice in awake.iter(slices) {
        for sum in sum.iter_mut().skip(slice * LANES).take(LANES) {
            *sum = Cell::ZERO;
        }
    }
    let limits = Limits {
        high: band.high,
        high_squared: band.high_squared,
        low: band.low,
        low_squared: band.low_squared,
        coincident: COINCIDENT,
    };
    for slice in awake.iter(slices) {
        for i in slice * LANES..cells.min((slice + 1) * LANES) {
            let row = model.row(i);
            let (mut start, end) = (row.start, row.end);
            while start < end {
                // SAFETY: i < cells, and both arrays hold as many; rows end at the number of links,
                // the length of both sections, whose upper ends are cells above i.
                let left = unsafe { run(model, &limits, i, start, end - start, at, sum) };
                start = end - left;
                if left > 0 {
                    coincident(model, band, i, start, at, sum);
                    start += 1;
                }
            }
        }
    }
}

/// A link without a direction of its own.
#[cold]
fn coincident(model: &Model<'_>, band: Band, i: usize, link: usize, at: &[Cell], sum: &mut [Cell]) {
    let (Some(&upper), Some(&l0)) = (model.upper.get(link), model.rest_length.get(link)) else {
        return;
    };
    let j = usize::from(upper);
    let (Some(here), Some(there)) = (at.get(i), at.get(j)) else { return };
    let rest = || sub(model.rest_position(j), model.rest_position(i));
    let Some(pull) = pull(here.xyz(), there.xyz(), l0, 1.0, band, rest) else { return };
    let [x, y, z] = pull.force;
    if let Some(sum) = sum.get_mut(i) {
        *sum = sum.plus(Cell([x, y, z, pull.wd2]));
    }
    if let Some(sum) = sum.get_mut(j) {
        *sum = sum.plus(Cell([-x, -y, -z, pull.wd2]));
    }
}

/// The links of a row from `start` on, until one coincides; how many are left, that one included.
///
/// # Safety
/// `i` is an index of `at` and `sum`, `start..start + links` are links of the model (at least
/// one), and their upper ends indices of both arrays other than `i`.
#[inline(always)]
unsafe fn run(
    model: &Model<'_>,
    limits: &Limits,
    i: usize,
    start: usize,
    links: usize,
    at: &[Cell],
    sum: &mut [Cell],
) -> usize {
    let left;
    // SAFETY: the caller's promise; the code reads and writes only what it names, and the stack not
    // at all.
    unsafe {
        asm!(
            "vldmia {limits}, {{s7-s11}}; vmov s24, s11",
            "vldmia {here}, {{s0-s2}}",
            "vldmia {own}, {{s3-s6}}",
            "2: ldrh {j}, [{upper}], #2",
            "vldmia {length}!, {{s11}}",
            "add {other}, {at}, {j}, lsl #4",
            "vldmia {other}, {{s12-s14}}",
            "vsub.f32 s12, s12, s0; vsub.f32 s13, s13, s1; vsub.f32 s14, s14, s2",
            "vmul.f32 s16, s12, s12; vmla.f32 s16, s13, s13; vmla.f32 s16, s14, s14",
            "vmul.f32 s17, s11, s11; vmul.f32 s18, s17, s8",
            "vcmp.f32 s16, s18; vmrs APSR_nzcv, fpscr; ble 4f",
            // Too long: d = u - high l0.
            "vsqrt.f32 s16, s16; vadd.f32 s17, s16, s16; vmls.f32 s16, s11, s7",
            "3: vmul.f32 s15, s16, s16; vdiv.f32 s17, s16, s17",
            "vmul.f32 s12, s17, s12; vmul.f32 s13, s17, s13; vmul.f32 s14, s17, s14",
            "vadd.f32 s3, s3, s12; vadd.f32 s4, s4, s13; vadd.f32 s5, s5, s14",
            "vadd.f32 s6, s6, s15",
            "add {other}, {sum}, {j}, lsl #4",
            "vldmia {other}, {{s20-s23}}",
            "vsub.f32 s20, s20, s12; vsub.f32 s21, s21, s13; vsub.f32 s22, s22, s14",
            "vadd.f32 s23, s23, s15",
            "vstmia {other}, {{s20-s23}}",
            "5: subs {left}, {left}, #1; bne 2b",
            "b 6f",
            "4: vmul.f32 s18, s17, s10",
            "vcmp.f32 s16, s18; vmrs APSR_nzcv, fpscr; bge 5b",
            "vmul.f32 s18, s17, s24",
            "vcmp.f32 s16, s18; vmrs APSR_nzcv, fpscr; bmi 6f",
            // Too short: d = u - low l0.
            "vsqrt.f32 s16, s16; vadd.f32 s17, s16, s16; vmls.f32 s16, s11, s9; b 3b",
            "6: vstmia {own}, {{s3-s6}}",
            limits = in(reg) limits,
            here = in(reg) at.as_ptr().add(i),
            own = in(reg) sum.as_mut_ptr().add(i),
            upper = inout(reg) model.upper.as_ptr().add(start) => _,
            length = inout(reg) model.rest_length.as_ptr().add(start) => _,
            at = in(reg) at.as_ptr(),
            sum = in(reg) sum.as_mut_ptr(),
            left = inout(reg) links => left,
            j = out(reg) _,
            other = out(reg) _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _,
            out("s6") _, out("s7") _, out("s8") _, out("s9") _, out("s10") _, out("s11") _,
            out("s12") _, out("s13") _, out("s14") _, out("s15") _, out("s16") _, out("s17") _,
            out("s18") _, out("s20") _, out("s21") _, out("s22") _, out("s23") _, out("s24") _,
            options(nostack),
        );
    }
    left
}
