//! Every scene goes on from a snapshot to its golden digest, and its snapshot has the same bytes on
//! every target.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{Dynamics, TissueMut};
use chaincell_scenes::{Act, Run, SCENES, Scene, TICKS, Tier, golden, stage};
use crc::{CRC_32_ISO_HDLC, Crc};

/// Ticks before the snapshot.
const BEFORE: u32 = 37;

/// Bytes of the snapshot and their CRC-32, and the digest in the end.
struct GoesOn;

impl Act for GoesOn {
    type Output = (usize, u32, u64);

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        run.play(BEFORE, |_, _| {});
        let mut bytes = vec![0; run.snapshot_bytes().unwrap()];
        assert_eq!(run.save(&mut bytes), Ok(bytes.len()));
        run.restore(&bytes).unwrap();
        run.play(TICKS[0] - BEFORE, |_, _| {});
        (bytes.len(), Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes), run.digest())
    }
}

/// Scene, numbers, bytes and CRC-32 of its snapshot. A change of what is kept changes them on purpose:
/// the test prints the new lines.
#[rustfmt::skip]
const SNAPSHOTS: &[(&str, Tier, usize, u32)] = &[
    ("plane4_euler", Tier::F32, 16368, 0xe5cc17f4),
    ("plane4_euler", Tier::Fixed, 16368, 0xd2d70251),
    ("plane8_rkl2", Tier::F32, 37572, 0x84bd02f0),
    ("plane8_track", Tier::F32, 30532, 0x8aa57675),
    ("plane8_track", Tier::Fixed, 30532, 0x1d7be0b0),
    ("box7_track", Tier::F32, 18932, 0x3f18dec3),
    ("box7_track", Tier::Fixed, 17972, 0x95572f02),
    ("organ500_track", Tier::F32, 36228, 0x4eec913d),
    ("organ500_track", Tier::Fixed, 34308, 0x49b3ba27),
    ("organ500_predict", Tier::F32, 60220, 0x32f1ec04),
    ("tissue6_track", Tier::F32, 49252, 0xde878418),
    ("varied300_track", Tier::F32, 22388, 0xff03424f),
    ("varied300_track", Tier::Fixed, 21428, 0x2f7c15d3),
    ("touch6_predict", Tier::F32, 72020, 0x58d92913),
    ("touch6_tools", Tier::F32, 66248, 0x1fa5472c),
];

// REQ-BIT-09
#[test]
fn every_scene_goes_on_from_the_same_bytes() {
    let mut lines = String::new();
    let mut all = Vec::new();
    for scene in SCENES {
        for &tier in scene.tiers {
            let (bytes, crc, digest) = stage(scene.name, tier, GoesOn).unwrap();
            assert_eq!(digest, golden(scene, tier, TICKS[0]).unwrap().digest, "{}", scene.name);
            lines += &format!("    (\"{}\", Tier::{tier:?}, {bytes}, {crc:#010x}),\n", scene.name);
            all.push((scene.name, tier, bytes, crc));
        }
    }
    assert!(all == SNAPSHOTS, "this gives\n{lines}");
}
