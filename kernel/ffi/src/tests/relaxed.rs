//! A body that relaxes: its energy ledger in the outputs.

use chaincell_kernel::include_model;

use super::{Made, SHAPES, call, choose, make, pose_at, tick};
use crate::{Code, Output, Scheme};

/// `chaincell bake box:6x6x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 --contact-surface yes --branch 1,0.02
/// --branch 0.5,12`.
static RELAXES: &[u8] = include_model!("../../../../tests/data/relax6.chaincell");

/// Three nodes of the top of a body, held.
fn held(image: &[u8]) -> Made {
    let made = make(image, Scheme::Predict, 3);
    assert_eq!(choose(made.tissue, &[59, 63, 83]).0, Code::Ok);
    made
}

/// A press of 5 mm in 25 ticks that stays.
fn press(made: &Made, ticks: u16) -> impl Iterator<Item = Output> {
    (1..=ticks).map(|at| tick(made.tissue, pose_at([0.0, 0.0, -0.0002 * f32::from(at.min(25))], 1)))
}

/// What the tool puts in is held, relaxed, or taken by the sweeps.
#[test]
fn relaxed_energy_closes_the_ledger() {
    let body = held(RELAXES);
    let (mut work_j, mut last) = (0.0, (0.0, 0.0));
    for output in press(&body, 200) {
        work_j += output.work_j;
        let now = (output.energy_j, output.relaxed_j);
        assert!(now.1 >= last.1 && now.0 + now.1 <= 1.001 * work_j, "{now:?} of {work_j}");
        last = now;
    }
    let (energy_j, relaxed_j) = last;
    assert!(relaxed_j > 0.2 * work_j && energy_j + relaxed_j > 0.8 * work_j);
    assert_eq!(call!(chaincell_tissue_reset(body.tissue, core::ptr::null_mut())), Code::Ok);
    assert_eq!(tick(body.tissue, pose_at([0.0; 3], 0)).relaxed_j, 0.0);
}

#[test]
fn an_elastic_body_relaxes_nothing() {
    assert!(press(&held(SHAPES), 50).all(|output| output.relaxed_j == 0.0));
}
