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
    ("plane4_euler", Tier::F32, 16364, 0x476faa78),
    ("plane4_euler", Tier::Fixed, 16364, 0xf95218b0),
    ("plane4_euler", Tier::F64, 30488, 0x85fb1809),
    ("plane4_gauss_seidel", Tier::F32, 9324, 0x27420389),
    ("plane8_rkl2", Tier::F32, 37568, 0xd42a69b0),
    ("plane8_track", Tier::F32, 30524, 0x495f165d),
    ("plane8_track", Tier::Fixed, 30524, 0xc44ae83f),
    ("plane8_track", Tier::F64, 58784, 0xeb0ef967),
    ("box7_track", Tier::F32, 18924, 0xfbcbe022),
    ("box7_track", Tier::Fixed, 17964, 0x8c3ec50e),
    ("box7_track", Tier::F64, 33668, 0xb47a25dd),
    ("organ500_track", Tier::F32, 36220, 0x49e92dd5),
    ("organ500_track", Tier::Fixed, 34300, 0x15575ba3),
    ("organ500_track", Tier::F64, 66320, 0x109bcd14),
    ("organ500_predict", Tier::F32, 60208, 0x635e59ed),
    ("tissue6_track", Tier::F32, 49244, 0x6de68a63),
    ("varied300_track", Tier::F32, 22380, 0xa6777abf),
    ("varied300_track", Tier::Fixed, 21420, 0xdeac17e4),
    ("varied300_track", Tier::F64, 40580, 0xae554bc9),
    ("varied300_rkl1", Tier::F32, 21440, 0xfb108e09),
    ("varied300_gauss_seidel", Tier::F32, 7052, 0x76f6a3ae),
    ("touch6_predict", Tier::F32, 72008, 0xb1a017c1),
    ("touch6_tools", Tier::F32, 57720, 0x445844d3),
];

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
