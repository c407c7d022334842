//! Every scene endures what no body should come to.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{Dynamics, TissueMut};
use chaincell_scenes::adverse::{AdverseError, STATES, endure};
use chaincell_scenes::{Act, SCENES, Scene, stage};

/// The digests after all states.
struct Endure;

impl Act for Endure {
    type Output = Result<Vec<u64>, AdverseError>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let (mut room, mut digests) = (vec![[0.0; 3]; scene.cells], vec![]);
        endure(scene, tissue, &mut room, |_, digest| digests.push(digest))?;
        Ok(digests)
    }
}

// REQ-ENE-01, REQ-SMP-03
#[test]
fn every_scene_stays_finite_and_its_level_never_rises_by_itself() {
    // The level of `euler` is the energy of its last pass, one step behind.
    for scene in SCENES.into_iter().filter(|scene| scene.scheme != "euler") {
        for &tier in scene.tiers {
            let digests = stage(scene.name, tier, Endure).unwrap();
            let digests = digests.unwrap_or_else(|why| panic!("{} {tier:?}: {why}", scene.name));
            assert_eq!(digests.len(), STATES.len(), "{} {tier:?}", scene.name);
        }
    }
}
