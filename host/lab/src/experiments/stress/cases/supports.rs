//! Bodies that nothing holds, that fall apart, that cannot move.

use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::Case;
use crate::experiments::stress::cases::elements::press_and_disturb;
use chaincell_host::bake::BakeOptions;

pub const CASES: &[Case] = &[
    Case {
        name: "free-floating",
        checks: "nothing fixed: pressed, inverted, in one point",
        run: |scale, found| {
            let body = Body::new(cuboid(scale.nodes())?.floating(), &BakeOptions::default())?;
            press_and_disturb(scale, found, "floating", &body)
        },
    },
    Case {
        name: "disconnected",
        checks: "two parts, one of them floating, ten widths apart: the same",
        run: |scale, found| {
            let body = Body::new(cuboid(scale.nodes())?.twice(), &BakeOptions::default())?;
            press_and_disturb(scale, found, "two parts", &body)
        },
    },
    Case {
        name: "fully-fixed",
        checks: "nothing can move: a tool that holds no cell",
        run: |scale, found| {
            let body = Body::new(cuboid(scale.nodes())?.all_fixed(), &BakeOptions::default())?;
            press_and_disturb(scale, found, "fixed", &body)
        },
    },
];
