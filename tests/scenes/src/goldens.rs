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
    of("plane4_euler", Tier::F32, 100, 0x35dc91a7e014f42c, 3200),
    of("plane4_euler", Tier::F32, 2000, 0xa630825121961fdc, 64000),
    of("plane4_euler", Tier::Fixed, 100, 0xccec4bafbf412fe4, 3200),
    of("plane4_euler", Tier::Fixed, 2000, 0x65a86a907d7abdea, 64000),
    of("plane8_rkl2", Tier::F32, 100, 0xa834bb48af62c358, 3200),
    of("plane8_rkl2", Tier::F32, 2000, 0x527d0d1552b08959, 64000),
    of("plane8_track", Tier::F32, 100, 0xd155b57d090ec74c, 3200),
    of("plane8_track", Tier::F32, 2000, 0xf59a0e5a1431c6b6, 64000),
    of("plane8_track", Tier::Fixed, 100, 0x3d5c8aa74c6f8c18, 3200),
    of("plane8_track", Tier::Fixed, 2000, 0x6774b2e574d4f801, 64000),
    of("box7_track", Tier::F32, 100, 0xa74c0c11a8d97efa, 3200),
    of("box7_track", Tier::F32, 2000, 0x18a78d2afdd50a98, 64000),
    of("box7_track", Tier::Fixed, 100, 0x07d6b9d5257786b8, 3200),
    of("box7_track", Tier::Fixed, 2000, 0xae774b227dc119a6, 64000),
    of("organ500_track", Tier::F32, 100, 0x1fd84ec967945258, 3200),
    of("organ500_track", Tier::F32, 2000, 0x9aa58f2a75108164, 64000),
    of("organ500_track", Tier::Fixed, 100, 0xadfb2fb2722982e6, 3200),
    of("organ500_track", Tier::Fixed, 2000, 0x6a77f5b87c9f6c1c, 64000),
    of("organ500_predict", Tier::F32, 100, 0xbb0c5dbcbad1a66c, 3200),
    of("organ500_predict", Tier::F32, 2000, 0x16fd31f7558de5b3, 64000),
    of("tissue6_track", Tier::F32, 100, 0x0b1c7497de2669f2, 3200),
    of("tissue6_track", Tier::F32, 2000, 0x14001eb21033757a, 64000),
    of("varied300_track", Tier::F32, 100, 0x41f2302e11f1d987, 3200),
    of("varied300_track", Tier::F32, 2000, 0xbd61a86ca3ace066, 64000),
    of("varied300_track", Tier::Fixed, 100, 0x4d107ab10e97bf33, 3200),
    of("varied300_track", Tier::Fixed, 2000, 0x9092da1bd06a6116, 64000),
    of("touch6_predict", Tier::F32, 100, 0xbad514c6cd9f626c, 3200),
    of("touch6_predict", Tier::F32, 2000, 0x688440aa3b118714, 64000),
    of("touch6_tools", Tier::F32, 100, 0xc6ac318f9df192ac, 3200),
    of("touch6_tools", Tier::F32, 2000, 0x505a875aaca20c58, 64000),
];
