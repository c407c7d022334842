//! The state hash: 64 bits over the published positions, the same on every target.
//!
//! Definition. The positions are the output y in internal units (mean link lengths from the body's centre);
//! a word is the bit pattern of an `f32`, or of a fixed-point number. For each slice of eight consecutive
//! cells, the last one shorter, the words are x, y, z of its first cell, then of its second, and so on in the
//! model's cell order. After all slices, if terms of the energy keep states, follow the rows of their states
//! for each slice, each row a word of each of eight cells; cells beyond the last are at rest. Two consecutive
//! words of a slice are a long, the first one low; a last single word has 0 above. Long n (from 0) of a
//! slice goes to lane n mod 8. A lane absorbs a long by
//!
//! ```text
//! lane = rotate_left((lane ^ long) * 0x9E3779B185EBCA87 mod 2^64, 29)
//! ```
//!
//! Lane k starts as 0xCBF29CE484222325 + k. In the end one more lane, started as
//! 0xCBF29CE484222325 + 8, absorbs by the same rule lane 0 to 7 and the number of words; with x that lane,
//! the hash is x ^ (x >> 32). Files and messages show it as 16 lower-case hexadecimal digits. The absorption
//! is a bijection of the lane, so a difference in a single word always shows. Cost: one 64-bit multiplication
//! for two words, in eight independent chains.

use crate::contact::memory::TouchState;
use crate::energy::state::{TermState, lasting};
use crate::energy::surface::{PINS_ARE_BUILT, PinSample};
use crate::number::Number;
use crate::number::cell::{Cell, output};
use crate::number::two_float::LANES;

/// Revision of the arithmetic. Two releases of one revision give the same state hashes for the same model,
/// settings and samples; a change that alters any hash raises it. Traces record it. In revision 2 the guard's
/// allowance is that of [`Rounding`](crate::Rounding), a clamped force is rounded down, and large bodies are
/// summed in [`parts`](crate::parts). In revision 3 a tool that the tissue stops rotates where it cannot
/// move. In revision 4 a tool that engages in contact grows from nothing, one that engages inside the tissue
/// waits, the momentum of a body under moving tools is learnt gradually, and samples close to contact count
/// in the elastic coarse level. In revision 5 the state hash takes two words at a time, and states by rows;
/// cells under tools that move give way before the pass, and steps after their push are shorter; a tool gives
/// way as soon as the tissue comes nearer than it may press, and goes in no farther there.
pub const REVISION: u32 = 5;

const START: u64 = 0xCBF2_9CE4_8422_2325;
const PRIME: u64 = 0x9E37_79B1_85EB_CA87;

#[inline(always)]
fn absorb(lane: u64, long: u64) -> u64 {
    (lane ^ long).wrapping_mul(PRIME).rotate_left(29)
}

