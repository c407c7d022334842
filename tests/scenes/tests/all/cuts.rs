//! The scenes of a blade and of a bar that tears by itself: what they are there for.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{CutOutput, Dynamics, Model, TissueMut, cut_words};
use chaincell_scenes::{Act, Run, Scene, Tier, blade5_track, stage, tear4_track};

/// Ticks that are played.
const TICKS: u32 = 1000;

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

/// Plays a scene whose memory for cuts has this number of words, until no spare cell is left and splits are refused.
/// Returns the cuts after each tick.
#[track_caller]
fn played(scene: &'static Scene, words: usize) -> Vec<CutOutput> {
    let model = Model::from_bytes(scene.image).unwrap();
    assert_eq!(cut_words(&model), words);
    let cuts = stage(scene.name, Tier::F32, Cuts).unwrap();
    let last = cuts.last().unwrap();
    assert!(last.copies as usize == model.spare_cells() && last.refused > 0, "{last:?}");
    cuts
}

/// Faces open and cells split before the scenes' snapshots are taken, and by more than one cell in a tick before the
/// short goldens end; then the spare cells run out, and splits are refused.
#[test]
fn a_blade_splits_cells_until_no_spare_cell_is_left() {
    let cuts = played(&blade5_track::SCENE, 14_878);
    assert!(cuts[36].copies > 0 && cuts[99].copies > 8, "{:?} {:?}", cuts[36], cuts[99]);
    let splits = cuts[..100].windows(2).map(|pair| pair[1].copies - pair[0].copies);
    assert!(splits.max() > Some(1));
}

/// Cells tear and split before the scenes' snapshots are taken, without a blade; then the spare cells run out, and
/// more of them tear before the short goldens end, whose splits are refused.
#[test]
fn a_bar_tears_until_no_spare_cell_is_left() {
    let cuts = played(&tear4_track::SCENE, 9_006);
    let (early, short) = (cuts[36], cuts[99]);
    assert!(early.torn > 0 && early.copies > 0, "{early:?}");
    assert!(short.torn > early.torn && short.refused > early.refused, "{early:?} {short:?}");
    assert_eq!(cuts.last().unwrap().area_m2, 0.0);
}
