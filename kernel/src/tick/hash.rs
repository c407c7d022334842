//! The state hash: 64 bits over the published positions, the same on every target.
//!
//! Definition. The words are the `f32` bit patterns of the output y in internal units (mean link
//! lengths from the body's centre): x, y, z of cell 0, then of cell 1, and so on in the model's
//! cell order. A fixed-point number is one word too. Word n
//! (from 0) goes to lane n mod 4. A lane absorbs a word by
//!
//! ```text
//! lane = (lane ^ word) * 0x9E3779B185EBCA87 mod 2^64
//! lane = lane ^ (lane >> 32)
//! ```
//!
//! Lane k starts as 0xCBF29CE484222325 + k. In the end one more lane, started as
//! 0xCBF29CE484222325 + 4, absorbs by the same rule lane 0, 1, 2, 3 (64 bits each) and the number
//! of words; its value is the hash. Files and messages show it as 16 lower-case hexadecimal
//! digits. The absorption is a bijection of the lane, so a difference in a single word always
//! shows. Cost: one 64-bit multiplication per word, in four independent chains.

use crate::number::Number;
use crate::number::cell::{Cell, output};
use crate::terms::state::{TermState, words};

/// Revision of the arithmetic. Two releases of one revision give the same state hashes for the same model,
/// settings and samples; a change that alters any hash raises it. Traces record it. In revision 2 the guard's
/// allowance is that of [`Rounding`](crate::Rounding), a clamped force is rounded down, and large bodies are
/// summed in [`parts`](crate::parts). In revision 3 a tool that the tissue stops rotates where it cannot
/// move. In revision 4 a tool that engages in contact grows from nothing, one that engages inside the tissue
/// waits, the momentum of a body under moving tools is learnt gradually, and samples close to contact count
/// in the elastic coarse level.
pub const REVISION: u32 = 4;

const START: u64 = 0xCBF2_9CE4_8422_2325;
const PRIME: u64 = 0x9E37_79B1_85EB_CA87;

#[inline(always)]
fn absorb(lane: u64, word: u64) -> u64 {
    let mixed = (lane ^ word).wrapping_mul(PRIME);
    mixed ^ (mixed >> 32)
}

/// Hash of the output of the states `v` under the saturation bound `k`, and of the states that the terms keep
/// (see the module's text).
#[must_use]
pub fn state_hash<N: Number>(v: &[Cell<N>], terms: &[TermState], k: f32) -> u64 {
    let mut lanes = [START, START + 1, START + 2, START + 3];
    let k = N::from_single(k);
    let word = |value: N| u64::from(value.word());
    let mut blocks = v.chunks_exact(4);
    for block in &mut blocks {
        let &[a, b, c, d] = block else { continue };
        let [a, b, c, d] = [a, b, c, d].map(|cell| output(cell.xyz(), k).map(word));
        for four in [[a[0], a[1], a[2], b[0]], [b[1], b[2], c[0], c[1]], [c[2], d[0], d[1], d[2]]] {
            for (lane, word) in lanes.iter_mut().zip(four) {
                *lane = absorb(*lane, word);
            }
        }
    }
    // Four cells are twelve words, so the remainder starts in lane 0 again.
    let rest = blocks.remainder().iter().flat_map(|cell| output(cell.xyz(), k)).map(N::word);
    let count = v.len() as u64 * 3 + words(terms, v.len()).count() as u64;
    finish(absorb_all(lanes, rest.chain(words(terms, v.len()))), count)
}

/// Absorbs words in order, the first into lane 0.
fn absorb_all(mut lanes: [u64; 4], words: impl Iterator<Item = u32>) -> [u64; 4] {
    for (n, word) in words.enumerate() {
        if let Some(lane) = lanes.get_mut(n % 4) {
            *lane = absorb(*lane, u64::from(word));
        }
    }
    lanes
}

fn finish(lanes: [u64; 4], words: u64) -> u64 {
    let folded = lanes.iter().fold(START + 4, |hash, &lane| absorb(hash, lane));
    absorb(folded, words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::state::{CellState, State, TermStates, term_states};

    /// The definition word by word, implemented independently.
    fn plainly(words: &[f32]) -> u64 {
        let mut lanes: [u64; 4] = core::array::from_fn(|k| START + k as u64);
        for (n, word) in words.iter().enumerate() {
            lanes[n % 4] = absorb(lanes[n % 4], u64::from(word.to_bits()));
        }
        let hash = lanes.iter().fold(START + 4, |hash, &lane| absorb(hash, lane));
        absorb(hash, words.len() as u64)
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
            let mut words = std::vec::Vec::new();
            for cell in &cells[..length] {
                words.extend(cell.xyz().map(|word| word.clamp(-50.0, 50.0)));
            }
            assert_eq!(state_hash(&cells[..length], &[], 50.0), plainly(&words));
            let mut memory = std::vec![TermState::ZERO; term_states(length)];
            let mut states = TermStates::new(&mut memory);
            states.reset(length);
            for cell in 0..length {
                states.shared(length).put(cell, (pin(cell), State::REST.1));
                words.extend(pin(cell).as_flattened());
                words.extend(&shape[..State::LASTING - 6]);
            }
            let hash = state_hash(&cells[..length], &memory, 50.0);
            assert_eq!(hash, plainly(&words));
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
