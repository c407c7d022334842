//! The updates of `track` and `euler`, with the arithmetic of [`scalar`]: runs of slices whose neighbours are
//! known to be awake in one loop, the others by [`scalar`].

#![allow(unsafe_code)]

use core::arch::asm;
use core::ops::Range;

use crate::backend::slices::cells_of;
use crate::energy::residual::Terms;
use crate::model::Model;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;
use crate::solver::awake::Awake;
use crate::solver::loops::scalar;
use crate::solver::loops::{Moved, Points};

/// Calls `update(watched, cells, beyond)` for the cells of awake slices. Slices whose neighbours may be
/// asleep come one by one, `watched`, and `update` returns whether a cell started to move; the others come in
/// runs of slices.
fn by_runs(
    model: &Model<'_>,
    awake: &Awake,
    moved: &mut Moved,
    mut update: impl FnMut(bool, Range<usize>, &mut bool) -> bool,
) {
    let cells = model.cells();
    let mut slices = awake.set.iter(model.slice_count()).peekable();
    while let Some(first) = slices.next() {
        if !awake.spread.contains(first) {
            if update(true, cells_of(first, cells), &mut moved.beyond) {
                moved.slices.insert(first);
            }
            continue;
        }
        let mut end = first + 1;
        while slices.next_if(|&next| next == end && awake.spread.contains(next)).is_some() {
            end += 1;
        }
        update(false, first * LANES..cells.min(end * LANES), &mut moved.beyond);
    }
}

/// See `Loops::track_step`.
pub(crate) fn track(
    terms: Terms<'_, '_>,
    awake: &Awake,
    points: &mut Points<'_, f32>,
    factors: [f32; 2],
    moved: &mut Moved,
) {
    by_runs(terms.model, awake, moved, |watched, cells, beyond| {
        if watched {
            return scalar::track::update::<f32, true>(terms, &cells, points, factors, beyond);
        }
        *beyond |= run_track(terms, cells, points, factors);
        false
    })
}

/// See `Loops::euler_step`.
pub(crate) fn euler(
    model: &Model<'_>,
    awake: &Awake,
    state: &mut [Cell],
    residual: &[Cell],
    step: f32,
    moved: &mut Moved,
) {
    by_runs(model, awake, moved, |watched, cells, beyond| {
        if watched {
            return scalar::euler::update(model, &cells, state, residual, step, beyond);
        }
        *beyond |= run_euler(model, cells, state, residual, step);
        false
    })
}

