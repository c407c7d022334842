//! Strain and stress at a cell.

use std::vec::Vec;

use super::pointers::bad;
use super::{BOX, SHAPES, call, info_of, make, model_of};
use crate::{CellStress, Code, Scheme, Tissue};

const NOTHING: CellStress =
    CellStress { stretches: [0.0; 3], cauchy_pa: [0.0; 6], von_mises_pa: 0.0, mean_pa: 0.0 };

fn stress(tissue: *mut Tissue, id: u32) -> (Code, CellStress) {
    let mut stress = NOTHING;
    let code = call!(chaincell_stress(tissue, id, &mut stress));
    (code, stress)
}

/// A body that is pulled along z as a bar is, by 0.4 % of its length: it has its tension in every cell.
#[test]
fn a_pulled_body_says_its_tension() {
    let (strain, poisson, young_pa) = (0.004_f32, 0.4, 5000.0);
    for scheme in [Scheme::Track, Scheme::Predict] {
        let made = make(SHAPES, scheme, 1);
        let cells = info_of(&model_of(SHAPES)).cells as usize;
        let mut places: Vec<f32> = std::vec![0.0; 3 * cells];
        assert_eq!(call!(chaincell_positions(made.tissue, places.as_mut_ptr(), cells)), Code::Ok);
        for [x, y, z] in places.as_chunks_mut::<3>().0 {
            *x -= poisson * strain * *x;
            *y -= poisson * strain * *y;
            *z += strain * *z;
        }
        let none = core::ptr::null_mut();
        let set = call!(chaincell_set_positions(made.tissue, places.as_ptr(), cells, none));
        assert_eq!(set, Code::Ok);
        for id in 0..cells as u32 {
            let (code, found) = stress(made.tissue, id);
            assert_eq!(code, Code::Ok);
            let tension_pa = young_pa * strain;
            let [xx, yy, zz, ..] = found.cauchy_pa;
            let off = [
                (found.von_mises_pa - tension_pa) / tension_pa,
                (zz - tension_pa) / tension_pa,
                (3.0 * found.mean_pa - (xx + yy + zz)) / tension_pa,
                (found.stretches[0] - 1.0 - strain) / strain,
                (found.stretches[2] - 1.0 + poisson * strain) / strain,
            ];
            assert!(off.iter().all(|off| off.abs() < 0.01), "{id}: {found:?}, off by {off:?}");
        }
    }
}

// REQ-CIF-01
#[test]
fn what_has_no_stress_says_so() {
    let (links, shapes) = (make(BOX, Scheme::Track, 1), make(SHAPES, Scheme::Track, 1));
    assert_eq!(stress(links.tissue, 64), (Code::NoStress, NOTHING));
    assert_eq!(stress(shapes.tissue, 100_000), (Code::UnknownId, NOTHING));
    for (bad, code) in bad(shapes.tissue) {
        assert_eq!(stress(bad, 64), (code, NOTHING));
    }
    for (bad, code) in bad(&NOTHING) {
        assert_eq!(call!(chaincell_stress(shapes.tissue, 64, bad)), code);
    }
    let inside = shapes.tissue.wrapping_byte_add(64);
    assert_eq!(stress(inside, 64), (Code::NotInitialised, NOTHING));
}
