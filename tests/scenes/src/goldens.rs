//! What must come out, on every target. A failing test prints the lines to put here where the
//! arithmetic changes on purpose.

use crate::{Scene, Tier};

/// What a scene's first ticks digest to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Golden {
    /// Name of the scene.
    pub scene: &'static str,
    /// Number type.
    pub tier: Tier,
    /// Ticks from rest on.
    pub ticks: u32,
    /// Digest after them.
    pub digest: u64,
    /// Bytes digested.
    pub bytes: u64,
}

/// Ticks for which goldens stand here.
pub const TICKS: [u32; 2] = [100, 2000];

/// The golden of a scene, `None` where none stands here.
#[must_use]
pub fn golden(scene: &Scene, tier: Tier, ticks: u32) -> Option<&'static Golden> {
    GOLDENS
        .iter()
        .find(|golden| (golden.scene, golden.tier, golden.ticks) == (scene.name, tier, ticks))
}

const fn of(scene: &'static str, tier: Tier, ticks: u32, digest: u64, bytes: u64) -> Golden {
    Golden { scene, tier, ticks, digest, bytes }
}

/// The table.
#[rustfmt::skip]
pub static GOLDENS: &[Golden] = &[
    of("plane4_euler", Tier::F32, 100, 0x59a87fd7858911df, 3200),
    of("plane4_euler", Tier::F32, 2000, 0x9c8d176a795c9cae, 64000),
    of("plane4_euler", Tier::Fixed, 100, 0x5b8c72abf96d7eb5, 3200),
    of("plane4_euler", Tier::Fixed, 2000, 0xc077a2b20fc378ad, 64000),
    of("plane8_rkl2", Tier::F32, 100, 0x832cdd25ff8ee841, 3200),
    of("plane8_rkl2", Tier::F32, 2000, 0xcc9dc900d36841cd, 64000),
    of("plane8_track", Tier::F32, 100, 0x51a71312531ead4a, 3200),
    of("plane8_track", Tier::F32, 2000, 0x91e304d07a86b3af, 64000),
    of("plane8_track", Tier::Fixed, 100, 0xe06ebdc2f330c0e9, 3200),
    of("plane8_track", Tier::Fixed, 2000, 0x7dba2b0428288d24, 64000),
    of("box7_track", Tier::F32, 100, 0xa9c3ec8462971dbf, 3200),
    of("box7_track", Tier::F32, 2000, 0x72148e1085750b5c, 64000),
    of("box7_track", Tier::Fixed, 100, 0x8a5d485f9c4ee0e9, 3200),
    of("box7_track", Tier::Fixed, 2000, 0xcd1b0b8e7da03f11, 64000),
    of("organ500_track", Tier::F32, 100, 0x485e62ece90eaf73, 3200),
    of("organ500_track", Tier::F32, 2000, 0xe372470bc071f143, 64000),
    of("organ500_track", Tier::Fixed, 100, 0x9b796d1aab261bc6, 3200),
    of("organ500_track", Tier::Fixed, 2000, 0xd478356183700ec4, 64000),
    of("organ500_predict", Tier::F32, 100, 0xea64b104d72b78b1, 3200),
    of("organ500_predict", Tier::F32, 2000, 0x0712e1ef48f09be9, 64000),
    of("tissue6_track", Tier::F32, 100, 0x4c838afd1767b482, 3200),
    of("tissue6_track", Tier::F32, 2000, 0x8c05bec9c2fb38c1, 64000),
    of("varied300_track", Tier::F32, 100, 0x352f1d8db7b6fb3e, 3200),
    of("varied300_track", Tier::F32, 2000, 0xa6b84a2ff4aac5b2, 64000),
    of("varied300_track", Tier::Fixed, 100, 0x4923f5d3e2a81f66, 3200),
    of("varied300_track", Tier::Fixed, 2000, 0x8d5e555ea22989f5, 64000),
    of("touch6_predict", Tier::F32, 100, 0xd10edf1b3ef4b771, 3200),
    of("touch6_predict", Tier::F32, 2000, 0x4dd3670bf650b7ac, 64000),
    of("touch6_tools", Tier::F32, 100, 0x4d382cfbe902e217, 3200),
    of("touch6_tools", Tier::F32, 2000, 0x13f452f4fcea1a7c, 64000),
    of("relax6_track", Tier::F32, 100, 0xda391dffafd44f2e, 3200),
    of("relax6_track", Tier::F32, 2000, 0x92517fa3728cc0ba, 64000),
    of("blade5_track", Tier::F32, 100, 0xbf1d796ec447d60d, 3200),
    of("blade5_track", Tier::F32, 2000, 0x2e5e36e616400354, 64000),
    of("tear4_track", Tier::F32, 100, 0xcc8ec498d6482f55, 3200),
    of("tear4_track", Tier::F32, 2000, 0x294d413e4f66dd5d, 64000),
];
