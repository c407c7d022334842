//! Corrections for held cells against dense matrices in double precision.

use super::held::{coarse_room, hold};
use super::*;
use crate::backend::{VectorUnit, run};
use crate::energy::held::Contact;
use crate::energy::tests::{ROUNDING_ROOM, matrix, pinned};
use crate::model::Model;
use crate::model::pin::Pin;
use crate::number::two_float::LANES;
use std::vec;
use std::vec::Vec;

/// `chaincell bake box:7x7x5x0.01 --alpha 0.03 --coarse 2.5`.
pub(crate) static CUBE: &[u8] = crate::include_model!("../../../../tests/data/box7.chaincell");

/// Solves for a right-hand side in the coarse memory; returns both sides, axis by axis.
fn solved(model: &Model<'_>, held: &[Contact]) -> (Vec<[f64; 3]>, Vec<[f64; 3]>, f64) {
    let basis = model.coarse_basis.unwrap();
    let blocks = basis.blocks();
    let mut room = vec![[0.0_f32; LANES]; coarse_room(basis.count, held.len())];
    hold(model, &basis, &mut room, held);
    for axis in 0..3 {
        for function in 0..basis.count {
            let seed = (7 * function + 3 * axis) as f32 * 0.618_034;
            room[axis * blocks + function / LANES][function % LANES] = seed % 1.0 - 0.5;
        }
    }
    let solve = Solve { basis, room: &mut room, coarse: Coarse::Corrected(held.len()) };
    let product = run(VectorUnit::find(), solve);
    let side = |from: usize| -> Vec<[f64; 3]> {
        let at = |function: usize, axis: usize| {
            f64::from(room[(from + axis) * blocks + function / LANES][function % LANES])
        };
        (0..basis.count).map(|function| [0, 1, 2].map(|axis| at(function, axis))).collect()
    };
    (side(0), side(3), f64::from(product.hi))
}

#[test]
fn held_cells_are_corrected_for_exactly() {
    corrected_for_exactly(&Model::from_bytes(CUBE).unwrap());
}

/// Another term is part of the bound, and of the part that a held cell removes from it.
#[test]
fn held_cells_with_pins_are_corrected_for_exactly() {
    let pin = |cell| Pin { cell, point: [0.0; 3], weight: 3.0, slip_length: 1.0, give: 0.5 };
    let pins = [60, 61, 130, 200].map(pin);
    corrected_for_exactly(&Model::from_bytes(pinned(CUBE, &pins, false)).unwrap());
}

fn corrected_for_exactly(model: &Model<'_>) {
    let basis = model.coarse_basis.unwrap();
    let whole = matrix(model, model.others.0.iter(), &basis, &[]);
    let free: Vec<u16> = (0..model.cells() as u16).filter(|&c| !model.is_fixed(c)).collect();
    for count in [0, 1, 2, 7, 30, free.len()] {
        let held: Vec<Contact> = free
            .iter()
            .step_by((free.len() / count.max(1)).max(1))
            .take(count)
            .copied()
            .map(Contact::new)
            .collect();
        let (g, c, product) = solved(model, &held);
        let masked = matrix(model, model.others.0.iter(), &basis, &held);
        let mut exact = 0.0;
        for function in 0..basis.count {
            for axis in 0..3 {
                let room = ROUNDING_ROOM * (basis.count as f64).sqrt();
                let own = room * whole[function][function] * c[function][axis];
                let sum: f64 =
                    (0..basis.count).map(|other| masked[function][other] * c[other][axis]).sum();
                assert!(
                    (sum + own - g[function][axis]).abs() < 2e-3,
                    "{count} held, function {function}: {sum} and {own} for {}",
                    g[function][axis]
                );
                exact += g[function][axis] * c[function][axis];
                // The bound used by the guard: c' A c <= g . c.
                assert!(own * c[function][axis] >= 0.0);
            }
        }
        let curved: f64 = (0..basis.count * basis.count)
            .map(|at| (at / basis.count, at % basis.count))
            .flat_map(|(a, b)| (0..3).map(move |axis| (a, b, axis)))
            .map(|(a, b, axis)| c[a][axis] * masked[a][b] * c[b][axis])
            .sum();
        assert!(curved <= product, "{count} held: {curved} above {product}");
        assert!((product - exact).abs() <= 1e-5 * exact, "{product} {exact}");
    }
}