/// The update of `track`. Returns true if some coordinate is beyond K.
fn run_track(
    terms: Terms<'_, '_>,
    cells: Range<usize>,
    points: &mut Points<'_, f32>,
    [alpha, beta]: [f32; 2],
) -> bool {
    let linear = scalar::Range::new(terms.model.saturation());
    let (Some(published), Some(at), Some(before), Some(residual), Some(mobility)) = (
        points.published.get_mut(cells.clone()),
        points.at.get_mut(cells.clone()),
        points.before.get_mut(cells.clone()),
        points.residual.get(cells.clone()),
        terms.mobility().get(cells.clone()),
    ) else {
        return false;
    };
    if cells.is_empty() {
        return false;
    }
    let factors = [alpha, beta, linear.near, 0.0];
    let far: u32;
    // SAFETY: the five arrays have as many elements as there are cells, at least one; the code
    // reads and writes only them, and the stack not at all.
    unsafe {
        asm!(
            "vldmia {far}, {{s18}}; vldr s20, [{far}, #4]; vldr s21, [{far}, #8]",
            "vldr s15, [{far}, #12]; mov {far}, #0",
            "2: vldmia {residual}!, {{s0-s3}}",
            "vldmia {mobility}!, {{s12}}",
            "vldmia {at}, {{s4-s7}}",
            "vldmia {before}, {{s8-s11}}",
            "vmul.f32 s0, s12, s0; vmul.f32 s1, s12, s1; vmul.f32 s2, s12, s2",
            "vsub.f32 s8, s4, s8; vsub.f32 s9, s5, s9; vsub.f32 s10, s6, s10",
            "vstmia {before}!, {{s4-s7}}",
            "vadd.f32 s12, s4, s0; vadd.f32 s13, s5, s1; vadd.f32 s14, s6, s2",
            "vstmia {published}!, {{s12-s15}}",
            "vmla.f32 s4, s18, s0; vmla.f32 s5, s18, s1; vmla.f32 s6, s18, s2",
            "vmla.f32 s4, s20, s8; vmla.f32 s5, s20, s9; vmla.f32 s6, s20, s10",
            "vstmia {at}!, {{s4-s7}}",
            "vmul.f32 s16, s12, s12; vmla.f32 s16, s13, s13; vmla.f32 s16, s14, s14",
            "vmla.f32 s16, s4, s4; vmla.f32 s16, s5, s5; vmla.f32 s16, s6, s6",
            "vcmp.f32 s16, s21; vmrs APSR_nzcv, fpscr; bpl 4f",
            "3: subs {left}, {left}, #1; bne 2b",
            "b 5f",
            "4: mov {far}, #1; b 3b",
            "5:",
            far = inout(reg) factors.as_ptr() => far,
            published = inout(reg) published.as_mut_ptr() => _,
            at = inout(reg) at.as_mut_ptr() => _,
            before = inout(reg) before.as_mut_ptr() => _,
            residual = inout(reg) residual.as_ptr() => _,
            mobility = inout(reg) mobility.as_ptr() => _,
            left = inout(reg) cells.len() => _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _,
            out("s6") _, out("s7") _, out("s8") _, out("s9") _, out("s10") _, out("s11") _,
            out("s12") _, out("s13") _, out("s14") _, out("s15") _, out("s16") _, out("s18") _,
            out("s20") _, out("s21") _,
            options(nostack),
        );
    }
    far != 0 && published.iter().zip(at).any(|(x, y)| linear.is_left(x.xyz(), y.xyz()))
}

/// The update of `euler`. Returns true if some coordinate is beyond K.
fn run_euler(
    model: &Model<'_>,
    cells: Range<usize>,
    state: &mut [Cell],
    residual: &[Cell],
    step: f32,
) -> bool {
    let linear = scalar::Range::new(model.saturation());
    let (Some(state), Some(residual), Some(mobility)) = (
        state.get_mut(cells.clone()),
        residual.get(cells.clone()),
        model.mobility.get(cells.clone()),
    ) else {
        return false;
    };
    if cells.is_empty() {
        return false;
    }
    let factors = [step, linear.near];
    let far: u32;
    // SAFETY: the three arrays have as many elements as there are cells, at least one; the code
    // reads and writes only them and reads the factors, and the stack not at all.
    unsafe {
        asm!(
            "vldr s18, [{far}]; vldr s20, [{far}, #4]; mov {far}, #0",
            "2: vldmia {residual}!, {{s0-s3}}",
            "vldmia {mobility}!, {{s12}}",
            "vldmia {state}, {{s4-s7}}",
            "vcmp.f32 s12, #0.0; vmrs APSR_nzcv, fpscr; ble 3f",
            "vmla.f32 s4, s18, s0; vmla.f32 s5, s18, s1; vmla.f32 s6, s18, s2",
            "3: vstmia {state}!, {{s4-s7}}",
            "vmul.f32 s16, s4, s4; vmla.f32 s16, s5, s5; vmla.f32 s16, s6, s6",
            "vcmp.f32 s16, s20; vmrs APSR_nzcv, fpscr; bpl 5f",
            "4: subs {left}, {left}, #1; bne 2b",
            "b 6f",
            "5: mov {far}, #1; b 4b",
            "6:",
            far = inout(reg) factors.as_ptr() => far,
            state = inout(reg) state.as_mut_ptr() => _,
            residual = inout(reg) residual.as_ptr() => _,
            mobility = inout(reg) mobility.as_ptr() => _,
            left = inout(reg) cells.len() => _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _,
            out("s6") _, out("s7") _, out("s12") _, out("s16") _, out("s18") _, out("s20") _,
            options(nostack),
        );
    }
    far != 0 && state.iter().any(|v| linear.is_left(v.xyz(), v.xyz()))
}
