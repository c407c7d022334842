//! The edge of a blade: a row of samples, each of which presses on a point of the tissue.
//!
//! A sample in the tissue has a front: the point of the material up to which it has cut. With q the distance
//! of the sample beyond its front, along the direction in which the blade cuts, w the length of edge that it
//! stands for and J the tissue's toughness at the front, the term is
//!
//! ```text
//! E_b = 0                              where q <= 0: the edge is drawn back in its cut
//!       k q^2 / 2                      where k q <= J w
//!       J w q - (J w)^2 / (2 k)        beyond: the front moves on
//! ```
//!
//! The force is k q against the direction, at most J w: the hand pays the toughness for each area that the
//! fronts pass. Across its plane and along the edge a blade has no force: it has no sides.
//!
//! **The theorem.** The direction is fixed in a tick, and so E_b is a function of q that curves upwards by at
//! most k. The front is a point of a tetrahedron, a mean of its corners with weights between 0 and 1, so the
//! cells' bounds grow by k times their weight.

use super::scissors::Crossing;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::kept::kept;
#[cfg(feature = "cut")]
use crate::number::sqrt::sqrt;
use crate::number::turn::{Turn, turned};

/// Edges of a tool: none in a kernel that does not cut, so that its tools have no place for one.
const EDGES: usize = cfg!(feature = "cut") as usize;
/// Most samples of an edge; none in a kernel that does not cut.
pub(crate) const EDGE_SAMPLES: usize = 16 * EDGES;
/// Bytes that the edge of a blade takes in a [`ToolState`](crate::ToolState); 0 in a kernel that does not cut.
pub const EDGE_BYTES: usize = size_of::<Edge>();
/// The tetrahedron of a sample without a front.
const NOWHERE: u32 = u32::MAX;

kept! {
    /// A sample of an edge, with its front.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct EdgeSample {
        /// Position in the tool's frame [mean link lengths].
        own: [f32; 3],
        /// Position in the body's frame.
        pub place: [f32; 3],
        /// Length of edge that it stands for [mean link lengths].
        pub length: f32,
        /// The tetrahedron of the front.
        pub tetrahedron: u32,
        /// Its cells, and their weights at the front.
        pub corners: [u16; 4],
        pub weights: [f32; 4],
        /// The front in the body at rest [mean link lengths].
        pub rest: [f32; 3],
        /// k [2 `k_ref`].
        pub stiffness: f32,
        /// J w, the largest force; 0 where the tissue before it is open.
        pub limit: f32,
    }
}

kept! {
    /// A row of samples.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Row {
        samples: [EdgeSample; EDGE_SAMPLES],
        count: usize,
        /// Direction in which it cuts, and its own, in the tool's frame.
        own: [[f32; 3]; 2],
        /// The same in the body's frame.
        forward: [f32; 3],
        along: [f32; 3],
        /// Where it lies along the direction in which it cuts.
        crossing: Crossing,
    }
}

kept! {
    /// The edge of a tool.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct Edge([Row; EDGES]);
}

/// Force and energy of a sample.
pub(crate) struct Pressed {
    /// Force on the tissue at the front.
    pub force: [f32; 3],
    pub energy: f32,
}

impl EdgeSample {
    /// No sample.
    const NONE: Self = Self {
        own: [0.0; 3],
        place: [0.0; 3],
        length: 0.0,
        tetrahedron: NOWHERE,
        corners: [0; 4],
        weights: [0.0; 4],
        rest: [0.0; 3],
        stiffness: 0.0,
        limit: 0.0,
    };

    /// Returns true if it has a front.
    pub fn is_in(&self) -> bool {
        self.tetrahedron != NOWHERE
    }

    /// Takes it out of the tissue.
    pub fn leave(&mut self) {
        self.tetrahedron = NOWHERE;
    }

    /// Present position of the front.
    pub fn front(&self, at: &impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let corners = self.corners.iter().zip(self.weights);
        corners.fold([0.0; 3], |sum, (&cell, weight)| add(sum, scale(weight, at(cell.into()))))
    }

