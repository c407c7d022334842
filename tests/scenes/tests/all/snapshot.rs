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
    ("plane4_euler", Tier::F32, 16344, 0x7f5d7e3b),
    ("plane4_euler", Tier::Fixed, 16344, 0x492bd3b0),
    ("plane8_rkl2", Tier::F32, 37548, 0x00b48251),
    ("plane8_track", Tier::F32, 30508, 0x90b9ce03),
    ("plane8_track", Tier::Fixed, 30508, 0xcce69a29),
    ("box7_track", Tier::F32, 18908, 0xaebbf26b),
    ("box7_track", Tier::Fixed, 17948, 0x7b4d1aa2),
    ("organ500_track", Tier::F32, 36204, 0xadd9fac1),
    ("organ500_track", Tier::Fixed, 34284, 0x371c2483),
    ("organ500_predict", Tier::F32, 60196, 0x50b3812e),
    ("tissue6_track", Tier::F32, 33100, 0x13223999),
    ("varied300_track", Tier::F32, 22364, 0xe1cd8f3e),
    ("varied300_track", Tier::Fixed, 21404, 0x869f4844),
    ("touch6_predict", Tier::F32, 55908, 0x57ceee4c),
    ("touch6_tools", Tier::F32, 50176, 0xdf414f6b),
    ("relax6_track", Tier::F32, 59396, 0x21c80597),
    ("blade5_track", Tier::F32, 51252, 0x4c351ef4),
    ("tear4_track", Tier::F32, 34800, 0x4c407f5c),
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
