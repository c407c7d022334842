//! Compares every operation of `F32x8` on the machine's unit with `Lanes8`.
//!
//! Only the payload and the sign of a NaN from an operation may differ: from sum, difference, product,
//! quotient and root, and from operations on their results. The kernel meets such a NaN in one place, 0 / 0
//! of a padding slot, and masks it. Operations that move or choose keep even the bits of a NaN, and no
//! comparison holds for one.

#![allow(unsafe_code)]

use core::array::from_fn;
use core::cell::Cell as Shared;

use proptest::prelude::*;
use std::vec::Vec;

use super::super::f32x8::{Chunk, F32x8};
use super::super::{Work, run};
use super::unit;
use crate::number::cell::Cell;
use crate::number::two_float::{LANES, Lanes};

type Eight = [f32; LANES];

/// Operands of every operation.
#[derive(Debug, Clone, Copy)]
struct Operands {
    a: Eight,
    b: Eight,
    cells: [[f32; 4]; 16],
    ids: [u16; LANES],
}

/// The result of an operation.
#[derive(Debug, Clone, PartialEq)]
struct Outcome {
    name: &'static str,
    bits: Vec<u32>,
}

/// Results of both kinds: rounded ones, for which all NaNs are equal, and exact ones, all of whose bits are
/// defined.
#[derive(Debug, Default, PartialEq)]
struct Outcomes(Vec<Outcome>);

/// Stands for any NaN.
const NAN: u32 = 0x7fc0_0000;

impl Outcomes {
    fn exact(&mut self, name: &'static str, values: &[f32]) {
        let bits = values.iter().map(|value| value.to_bits()).collect();
        self.0.push(Outcome { name, bits });
    }

    fn rounded(&mut self, name: &'static str, values: &[f32]) {
        let one = |value: &f32| if value.is_nan() { NAN } else { value.to_bits() };
        self.0.push(Outcome { name, bits: values.iter().map(one).collect() });
    }
}

#[inline(always)]
fn lanes<V: F32x8>(of: V) -> Eight {
    let mut lanes = [0.0; LANES];
    of.store(&mut lanes);
    lanes
}

#[inline(always)]
fn flat<V: F32x8>(of: &[V]) -> Vec<f32> {
    of.iter().flat_map(|&of| lanes(of)).collect()
}

impl Work for Operands {
    type Output = Outcomes;

    #[inline(always)]
    fn run<V: F32x8>(self) -> Outcomes {
        let mut seen = Outcomes::default();
        let (a, b) = (V::load(&self.a), V::load(&self.b));
        self.arithmetic(a, b, &mut seen);
        self.choices(a, b, &mut seen);
        self.moves::<V>(&mut seen);
        seen
    }
}

impl Operands {
    #[inline(always)]
    fn arithmetic<V: F32x8>(&self, a: V, b: V, seen: &mut Outcomes) {
        seen.rounded("plus", &lanes(a.plus(b)));
        seen.rounded("minus", &lanes(a.minus(b)));
        seen.rounded("times", &lanes(a.times(b)));
        seen.rounded("over", &lanes(a.over(b)));
        seen.rounded("root", &lanes(a.root()));
        seen.rounded("folded", &a.folded().0);
        // With a fused multiply-add these would differ.
        seen.rounded("product and sum", &lanes(a.times(b).plus(a)));
        seen.rounded("product and difference", &lanes(a.minus(a.times(b))));
        let mut sums = Lanes::ZERO;
        sums.add(a);
        sums.add(b);
        sums.add(a.minus(b));
        let total = sums.total();
        seen.rounded("two-float sums", &[total.hi, total.lo]);
    }

    #[inline(always)]
    fn choices<V: F32x8>(&self, a: V, b: V, seen: &mut Outcomes) {
        let one = V::splat(1.0);
        seen.exact("magnitude", &lanes(a.magnitude()));
        seen.exact("signed_as", &lanes(a.signed_as(b)));
        seen.exact("larger_magnitude", &lanes(a.larger_magnitude(b)));
        let (above, below, equal) = (a.above(b), a.below(b), a.equals(b));
        let either = V::either(above, below);
        let twice = V::either(above, above);
        for (name, mask) in [
            ("above", above),
            ("below", below),
            ("equals", equal),
            ("either", either),
            ("itself", twice),
        ] {
            seen.exact(name, &lanes(one.keep(mask)));
            seen.exact(name, &[f32::from(u8::from(V::any(mask)))]);
            seen.exact("keep", &lanes(a.keep(mask)));
            seen.exact("select", &lanes(V::select(mask, a, b)));
        }
        for lane in 0..LANES {
            let mut only = [0.0; LANES];
            only[lane] = 1.0;
            let only = V::load(&only).above(V::splat(0.5));
            seen.exact("any of one lane", &[f32::from(u8::from(V::any(only)))]);
            seen.exact("keep of one lane", &lanes(a.keep(only)));
        }
    }

