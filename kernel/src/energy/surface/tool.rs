//! A tool and its contact, and the list of the chosen ones.

use super::edge::{Edge, EdgeSample};
use super::meeting::Meeting;
use super::proxy::{PARTS_MAX, Proxy};
use super::solid::Solid;
use crate::number::kept::kept;
use crate::number::turn::Turn;

kept! {
    /// A tool and what the tissue does to it.
    #[derive(Debug, Clone, Copy)]
    pub struct ToolState {
        pub(crate) proxy: Proxy,
        /// True if it is engaged.
        pub(crate) is_in: bool,
        /// Its contact after the last sweeps.
        pub(crate) met: Meeting,
        /// True if that contact is at the points of the next pass, false if it is at the published ones.
        pub(crate) is_ahead: bool,
        /// Its displacement in this tick, and its rotation as axis times angle.
        pub(crate) way: [f32; 3],
        /// The displacement in the last tick, with that of the crossing of scissors.
        pub(crate) way_before: [f32; 3],
        pub(crate) spin: [f32; 3],
        /// Its target position and rotation.
        pub(crate) target: [f32; 3],
        pub(crate) target_turn: Turn,
        /// Unit vector towards the target when the proxy first gave way, and how many times it did since.
        pub(crate) held_back: [f32; 3],
        pub(crate) times: u8,
        /// True if it gave way in the last tick.
        pub(crate) gives_way: bool,
        /// The proxy's position when it last gave way.
        pub(crate) held_at: [f32; 3],
        /// Share of the release time that its grips lose per tick.
        pub(crate) fade: f32,
        /// Work of its move in this tick, internal units.
        pub(crate) work: f32,
    }
}

impl ToolState {
    /// No tool.
    pub const NONE: Self = Self {
        proxy: Proxy::NONE,
        is_in: false,
        met: Meeting::NONE,
        is_ahead: false,
        way: [0.0; 3],
        way_before: [0.0; 3],
        spin: [0.0; 3],
        target: [0.0; 3],
        target_turn: Turn::NONE,
        held_back: [0.0; 3],
        times: 0,
        gives_way: false,
        held_at: [0.0; 3],
        fade: 0.0,
        work: 0.0,
    };

    /// All bits 0, for static memory that takes up no flash: choosing a tool overwrites it.
    pub(crate) const EMPTY: Self = Self {
        proxy: Proxy::EMPTY,
        met: Meeting { nearest: 0.0, ..Meeting::NONE },
        target_turn: Turn::EMPTY,
        ..Self::NONE
    };
}

/// The chosen tools; those not engaged have no contact.
#[derive(Clone, Copy)]
pub(crate) struct Proxies<'a>(pub &'a [ToolState]);

impl<'a> Proxies<'a> {
    /// Part `index`: its tool is the index over [`PARTS_MAX`].
    #[inline(always)]
    pub fn part(&self, index: u8) -> Option<&'a Solid> {
        let index = usize::from(index);
        self.0.get(index / PARTS_MAX)?.proxy.parts().get(index % PARTS_MAX)
    }

    /// The edges of engaged blades.
    #[inline(always)]
    pub fn edges(&self) -> impl Iterator<Item = &'a Edge> + use<'a> {
        self.0.iter().filter(|tool| tool.is_in).map(|tool| &tool.proxy.edge)
    }

    /// The samples of engaged blades that have a front.
    #[inline(always)]
    pub fn fronts(&self) -> impl Iterator<Item = &'a EdgeSample> + use<'a> {
        self.edges().flat_map(Edge::fronts)
    }
}
