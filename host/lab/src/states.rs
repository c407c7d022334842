//! States that no tool brings a body to: turned over, in one place, far apart.

use chaincell_kernel::Model;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Most that a shaken coordinate is moved [mean link lengths].
const SHAKE: f32 = 0.3;

/// Where every cell is, from its place at rest [mean link lengths from the centre].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum State {
    /// As at rest: every link at the rim of a band of no width.
    Rest,
    /// Half as wide again: every link too long.
    Stretched,
    /// Every coordinate moved: links too long and too short in no order.
    Shaken,
    /// Mirrored at a plane.
    Mirrored,
    /// Turned inside out through the centre.
    Inverted,
    /// All in one plane.
    Flattened,
    /// All on one line.
    Line,
    /// All in one point, [`POINT`] or the centre.
    Coincident([f32; 3]),
    /// All in one point but for the first half of the cells.
    HalfCoincident,
    /// On a coarse grid: most cells share their place with others.
    Grid,
    /// At the centre but for less than the smallest normal number.
    Denormal,
    /// Anywhere within so many mean link lengths along each axis.
    Scattered(f32),
    /// Each cell in one of the other ways, scattered over so many mean link lengths.
    Mixed(f32),
}

/// A point apart from the centre and from all axes.
pub const POINT: [f32; 3] = [0.25, -0.5, 0.125];

/// The states that [`State::Mixed`] takes; scattered ones besides.
const MIXED: [State; 8] = [
    State::Rest,
    State::Stretched,
    State::Shaken,
    State::Inverted,
    State::Flattened,
    State::Coincident(POINT),
    State::Grid,
    State::Denormal,
];

impl State {
    /// Positions of all cells of a model; the same for the same seed.
    #[must_use]
    pub fn positions(self, model: &Model<'_>, seed: u64) -> Vec<[f32; 3]> {
        let mut random = Pcg64::seed_from_u64(seed);
        let cells = model.cells();
        (0..cells)
            .map(|cell| {
                let rest = model.rest_position(cell);
                if self == Self::HalfCoincident && 2 * cell < cells {
                    rest
                } else {
                    self.place(rest, &mut random)
                }
            })
            .collect()
    }

    /// The same with the fixed cells at rest.
    #[must_use]
    pub fn of_free_cells(self, model: &Model<'_>, seed: u64) -> Vec<[f32; 3]> {
        let mut positions = self.positions(model, seed);
        for &cell in model.fixed() {
            positions[usize::from(cell)] = model.rest_position(cell.into());
        }
        positions
    }

    fn place(self, rest: [f32; 3], random: &mut Pcg64) -> [f32; 3] {
        let [x, y, z] = rest;
        match self {
            Self::Rest => rest,
            Self::Stretched => rest.map(|x| 1.5 * x),
            Self::Shaken => rest.map(|x| x + within(SHAKE, random)),
            Self::Mirrored => [-x, y, z],
            Self::Inverted => rest.map(|x| -x),
            Self::Flattened => [x, y, 0.0],
            Self::Line => [x, 0.0, 0.0],
            Self::Coincident(point) => point,
            Self::HalfCoincident => POINT,
            Self::Grid => rest.map(|x| (x / 3.0).round() * 3.0),
            Self::Denormal => [0; 3].map(|_| f32::from_bits(random.next_u32() >> 9)),
            Self::Scattered(by) => [0; 3].map(|_| within(by, random)),
            Self::Mixed(by) => {
                let which = random.next_u32() as usize % (MIXED.len() + 1);
                MIXED.get(which).copied().unwrap_or(Self::Scattered(by)).place(rest, random)
            }
        }
    }
}

/// From -`by` to `by`; 0 where that is no range.
fn within(by: f32, random: &mut Pcg64) -> f32 {
    Uniform::new_inclusive(-by, by).map_or(0.0, |along| along.sample(random))
}

/// Random places of as many things as asked for, `by` mean link lengths around the centre along
/// each axis.
#[must_use]
pub fn scattered(seed: u64, count: usize, by: f32) -> Vec<[f32; 3]> {
    let mut random = Pcg64::seed_from_u64(seed);
    (0..count).map(|_| State::Scattered(by).place([0.0; 3], &mut random)).collect()
}