    /// Its force and energy; `None` without a front, where it is drawn back, and where it is free.
    #[inline(always)]
    pub fn press(&self, forward: [f32; 3], at: &impl Fn(usize) -> [f32; 3]) -> Option<Pressed> {
        if !self.is_in() {
            return None;
        }
        let (k, limit) = (self.stiffness, self.limit);
        let q = dot(forward, sub(self.place, self.front(at)));
        let push = k * q;
        let is_below = push <= limit;
        let (force, energy) =
            if is_below { (push, 0.5 * push * q) } else { (limit, limit * (q - 0.5 * limit / k)) };
        let force = scale(force, forward);
        (q > 0.0 && limit > 0.0).then_some(Pressed { force, energy })
    }
}

impl Row {
    /// No samples.
    const NONE: Self = Self {
        samples: [EdgeSample::NONE; EDGE_SAMPLES],
        count: 0,
        own: [[0.0; 3]; 2],
        forward: [0.0; 3],
        along: [0.0; 3],
        crossing: Crossing::NONE,
    };

    /// All bits 0.
    const EMPTY: Self = Self {
        samples: [EdgeSample { tetrahedron: 0, ..EdgeSample::NONE }; EDGE_SAMPLES],
        ..Self::NONE
    };
}

impl Edge {
    /// No edge.
    pub const NONE: Self = Self([Row::NONE; EDGES]);

    /// All bits 0, for memory that is never read.
    pub const EMPTY: Self = Self([Row::EMPTY; EDGES]);

    /// An edge of this half length along x of a frame, which cuts towards -z; the frame lies at `centre`, turned,
    /// in the tool's [mean link lengths]. Its samples are half a link apart if there are enough.
    pub fn new(half: f32, centre: [f32; 3], turn: Turn) -> Self {
        let most = EDGE_SAMPLES.saturating_sub(1) as u16;
        let wished = 4.0 * half;
        let mut spaces = if wished < f32::from(most) { wished as u16 } else { most };
        spaces += u16::from(f32::from(spaces) < wished && spaces < most);
        let space = 2.0 * half / f32::from(spaces);
        let along = turned(turn, [1.0, 0.0, 0.0]);
        let own = [turned(turn, [0.0, 0.0, -1.0]), along];
        Self([(); EDGES].map(|()| {
            let mut row = Row { own, ..Row::NONE };
            for (at, slot) in (0..=spaces).zip(&mut row.samples) {
                let is_end = at == 0 || at == spaces;
                slot.own = add(centre, scale(space * f32::from(at) - half, along));
                slot.length = if is_end { 0.5 * space } else { space };
                row.count += 1;
            }
            row
        }))
    }

    /// The same edge between the blades of closed scissors.
    pub fn between(mut self, blades: Crossing) -> Self {
        for row in &mut self.0 {
            row.crossing = blades;
        }
        self
    }

    /// The edge of a tool at a pose.
    pub fn placed(&self, pivot: [f32; 3], turn: Turn) -> Self {
        let mut edge = *self;
        for row in &mut edge.0 {
            [row.forward, row.along] = row.own.map(|of| turned(turn, of));
            let ahead = row.crossing.at;
            let ahead = row.crossing.is_any().then(|| scale(ahead, row.forward));
            for sample in row.samples.iter_mut().take(row.count) {
                let place = add(pivot, turned(turn, sample.own));
                sample.place = ahead.map_or(place, |ahead| add(place, ahead));
            }
        }
        edge
    }

    /// Where it lies between the blades of scissors; [`Crossing::NONE`] for a blade, and without an edge.
    pub fn crossing(&self) -> Crossing {
        self.0.first().map_or(Crossing::NONE, |row| row.crossing)
    }

    /// The same to be changed; `None` without scissors.
    pub fn crossing_mut(&mut self) -> Option<&mut Crossing> {
        self.0.first_mut().map(|row| &mut row.crossing).filter(|crossing| crossing.is_any())
    }

    /// Motion of the crossing in this tick.
    pub fn slid(&self) -> [f32; 3] {
        scale(self.crossing().slid, self.forward())
    }

    /// Force of the tissue on it in the direction in which it cuts.
    pub fn push(&self, at: &impl Fn(usize) -> [f32; 3]) -> f32 {
        let forward = self.forward();
        let pressed = self.fronts().filter_map(|sample| sample.press(forward, at));
        pressed.fold(0.0, |sum, pressed| sum - dot(pressed.force, forward))
    }

    /// Direction in which it cuts.
    #[inline(always)]
    pub fn forward(&self) -> [f32; 3] {
        self.0.first().map_or([0.0; 3], |row| row.forward)
    }