/// Two words.
#[inline(always)]
fn long(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

/// The lanes, each in a register.
#[derive(Clone, Copy)]
struct Eight([u64; LANES]);

impl Eight {
    /// Absorbs a long in each of the first four lanes.
    #[inline(always)]
    fn first(self, [i, j, k, l]: [u64; 4]) -> Self {
        let [a, b, c, d, rest @ ..] = self.0;
        let [e, f, g, h] = rest;
        Self([absorb(a, i), absorb(b, j), absorb(c, k), absorb(d, l), e, f, g, h])
    }

    /// Absorbs a long in each of the last four lanes.
    #[inline(always)]
    fn last(self, [i, j, k, l]: [u64; 4]) -> Self {
        let [a, b, c, d, e, f, g, h] = self.0;
        Self([a, b, c, d, absorb(e, i), absorb(f, j), absorb(g, k), absorb(h, l)])
    }

    /// Absorbs the words of a slice, one long after the other.
    fn all(mut self, mut words: impl Iterator<Item = u32>) -> Self {
        let mut lane = 0;
        while let Some(low) = words.next() {
            if let Some(lane) = self.0.get_mut(lane) {
                *lane = absorb(*lane, long(low, words.next().unwrap_or(0)));
            }
            lane = (lane + 1) % LANES;
        }
        self
    }
}

/// Hash of the output of the states `v` under the saturation bound `k`, and of the states that the terms keep
/// (see the module's text).
#[must_use]
pub fn state_hash<N: Number>(v: &[Cell<N>], terms: &[TermState], k: f32) -> u64 {
    let k = N::from_single(k);
    let mut lanes = Eight([0, 1, 2, 3, 4, 5, 6, 7].map(|lane| START + lane));
    // The positions.
    let word = |cell: &Cell<N>| output(cell.xyz(), k).map(N::word);
    let (slices, rest) = v.as_chunks::<LANES>();
    for [a, b, c, d, e, f, g, h] in slices {
        let ([a, b, c, d], [e, f, g, h]) =
            ([word(a), word(b), word(c), word(d)], [word(e), word(f), word(g), word(h)]);
        let longs = |[a, b, c, d]: [[u32; 3]; 4]| {
            let ([i, j, k], [l, m, n], [o, p, q], [r, s, t]) = (a, b, c, d);
            [long(i, j), long(k, l), long(m, n), long(o, p), long(q, r), long(s, t)]
        };
        let [i, j, k, l, m, n] = longs([a, b, c, d]);
        let [o, p, q, r, s, t] = longs([e, f, g, h]);
        lanes = lanes.first([i, j, k, l]).last([m, n, o, p]).first([q, r, s, t]);
    }
    lanes = lanes.all(rest.iter().flat_map(word));
    // The states.
    let mut words = v.len() as u64 * 3;
    for rows in lasting(terms, v.len()) {
        let (pairs, single) = rows.as_chunks();
        for [first, last] in pairs {
            lanes = lanes.first(longs(first)).last(longs(last));
        }
        for row in single {
            lanes = lanes.first(longs(row));
        }
        words += (rows.len() * LANES) as u64;
    }
    // Fold the lanes.
    let hash = absorb(lanes.0.iter().fold(START + 8, |hash, &lane| absorb(hash, lane)), words);
    hash ^ hash >> 32
}

/// Hash of words that follow those of a state hash: the lanes start with it, and absorb the words as those of
/// one slice. The state of cuts follows in this way, see [`cut_state`](crate::cut_state).
#[must_use]
pub fn and_words(hash: u64, words: &[u32]) -> u64 {
    let mut lanes = Eight([0, 1, 2, 3, 4, 5, 6, 7].map(|lane| absorb(START + lane, hash)));
    let (rows, rest) = words.as_chunks::<{ 2 * LANES }>();
    for [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] in rows {
        let first = [long(*a, *b), long(*c, *d), long(*e, *f), long(*g, *h)];
        lanes = lanes.first(first).last([long(*i, *j), long(*k, *l), long(*m, *n), long(*o, *p)]);
    }
    let lanes = lanes.all(rest.iter().copied());
    let count = words.len() as u64;
    let hash = absorb(lanes.0.iter().fold(START + 8, |hash, &lane| absorb(hash, lane)), count);
    hash ^ hash >> 32
}

/// Hash of the pins of a tissue after that of its state and cuts: the words of each pinned sample follow, as those of
/// [`and_words`], those of the first one first. Without pins it is the hash as it was.
#[must_use]
pub fn and_pins(hash: u64, state: &TouchState, pins: &[PinSample]) -> u64 {
    let count = if PINS_ARE_BUILT { state.pins } else { 0 };
    pins.iter().take(count).fold(hash, |hash, pin| and_words(hash, &pin.words()))
}

/// The longs of a row.
#[inline(always)]
fn longs(row: &[f32; LANES]) -> [u64; 4] {
    let [a, b, c, d, e, f, g, h] = row.map(f32::to_bits);
    [long(a, b), long(c, d), long(e, f), long(g, h)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::pin::store;
    use crate::energy::state::{LASTING, TermStates, term_states};

    /// The definition word by word, implemented independently: the words of each slice, cells first.
    fn plainly(slices: &[std::vec::Vec<f32>]) -> u64 {
        let mut lanes: [u64; 8] = core::array::from_fn(|k| START + k as u64);
        for slice in slices {
            for (n, word) in slice.iter().enumerate() {
                let (lane, bits) = (&mut lanes[n / 2 % 8], u64::from(word.to_bits()));
                *lane ^= if n % 2 == 0 { bits } else { bits << 32 };
                if n % 2 == 1 || n + 1 == slice.len() {
                    *lane = lane.wrapping_mul(PRIME).rotate_left(29);
                }
            }
        }
        let hash = lanes.iter().fold(START + 8, |hash, &lane| absorb(hash, lane));
        let words: usize = slices.iter().map(std::vec::Vec::len).sum();
        let hash = absorb(hash, words as u64);
        hash ^ hash >> 32
    }

    // REQ-BIT-05
    #[test]
    fn agrees_with_its_definition_at_every_length() {
        let cells: [Cell; 11] = core::array::from_fn(|i| {
            let a = i as f32;
            Cell([a, -a * 0.3, a * a, 99.0])
        });
        // The tests' own term keeps six numbers, others more; numbers at the published positions do not
        // count.
        let pin = |cell: usize| {
            let a = 0.1 + cell as f32;
            [[a, -a, 2.0 * a], [3.0 * a, 0.0, 1.0]]
        };
        let shape = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        for length in 0..=11 {
            let of = |cells: &[Cell]| cells.iter().flat_map(|cell| cell.xyz()).collect();
            let clamped = cells.map(|cell| Cell(cell.0.map(|x| x.clamp(-50.0, 50.0))));
            let mut slices: std::vec::Vec<_> = clamped[..length].chunks(8).map(of).collect();
            assert_eq!(state_hash(&cells[..length], &[], 50.0), plainly(&slices));
            // States of the cells; padding is at rest.
            let mut memory = std::vec![TermState::ZERO; term_states(length)];
            let mut states = TermStates::new(&mut memory);
            states.reset(length);
            for cell in 0..length {
                store(pin(cell), cell % 8, states.shared(length).all().change(cell / 8).unwrap());
            }
            for slice in 0..length.div_ceil(8) {
                let number = |row: usize, cell: usize| match row {
                    0..6 if cell < length => pin(cell).as_flattened()[row],
                    0..6 => 0.0,
                    _ => shape[row - 6],
                };
                let row = |row| (8 * slice..8 * slice + 8).map(move |cell| number(row, cell));
                slices.push((0..LASTING).flat_map(row).collect());
            }
            let hash = state_hash(&cells[..length], &memory, 50.0);
            assert_eq!(hash, plainly(&slices));
        }
    }

    // REQ-BIT-05
    #[test]
    fn one_bit_anywhere_changes_it() {
        let mut cells = [Cell([0.5_f32, 0.25, 1.0, 0.0]); 7];
        let before = state_hash(&cells, &[], 8.0);
        for cell in 0..7 {
            for lane in 0..3 {
                for bit in 0..31 {
                    let kept = cells[cell].0[lane];
                    let flipped = f32::from_bits(kept.to_bits() ^ (1 << bit));
                    if flipped.is_nan() || flipped > 8.0 {
                        continue;
                    }
                    cells[cell].0[lane] = flipped;
                    assert_ne!(state_hash(&cells, &[], 8.0), before, "cell {cell} {lane} {bit}");
                    cells[cell].0[lane] = kept;
                }
            }
        }
    }
}
