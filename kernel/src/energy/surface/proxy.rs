//! A tool's proxy, which the tissue meets: the tool's parts at a pose.

use super::edge::Edge;
use super::solid::Solid;
use crate::number::cell::{add, sub};
use crate::number::kept::kept;
use crate::number::turn::{Turn, turned};

/// Most parts of a tool.
pub const PARTS_MAX: usize = 8;
/// Most tools.
pub const TOOLS_MAX: usize = 8;

kept! {
    /// A tool's parts in its frame and in the body's [mean link lengths].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct Proxy {
        shape: [Solid; PARTS_MAX],
        parts: [Solid; PARTS_MAX],
        count: usize,
        /// Position of the tool's frame.
        pub pivot: [f32; 3],
        pub turn: Turn,
        /// Share of the parts' radii.
        pub share: f32,
    } not stored {
        /// The edge of a blade, without samples for other tools; snapshots of bodies that can be cut have it.
        pub edge: Edge = Edge::NONE,
    }
}

impl Proxy {
    /// No tool.
    pub const NONE: Self = Self {
        shape: [Solid::NONE; PARTS_MAX],
        parts: [Solid::NONE; PARTS_MAX],
        count: 0,
        edge: Edge::NONE,
        pivot: [0.0; 3],
        turn: Turn::NONE,
        share: 0.0,
    };

    /// All bits 0, for memory that is never read.
    pub const EMPTY: Self = Self {
        shape: [Solid::EMPTY; PARTS_MAX],
        parts: [Solid::EMPTY; PARTS_MAX],
        turn: Turn::EMPTY,
        edge: Edge::EMPTY,
        ..Self::NONE
    };

    /// A tool of these parts alone, at the origin; parts beyond [`PARTS_MAX`] are ignored.
    #[cfg(test)]
    pub fn of(parts: impl Iterator<Item = Solid>) -> Self {
        Self::with_edge(parts, Edge::NONE)
    }

    /// A tool of these parts and an edge, at the origin; parts beyond [`PARTS_MAX`] are ignored.
    pub fn with_edge(parts: impl Iterator<Item = Solid>, edge: Edge) -> Self {
        let mut proxy = Self { edge, ..Self::NONE };
        for (slot, part) in proxy.shape.iter_mut().zip(parts) {
            *slot = part;
            proxy.count += 1;
        }
        proxy.at([0.0; 3], Turn::NONE, 1.0)
    }

    /// The tool at a pose, with a share of its radii.
    pub fn at(&self, pivot: [f32; 3], turn: Turn, share: f32) -> Self {
        let edge = self.edge.placed(pivot, turn);
        let mut proxy = Self { pivot, turn, share, edge, ..*self };
        for (part, shape) in proxy.parts.iter_mut().zip(&proxy.shape).take(proxy.count) {
            *part = shape.placed(pivot, turn).grown(share);
        }
        proxy
    }

    /// The tool with the edge of its scissors moved by a share of the way to its goal; [`Self::at`] places it.
    pub fn closed(&self, share: f32) -> Self {
        let mut proxy = *self;
        if let Some(crossing) = proxy.edge.crossing_mut() {
            crossing.go(share);
        }
        proxy
    }

    /// Returns true if it has no size, and so no contact.
    pub fn is_away(&self) -> bool {
        self.share <= 0.0
    }

    /// Its parts in the body's frame.
    pub fn parts(&self) -> &[Solid] {
        self.parts.get(..self.count).unwrap_or(&[])
    }

    /// Smallest full radius of a part.
    pub fn radius_min(&self) -> f32 {
        self.parts().iter().fold(f32::MAX, |r, of| if of.whole < r { of.whole } else { r })
    }

    /// Largest full radius of a part.
    pub fn radius_max(&self) -> f32 {
        self.parts().iter().fold(0.0, |r, of| if of.whole > r { of.whole } else { r })
    }

    /// Largest distance of a core's corner from the pivot: a rotation by a small angle moves no point of the
    /// cores by more than the angle times this. Half spaces are left out: they are unbounded, and the
    /// surface's distance counts for them.
    pub fn arm(&self) -> f32 {
        let shape = self.shape.get(..self.count).unwrap_or(&[]);
        shape.iter().fold(0.0, |most, part| {
            let [low, high] = part.core;
            let far = |of: [f32; 3]| of.into_iter().fold(0.0, |r, x| r + x.abs());
            let arm = far(part.centre) + far(low).max(far(high));
            if arm > most && arm.is_finite() { arm } else { most }
        })
    }

    /// Returns true if it has a half space.
    pub fn is_endless(&self) -> bool {
        let shape = self.shape.get(..self.count).unwrap_or(&[]);
        shape.iter().any(Solid::is_endless)
    }

    /// Converts a point from the body's frame to the tool's.
    pub fn in_tool(&self, point: [f32; 3]) -> [f32; 3] {
        turned(self.turn.back(), sub(point, self.pivot))
    }

    /// Converts a point from the tool's frame to the body's.
    pub fn in_body(&self, point: [f32; 3]) -> [f32; 3] {
        add(self.pivot, turned(self.turn, point))
    }
}
