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
    of("plane4_euler", Tier::F64, 100, 0xd9f0686264a42eb7, 3200),
    of("plane4_euler", Tier::F64, 2000, 0xc02801d65847c868, 64000),
    of("plane4_gauss_seidel", Tier::F32, 100, 0xb059beeb42d39b7e, 3200),
    of("plane4_gauss_seidel", Tier::F32, 2000, 0x61e8676b3e0ff2c3, 64000),
    of("plane8_rkl2", Tier::F32, 100, 0xa834bb48af62c358, 3200),
    of("plane8_rkl2", Tier::F32, 2000, 0x527d0d1552b08959, 64000),
    of("plane8_track", Tier::F32, 100, 0xe44afd93c88b38f8, 3200),
    of("plane8_track", Tier::F32, 2000, 0xc9b2d7e70c57e6fd, 64000),
    of("plane8_track", Tier::Fixed, 100, 0xb1b9a449f6cb4b7f, 3200),
    of("plane8_track", Tier::Fixed, 2000, 0x416448051dd0d0f1, 64000),
    of("plane8_track", Tier::F64, 100, 0x5f57fae6ee6d1104, 3200),
    of("plane8_track", Tier::F64, 2000, 0x1cf0b5ca8186c2bf, 64000),
    of("box7_track", Tier::F32, 100, 0x0e5db2c8d66b6ba4, 3200),
    of("box7_track", Tier::F32, 2000, 0xf44ce07cd97d5397, 64000),
    of("box7_track", Tier::Fixed, 100, 0x827180bff64249bf, 3200),
    of("box7_track", Tier::Fixed, 2000, 0xac92d811b39183e2, 64000),
    of("box7_track", Tier::F64, 100, 0x654dd2486d631951, 3200),
    of("box7_track", Tier::F64, 2000, 0xbd3000c22502acfa, 64000),
    of("organ500_track", Tier::F32, 100, 0x1fd84ec967945258, 3200),
    of("organ500_track", Tier::F32, 2000, 0x9aa58f2a75108164, 64000),
    of("organ500_track", Tier::Fixed, 100, 0xadfb2fb2722982e6, 3200),
    of("organ500_track", Tier::Fixed, 2000, 0x6a77f5b87c9f6c1c, 64000),
    of("organ500_track", Tier::F64, 100, 0x95de7e9fbb4be248, 3200),
    of("organ500_track", Tier::F64, 2000, 0xac5c8553d011faff, 64000),
    of("varied300_track", Tier::F32, 100, 0x41f2302e11f1d987, 3200),
    of("varied300_track", Tier::F32, 2000, 0xc216ac91101918b7, 64000),
    of("varied300_track", Tier::Fixed, 100, 0x4d107ab10e97bf33, 3200),
    of("varied300_track", Tier::Fixed, 2000, 0x9092da1bd06a6116, 64000),
    of("varied300_track", Tier::F64, 100, 0xf947cf6da417500a, 3200),
    of("varied300_track", Tier::F64, 2000, 0x98f1f8b6ce0d8523, 64000),
    of("varied300_rkl1", Tier::F32, 100, 0xaadc967e7866fe3f, 3200),
    of("varied300_rkl1", Tier::F32, 2000, 0xbba962b6b0160f11, 64000),
    of("varied300_gauss_seidel", Tier::F32, 100, 0xdabb0d8676246cf0, 3200),
    of("varied300_gauss_seidel", Tier::F32, 2000, 0xde2958adacf2f192, 64000),
];
