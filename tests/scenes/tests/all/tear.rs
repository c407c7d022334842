//! The scene of a bar that tears by itself: what it is there for.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{CutOutput, Dynamics, Model, TissueMut, cut_words};
use chaincell_scenes::{Act, Run, Scene, Tier, stage, tear4_track};

/// Ticks that are played.
const TICKS: u32 = 1000;
/// Words of the scene's memory for cuts.
const WORDS: usize = 9_006;

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

/// Cells tear and split before the scenes' snapshots are taken, without a blade; then the spare cells run out, and
/// more of them tear before the short goldens end, whose splits are refused.
#[test]
fn a_bar_tears_until_no_spare_cell_is_left() {
    let scene = &tear4_track::SCENE;
    let model = Model::from_bytes(scene.image).unwrap();
    assert_eq!(cut_words(&model), WORDS);
    let cuts = stage(scene.name, Tier::F32, Cuts).unwrap();
    let (early, short) = (cuts[36], cuts[99]);
    assert!(early.torn > 0 && early.copies > 0, "{early:?}");
    assert!(short.torn > early.torn && short.refused > early.refused, "{early:?} {short:?}");
    let last = cuts.last().unwrap();
    assert_eq!(last.area_m2, 0.0);
    assert!(last.copies as usize == model.spare_cells() && last.refused > 0, "{last:?}");
}
