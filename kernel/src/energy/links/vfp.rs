//! The link pass, link by link. Every operation is that of
//! [`link_force`](crate::energy::links::law), in its order.

#![allow(unsafe_code)]

use core::arch::asm;

use crate::backend::slice_set::SliceSet;
use crate::energy::links::bands::rest_difference;
use crate::energy::links::law::{Band, COINCIDENT, link_force};
use crate::model::Model;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// The limits of a row's links, in the order in which [`run`] loads them.
#[repr(C)]
struct Limits {
    high: f32,
    high_squared: f32,
    low: f32,
    low_squared: f32,
    coincident: f32,
}

/// Adds every link's force to both its ends, as [`accumulate`](crate::energy::links::scalar::accumulate) does;
/// one band for all links, all of weight 1. Does nothing if an array is shorter than the model.
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
    let limits = Limits {
        high: band.high,
        high_squared: band.high_squared,
        low: band.low,
        low_squared: band.low_squared,
        coincident: COINCIDENT,
    };
    // Run over blocks of awake slices; a coincident link interrupts the run.
    let mut awake = awake.iter(slices).peekable();
    while let Some(first) = awake.next() {
        let mut end = first + 1;
        while awake.next_if_eq(&end).is_some() {
            end += 1;
        }
        let mut place = Place { cell: first * LANES, left: 0 };
        loop {
            // SAFETY: both arrays hold as many cells as the model.
            place = unsafe { run(model, &limits, place, cells.min(end * LANES), at, sum) };
            if place.left == 0 {
                break;
            }
            let link = model.row(place.cell).end - place.left;
            coincident(model, band, place.cell, link, at, sum);
            place.left -= 1;
            if place.left == 0 {
                place.cell += 1;
            }
        }
    }
}

/// Progress of the pass: a cell, and the number of links left in its row; 0 for all of them.
struct Place {
    cell: usize,
    left: usize,
}

/// Adds a link with undefined direction.
#[cold]
fn coincident(model: &Model<'_>, band: Band, i: usize, link: usize, at: &[Cell], sum: &mut [Cell]) {
    let (Some(&upper), Some(&l0)) = (model.upper.get(link), model.rest_length.get(link)) else {
        return;
    };
    let j = usize::from(upper);
    let (Some(here), Some(there)) = (at.get(i), at.get(j)) else { return };
    let rest = || rest_difference(model, i, j);
    let Some(of) = link_force(here.xyz(), there.xyz(), l0, 1.0, band, rest) else { return };
    let [x, y, z] = of.force;
    if let Some(sum) = sum.get_mut(i) {
        *sum = sum.plus(Cell([x, y, z, of.wd2]));
    }
    if let Some(sum) = sum.get_mut(j) {
        *sum = sum.plus(Cell([-x, -y, -z, of.wd2]));
    }
}

/// Runs the rows of the cells from `place` to `end`, until a link coincides. Returns the place of that link,
/// counted among those left, or `end` with none left.
///
/// # Safety
/// `at` and `sum` hold at least as many cells as the model.
#[inline(always)]
unsafe fn run(
    model: &Model<'_>,
    limits: &Limits,
    place: Place,
    end: usize,
    at: &[Cell],
    sum: &mut [Cell],
) -> Place {
    const BYTES: usize = size_of::<Cell>();
    let Some(&start) = model.rows.get(place.cell) else { return Place { cell: end, left: 0 } };
    let (mut left, mut cell) = (place.left, place.cell * BYTES);
    let (rows, start) = if left == 0 {
        (place.cell, start as usize)
    } else {
        (place.cell + 1, model.row(place.cell).end - left)
    };
    // SAFETY: rows ascend to the number of links, the length of both sections read here; upper ends
    // are cells above their row's; and the caller's promise. The stack is not touched.
    unsafe {
        asm!(
            "vldmia {j}, {{s7-s11}}; vmov s24, s11",
            "cmp {left}, #0; bne 3f",
            // A row.
            "2: cmp {cell}, {end}; bhs 9f",
            "ldr {j}, [{rows}], #4; ldr {other}, [{rows}]",
            "subs {left}, {other}, {j}; beq 8f",
            "3: add {other}, {at}, {cell}; vldmia {other}, {{s0-s2}}",
            "add {other}, {sum}, {cell}; vldmia {other}, {{s3-s6}}",
            // A link.
            "4: ldrh {j}, [{upper}], #2",
            "vldmia {length}!, {{s11}}",
            "add {other}, {at}, {j}, lsl #4; vldmia {other}, {{s12-s14}}",
            "vsub.f32 s12, s12, s0; vsub.f32 s13, s13, s1; vsub.f32 s14, s14, s2",
            "vmul.f32 s16, s12, s12; vmla.f32 s16, s13, s13; vmla.f32 s16, s14, s14",
            "vmul.f32 s17, s11, s11; vmul.f32 s18, s17, s8",
            "vcmp.f32 s16, s18; vmrs APSR_nzcv, fpscr; ble 6f",
            // Too long: d = u - high l0.
            "vsqrt.f32 s16, s16; vadd.f32 s17, s16, s16; vmls.f32 s16, s11, s7",
            "5: vmul.f32 s15, s16, s16; vdiv.f32 s17, s16, s17",
            "vmul.f32 s12, s17, s12; vmul.f32 s13, s17, s13; vmul.f32 s14, s17, s14",
            "vadd.f32 s3, s3, s12; vadd.f32 s4, s4, s13; vadd.f32 s5, s5, s14",
            "vadd.f32 s6, s6, s15",
            "add {other}, {sum}, {j}, lsl #4; vldmia {other}, {{s20-s23}}",
            "vsub.f32 s20, s20, s12; vsub.f32 s21, s21, s13; vsub.f32 s22, s22, s14",
            "vadd.f32 s23, s23, s15; vstmia {other}, {{s20-s23}}",
            "7: subs {left}, {left}, #1; bne 4b",
            "add {other}, {sum}, {cell}; vstmia {other}, {{s3-s6}}",
            "8: add {cell}, {cell}, #16; b 2b",
            // Slack, coincident, or too short: d = u - low l0.
            "6: vmul.f32 s18, s17, s10",
            "vcmp.f32 s16, s18; vmrs APSR_nzcv, fpscr; bge 7b",
            "vmul.f32 s18, s17, s24",
            "vcmp.f32 s16, s18; vmrs APSR_nzcv, fpscr; ittt pl",
            "vsqrtpl.f32 s16, s16; vaddpl.f32 s17, s16, s16; vmlspl.f32 s16, s11, s9",
            "bpl 5b",
            "add {other}, {sum}, {cell}; vstmia {other}, {{s3-s6}}",
            "9:",
            j = inout(reg) limits => _,
            cell = inout(reg) cell,
            end = in(reg) end * BYTES,
            left = inout(reg) left,
            rows = inout(reg) model.rows.as_ptr().add(rows) => _,
            upper = inout(reg) model.upper.as_ptr().add(start) => _,
            length = inout(reg) model.rest_length.as_ptr().add(start) => _,
            at = in(reg) at.as_ptr(),
            sum = in(reg) sum.as_mut_ptr(),
            other = out(reg) _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _,
            out("s6") _, out("s7") _, out("s8") _, out("s9") _, out("s10") _, out("s11") _,
            out("s12") _, out("s13") _, out("s14") _, out("s15") _, out("s16") _, out("s17") _,
            out("s18") _, out("s20") _, out("s21") _, out("s22") _, out("s23") _, out("s24") _,
            options(nostack),
        );
    }
    Place { cell: cell / BYTES, left }
}
