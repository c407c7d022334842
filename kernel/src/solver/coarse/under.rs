//! The samples of a triangle under a tool, taken as one, for an elastic coarse level.

use crate::energy::surface::{
    Anchor, EdgeSample, NearTriangle, PinSample, Proxies, Solid, each_met,
};
use crate::model::coarse_basis::CoarseBasis;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::Eight;

/// Basis functions at the corners of a triangle, or of a tetrahedron in a kernel that cuts.
pub(super) const OF_SAMPLE: usize = if cfg!(feature = "cut") { 48 } else { 24 };
/// Samples this near to a part count as touched [radii]: the tissue may move into the part within the tick,
/// and a direction that ignored them would press them in as if there were no contact.
const COMING: f32 = 0.2;

/// The samples of a triangle under a tool, taken as one.
#[derive(Clone, Copy)]
pub(super) struct Mean {
    /// Stiffness along the normal, and perpendicular to it; 0 without contact.
    pub stiffness: [f32; 2],
    pub normal: [f32; 3],
    /// Stiffness at each corner.
    shares: [f32; 3],
}

/// The same with basis functions in place of corners.
pub(super) struct OneSample {
    pub mean: Mean,
    /// Basis functions with their weights at the sample.
    functions: [(u16, f32); OF_SAMPLE],
    count: usize,
}

/// The contacts of tools in a tick, and the pins.
#[derive(Clone, Copy)]
pub(crate) struct Under<'a> {
    pub tools: Proxies<'a>,
    pub near: &'a [NearTriangle],
    pub anchors: &'a [Anchor],
    pub pins: &'a [PinSample],
}

fn sum(shares: [f32; 3]) -> f32 {
    shares.into_iter().fold(0.0, |sum, share| sum + share)
}

impl Mean {
    pub const NONE: Self = Self { stiffness: [0.0; 2], normal: [0.0; 3], shares: [0.0; 3] };

    pub fn of(
        under: Under<'_>,
        near: &NearTriangle,
        place: &impl Fn(usize) -> [f32; 3],
    ) -> Option<Self> {
        let solid = under.tools.part(near.of)?;
        let solid = &Solid { radius: (1.0 + COMING) * solid.radius, ..*solid };
        // Sum stiffness, normal and corner shares over the samples.
        let (mut shares, mut way) = ([0.0; 3], [0.0; 3]);
        let [mut along, mut across] = [0.0; 2];
        each_met(
            solid,
            near,
            under.anchors,
            near.corners.map(|cell| place(cell.into())),
            |sample| {
                let k = sample.stiffness;
                if sample.depth > 0.0 {
                    along += k;
                    way = add(way, scale(k * sample.depth, sample.normal));
                }
                if sample.is_stuck {
                    across += k;
                }
                shares = add(shares, scale(k, sample.weights));
            },
        );
        // Take the mean normal and the larger stiffness.
        let whole = sum(shares);
        let length = sqrt(dot(way, way));
        // A grip without contact has no normal, and the same stiffness in all directions.
        let (normal, along) = match length > 0.0 {
            true => (scale(1.0 / length, way), if along > across { along } else { across }),
            false => ([0.0; 3], across),
        };
        let is_met = whole > 0.0 && along > 0.0;
        is_met.then_some(Self { stiffness: [along, across], normal, shares })
    }

    pub fn to_block(self) -> Eight {
        let ([along, across], [x, y, z], [a, b, c]) = (self.stiffness, self.normal, self.shares);
        [along, across, x, y, z, a, b, c]
    }

    pub fn of_block(block: Eight) -> Self {
        let [along, across, x, y, z, a, b, c] = block;
        Self { stiffness: [along, across], normal: [x, y, z], shares: [a, b, c] }
    }
}

impl OneSample {
    pub fn of(basis: &CoarseBasis<'_>, near: &NearTriangle, mean: Mean) -> Self {
        let whole = sum(mean.shares);
        Self::at(basis, near.corners.iter().zip(mean.shares), whole, mean)
    }

    /// A sample of an edge with this direction, as if its front stayed: a front that moves on is softer.
    pub fn of_edge(basis: &CoarseBasis<'_>, sample: &EdgeSample, forward: [f32; 3]) -> Self {
        let mean = Mean { stiffness: [sample.stiffness, 0.0], normal: forward, ..Mean::NONE };
        Self::at(basis, sample.corners.iter().zip(sample.weights), 1.0, mean)
    }

    /// The pinned samples of one triangle.
    pub fn of_pins(basis: &CoarseBasis<'_>, pins: &[PinSample]) -> Self {
        let (mut shares, corners) = ([0.0; 3], pins.first().map_or([0; 3], |pin| pin.corners));
        for pin in pins {
            shares = add(shares, scale(pin.stiffness(), pin.weights));
        }
        let whole = sum(shares);
        let mean = Mean { stiffness: [whole; 2], shares, ..Mean::NONE };
        Self::at(basis, corners.iter().zip(shares), whole, mean)
    }

    /// A sample between cells, with the share of each in the whole.
    fn at<'a>(
        basis: &CoarseBasis<'_>,
        shares: impl Iterator<Item = (&'a u16, f32)>,
        whole: f32,
        mean: Mean,
    ) -> Self {
        let mut one = Self { mean, functions: [(0, 0.0); OF_SAMPLE], count: 0 };
        for (&cell, share) in shares {
            // Corners in one box have the same functions in the same order.
            let mut next = 0;
            let cell = usize::from(cell);
            for (function, weight) in basis.row_of(cell).chain(basis.sides_of(cell)) {
                next = 1 + one.add(function as u16, weight * share / whole, next);
            }
        }
        one
    }

    /// K d.
    pub fn resist(&self, d: [f32; 3]) -> [f32; 3] {
        let Mean { stiffness: [along, across], normal, .. } = self.mean;
        let inward = scale(dot(normal, d), normal);
        add(scale(along, inward), scale(across, sub(d, inward)))
    }

    /// Adds a weight of a basis function, which is at place `guess` or elsewhere. Returns its place.
    fn add(&mut self, function: u16, weight: f32, guess: usize) -> usize {
        let taken = self.functions.get_mut(..self.count).unwrap_or_default();
        let is_guess = taken.get(guess).is_some_and(|(of, _)| *of == function);
        let known = || taken.iter().position(|(of, _)| *of == function);
        let place = if is_guess { guess } else { known().unwrap_or(self.count) };
        if let Some((_, sum)) = taken.get_mut(place) {
            *sum += weight;
        } else if let Some(slot) = self.functions.get_mut(place) {
            *slot = (function, weight);
            self.count += 1;
        }
        place
    }

    pub fn functions(&self) -> &[(u16, f32)] {
        self.functions.get(..self.count).unwrap_or(&[])
    }
}