    #[inline(always)]
    fn moves<V: F32x8>(&self, seen: &mut Outcomes) {
        let cells = self.cells.map(Cell);
        let chunk: &Chunk = cells.first_chunk().unwrap();
        // SAFETY: the ids are below the number of cells.
        seen.exact("gather", &flat(&unsafe { V::gather(&cells, &self.ids) }));
        // Transposition of eight cells and back.
        let rows = V::transposed(chunk);
        seen.exact("transposed", &flat(&rows));
        let mut back = [Cell([7.0; 4]); LANES];
        V::put_transposed(rows, &mut back);
        seen.exact("put_transposed", &back.map(|cell| cell.0).concat());
        // Added to cells, one of which may occur more than once.
        let sums = cells.map(Shared::new);
        V::add_to(rows, self.ids.map(|id| sums.get(usize::from(id)).unwrap_or(&sums[0])));
        seen.rounded("add_to", &sums.map(|sum| sum.get().0).concat());
        // Pairs of consecutive cells.
        for pair in 0..4 {
            let two = V::pair(chunk, pair);
            seen.exact("pair", &lanes(two));
            let mut back = [Cell([7.0; 4]); LANES];
            two.put_pair(&mut back, pair);
            seen.exact("put_pair", &back.map(|cell| cell.0).concat());
            seen.exact("spread", &lanes(V::spread(&self.a, pair)));
            seen.exact("in_turn", &lanes(V::in_turn(&self.a, pair)));
            seen.exact("positions", &lanes(two.positions()));
        }
        // Two cells at any place.
        let couple = [self.ids[0], self.ids[1]];
        let mut back = [Cell([7.0; 4]); 16];
        // SAFETY: the ids are below the number of cells and of values.
        let two = unsafe { V::couple(&cells, couple) };
        // SAFETY: as above.
        unsafe { two.uncouple(&mut back, couple) };
        seen.exact("couple", &lanes(two));
        seen.exact("woven", &lanes(two.woven()));
        seen.exact("unwoven", &lanes(two.unwoven()));
        seen.exact("uncouple", &back.map(|cell| cell.0).concat());
        // SAFETY: as above.
        let values = unsafe { V::couple_values(self.cells.as_flattened(), couple) };
        seen.exact("couple_values", &lanes(values));
        // Broadcasts, load and store.
        seen.exact("twice", &lanes(V::twice(chunk[3])));
        seen.exact("splat", &lanes(V::splat(self.a[0])));
        seen.exact("load and store", &lanes(V::load(&self.a)));
    }
}

/// Values where units differ if they differ anywhere: zeros of both signs, denormals, the ends of the range,
/// the largest admitted coordinates and stretch and its square, and NaNs.
const EDGES: [u32; 28] = [
    0,
    0x8000_0000,
    1,
    0x8000_0001,
    0x007f_ffff,
    0x807f_ffff,
    0x0080_0000,
    0x8080_0000,
    0x2b8c_bccc, // 1e-12
    0xab8c_bccc,
    0x33d6_bf95, // 1e-7
    0x3f7f_ffff,
    0x3f80_0000,
    0xbf80_0000,
    0x3f80_0001,
    0x3eaa_aaab, // 1 / 3
    0x4974_2400, // 1e6
    0xc974_2400,
    0x49f4_2400, // 2e6
    0x532e_9f7d, // 7.5e11
    0x5e5e_0b6b, // 4e18
    0x7f7f_ffff,
    0xff7f_ffff,
    0x7f80_0000,
    0xff80_0000,
    0x7fc0_0000,
    0xffc0_0000,
    0x7fc1_2345,
];

fn compare(operands: Operands) -> Result<(), TestCaseError> {
    let Some(unit) = unit("operations") else { return Ok(()) };
    let (plain, vector) = (run(None, operands), run(Some(unit), operands));
    prop_assert_eq!(plain.0.len(), vector.0.len());
    for (plain, vector) in plain.0.iter().zip(&vector.0) {
        prop_assert_eq!(plain, vector, "{:?}", operands);
    }
    Ok(())
}

// REQ-BIT-02
#[test]
fn every_pair_of_edges_gives_the_same_bits() {
    let edge = |index: usize| f32::from_bits(EDGES[index % EDGES.len()]);
    for first in 0..EDGES.len() {
        for shift in 0..EDGES.len() {
            let operands = Operands {
                a: from_fn(|lane| edge(first + lane)),
                b: from_fn(|lane| edge(first + shift + lane)),
                cells: from_fn(|cell| from_fn(|lane| edge(first * cell + shift + lane))),
                ids: from_fn(|lane| ((first + 5 * lane) % 16) as u16),
            };
            compare(operands).unwrap();
        }
    }
}

fn value() -> impl Strategy<Value = f32> {
    prop_oneof![
        2 => any::<u32>().prop_map(f32::from_bits),
        2 => prop::sample::select(&EDGES[..]).prop_map(f32::from_bits),
        4 => -4.0_f32..4.0,
        1 => -1.0e6_f32..1.0e6,
        1 => (0..1_u32 << 23).prop_map(f32::from_bits),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn random_operands_give_the_same_bits(
        [a, b] in prop::array::uniform2(prop::array::uniform8(value())),
        cells in prop::array::uniform16(prop::array::uniform4(value())),
        ids in prop::array::uniform8(0_u16..16),
    ) {
        compare(Operands { a, b, cells, ids })?;
    }
}
