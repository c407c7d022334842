//! The scene of a blade: what it is there for.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{CutOutput, Dynamics, Model, TissueMut, cut_words};
use chaincell_scenes::{Act, Run, Scene, Tier, blade5_track, stage};

/// Ticks that are played.
const TICKS: u32 = 1000;
/// Words of the scene's memory for cuts.
const WORDS: usize = 14_878;

/// Cuts after each tick.
struct Cuts;

impl Act for Cuts {
    type Output = Vec<CutOutput>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        let tick = |_| {
            run.tick();
            run.cuts()
        };
        (0..TICKS).map(tick).collect()
    }
}

/// Faces open and cells split before the scenes' snapshots are taken, and by more than one cell in a tick before the
/// short goldens end; then the spare cells run out, and splits are refused.
#[test]
fn a_blade_splits_cells_until_no_spare_cell_is_left() {
    let scene = &blade5_track::SCENE;
    let model = Model::from_bytes(scene.image).unwrap();
    assert_eq!(cut_words(&model), WORDS);
    let cuts = stage(scene.name, Tier::F32, Cuts).unwrap();
    assert!(cuts[36].copies > 0 && cuts[99].copies > 8, "{:?} {:?}", cuts[36], cuts[99]);
    let splits = cuts[..100].windows(2).map(|pair| pair[1].copies - pair[0].copies);
    assert!(splits.max() > Some(1));
    let last = cuts.last().unwrap();
    assert!(last.copies as usize == model.spare_cells() && last.refused > 0, "{last:?}");
}