    /// Its own direction.
    #[cfg(feature = "cut")]
    pub fn along(&self) -> [f32; 3] {
        self.0.first().map_or([0.0; 3], |row| row.along)
    }

    #[inline(always)]
    pub fn samples(&self) -> &[EdgeSample] {
        self.0.first().and_then(|row| row.samples.get(..row.count)).unwrap_or(&[])
    }

    pub fn samples_mut(&mut self) -> &mut [EdgeSample] {
        let rows = self.0.first_mut();
        rows.and_then(|row| row.samples.get_mut(..row.count)).unwrap_or_default()
    }

    /// Takes all samples out of the tissue.
    pub fn leave(&mut self) {
        self.samples_mut().iter_mut().for_each(EdgeSample::leave);
    }

    /// The samples that have a front.
    pub fn fronts(&self) -> impl Iterator<Item = &EdgeSample> {
        self.samples().iter().filter(|sample| sample.is_in())
    }

    /// Largest distance of a sample from the tool's position.
    #[cfg(feature = "cut")]
    pub fn reach(&self, pivot: [f32; 3]) -> f32 {
        self.samples().iter().fold(0.0, |most, sample| {
            let arm = sub(sample.place, pivot);
            let length = sqrt(dot(arm, arm));
            if length > most { length } else { most }
        })
    }

    /// Energy of all samples.
    #[cfg(feature = "cut")]
    pub fn energy(&self, at: &impl Fn(usize) -> [f32; 3]) -> f32 {
        let pressed = self.samples().iter().filter_map(|sample| sample.press(self.forward(), at));
        pressed.fold(0.0, |sum, pressed| sum + pressed.energy)
    }
}

#[cfg(all(test, feature = "cut"))]
mod tests {
    use super::*;

    #[test]
    fn the_force_is_the_slope_of_the_energy_and_no_more_than_the_limit() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let sample = EdgeSample {
            tetrahedron: 3,
            corners: [0, 1, 2, 3],
            weights: [0.25; 4],
            stiffness: 2.0,
            limit: 0.3,
            ..EdgeSample::NONE
        };
        let forward = [0.0, 0.0, -1.0];
        let at = |cell: usize| corners[cell];
        let by = |z: f32| EdgeSample { place: [9.0, 7.0, z], ..sample }.press(forward, &at);
        for z in [0.2_f32, 0.11, 0.0, -2.0] {
            let (here, step) = (by(z).unwrap(), 1.0e-2);
            let slope =
                (by(z + step).unwrap().energy - by(z - step).unwrap().energy) / (2.0 * step);
            assert!((slope - here.force[2]).abs() < 2e-3, "{z}: {slope} {:?}", here.force);
            assert!(here.force[2] >= -0.3 && here.force[0] == 0.0);
        }
        // Drawn back, and without a front.
        assert!(by(0.3).is_none());
        assert!(EdgeSample { tetrahedron: NOWHERE, ..sample }.press(forward, &at).is_none());
    }

    #[test]
    fn samples_share_the_edge() {
        for (half, count) in [(0.1, 2), (0.5, 3), (0.6, 4), (3.0, 13), (99.0, 16)] {
            let edge = Edge::new(half, [1.0, 2.0, 3.0], Turn::NONE);
            let (first, last) = (edge.samples()[0], edge.samples()[count - 1]);
            assert_eq!(edge.samples().len(), count);
            assert!((first.own[0] - 1.0 + half).abs() < 1e-5 * half);
            assert!((last.own[0] - 1.0 - half).abs() < 1e-5 * half && last.own[2] == 3.0);
            let length: f32 = edge.samples().iter().map(|sample| sample.length).sum();
            assert!((length - 2.0 * half).abs() < 1e-5 * half);
        }
        let quarter = Turn::new([0.5_f32.sqrt(), 0.0, 0.5_f32.sqrt(), 0.0]).unwrap();
        let edge = Edge::new(1.0, [0.0; 3], Turn::NONE).placed([5.0, 0.0, 0.0], quarter);
        // Turned about y by 90 degrees: x to -z, -z to -x.
        let near = |a: [f32; 3], b: [f32; 3]| sub(a, b).iter().all(|x| x.abs() < 1e-6);
        assert!(near(edge.along(), [0.0, 0.0, -1.0]) && near(edge.forward(), [-1.0, 0.0, 0.0]));
        assert!(near(edge.samples()[0].place, [5.0, 0.0, 1.0]));
    }
}
