//! Pins in an image: cells on springs to points.

use super::COORDINATE_MAX;
use super::image::{ModelError, Sections, kind, params};
use super::layout::Layout;
use super::terms::{Keeps, TermData};

/// Kind of the section of pins, which only this crate's tests have.
pub(crate) const PINS: u32 = 0x7e57_0001;

/// The pins of a body, by ascending cell.
///
/// A pin of weight w has the energy w d^2 / 4, as a link has, with d the distance of its cell from its
/// anchor. Its map is the cell's position and its set is a point: L has w / 2 on the diagonal.
#[derive(Clone, Copy)]
pub(crate) struct Pins<'a>(&'a [[u32; 7]]);

/// A pin: a spring from a cell to an anchor, which may slip and give way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pin {
    pub cell: usize,
    /// Position of the anchor in the rest shape [mean link lengths from the body's centre].
    pub point: [f32; 3],
    /// k / `k_ref`.
    pub weight: f32,
    /// Largest distance between cell and anchor: beyond it the cell drags the anchor along, permanently
    /// [mean link lengths].
    pub slip_length: f32,
    /// Share of a tick's first distance by which the anchor gives way in that tick, below 1.
    pub give: f32,
}

impl Pin {
    fn of(&[cell, x, y, z, weight, slip_length, give]: &[u32; 7]) -> Self {
        let point = [x, y, z].map(f32::from_bits);
        let [weight, slip_length, give] = [weight, slip_length, give].map(f32::from_bits);
        Self { cell: cell as usize, point, weight, slip_length, give }
    }

    pub fn words(&self) -> [u32; 7] {
        let [x, y, z] = self.point.map(f32::to_bits);
        let [weight, slip, give] = [self.weight, self.slip_length, self.give].map(f32::to_bits);
        [self.cell as u32, x, y, z, weight, slip, give]
    }
}

impl<'a> Pins<'a> {
    pub const NONE: Self = Self(&[]);

    pub fn iter(self) -> impl Iterator<Item = Pin> + use<'a> {
        self.0.iter().map(Pin::of)
    }

    /// The pin of a cell.
    pub fn at(self, cell: usize) -> Option<Pin> {
        let at = self.0.binary_search_by_key(&cell, |&[cell, ..]| cell as usize).ok()?;
        self.0.get(at).map(Pin::of)
    }
}

/// Slip of an anchor, and its relaxation in this tick.
impl Keeps for Pins<'_> {
    const LASTING: usize = 6;
}

impl<'a> TermData<'a> for Pins<'a> {
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError> {
        Ok(Self(sections.optional(PINS)?.unwrap_or(&[])))
    }

    fn check(&self, layout: &Layout<'_>) -> Result<(), ModelError> {
        let mut next = 0;
        for (position, pin) in self.iter().enumerate() {
            let position = position as u32;
            if pin.cell < next || pin.cell >= layout.cells() {
                return Err(ModelError::Index(PINS, position));
            }
            next = pin.cell + 1;
            let is_near = pin.point.iter().all(|x| x.abs() <= COORDINATE_MAX);
            let is_spring = pin.weight > 0.0 && pin.weight.is_finite();
            if !(is_near && is_spring && pin.slip_length > 0.0 && (0.0..1.0).contains(&pin.give)) {
                return Err(ModelError::Value(PINS, position));
            }
            let mobility = layout.mobility.get(pin.cell).copied().unwrap_or(0.0);
            if mobility <= 0.0 {
                return Err(ModelError::Index(kind::MOBILITY, pin.cell as u32));
            }
            // A pin counts as a link to a fixed cell without other links.
            if (1.0 / mobility + pin.weight) * 0.5 > layout.degree_bound {
                return Err(ModelError::Parameter(params::DEGREE_BOUND as u32));
            }
        }
        Ok(())
    }

    fn add_bound(&self, cell: usize, sum: f32) -> f32 {
        self.at(cell).map_or(sum, |pin| sum + pin.weight)
    }

    fn rests(&self, layout: &Layout<'_>) -> bool {
        self.iter().all(|pin| pin.point == layout.rest_position(pin.cell))
    }

    fn keeps(&self) -> bool {
        !self.0.is_empty()
    }

    fn each_of_row(&self, cell: usize, visit: &mut impl FnMut(usize, f32)) {
        if let Some(pin) = self.at(cell) {
            visit(cell, 0.5 * pin.weight);
        }
    }
}
