//! The coarse level: coarse functions (hats) over the rest shape, and the inverse of a matrix between them:
//! that of the Laplacian bound of links, or that of the elasticity of nodal shapes.
//!
//! See `chaincell_kernel::solver::coarse` for their use. The grid's spacing is about the same along all
//! axes, such that a whole number of boxes fits the body; functions that no free cell touches are left out.

use chaincell_kernel::image::{COARSE_MAX, NO_FUNCTION, kind};
use chaincell_kernel::parts::Parts;
use nalgebra::DMatrix;

use super::image::Sections;
use super::layout::{Link, OrderedCells};
use super::tissue::Shapes;
use crate::error::{Error, Result};

/// Most functions of a model by default: their product then takes about a quarter of a sweep of the paper's
/// liver.
const DEFAULT_MAX: usize = 400;
/// Smallest spacing by default \[mean link lengths\].
const SPACING_MIN: f64 = 2.5;
/// Largest spacing by default, beyond which a coarse level is of little use \[mean link lengths\].
const SPACING_MAX: f64 = 8.0;
/// Most functions of nodal shapes by default: the product on all axes together is nine times as large.
const ELASTIC_DEFAULT_MAX: usize = 160;
/// Their smallest spacing by default \[mean link lengths\].
const ELASTIC_SPACING_MIN: f64 = 4.5;
/// Their largest spacing \[mean link lengths\]: even a body of the most cells has few enough functions then.
const ELASTIC_SPACING_MAX: f64 = 64.0;
/// Fewest free cells for each of them.
const ELASTIC_CELLS_MIN: usize = 6;
/// Share of its diagonal that is added to the matrix before it is inverted, times the root of the
/// number of functions n. The kernel's product B g has errors of up to eps n |B| |g|; scaled to a
/// diagonal of 1, |B| is at most 1 / share and B g at least |g| / 4, so g . B g keeps above the
/// matrix's own c' A c if share / 16 > eps n / share: share > sqrt(16 eps n).
const ROUNDING_ROOM: f64 = 1.0e-3;
/// A function whose weights on all its cells add up to less is left out: it moves next to nothing. The
/// matrix is that of the remaining functions, so the certificate stays exact.
const SUPPORT_MIN: f32 = 1.0e-2;
/// If every cell is fewer links than this away from a fixed one, sweeps alone settle the body as
/// fast.
const RINGS_MIN: usize = 5;

/// Spacing of the functions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum BasisSpacing {
    /// By size: at most 400 functions, at least 2.5 mean link lengths apart; none if every cell is close to
    /// a fixed one, or if the body is too large for that. Nodal shapes have at most 160, at least 4.5
    /// apart, and at most one for six free cells, for bodies of any size.
    #[default]
    BySize,
    /// No coarse level.
    None,
    /// This distance \[mean link lengths\].
    Links(f64),
}

/// A regular grid of boxes over the rest shape.
struct Grid {
    low: [f64; 3],
    /// Boxes along each axis.
    boxes: [usize; 3],
    /// Size of a box.
    size: [f64; 3],
}

impl Grid {
    fn new(rest: &[[f32; 3]], spacing: f64) -> Self {
        let (low, extent) = extent(rest);
        let boxes = extent.map(|extent| ((extent / spacing).round() as usize).max(1));
        let size = [0, 1, 2].map(|axis| {
            let size = extent[axis] / boxes[axis] as f64;
            if size > 0.0 { size } else { 1.0 }
        });
        Self { low, boxes, size }
    }

    /// Returns the box of a position, and the position in it, from 0 to 1.
    fn locate(&self, position: [f32; 3]) -> ([usize; 3], [f64; 3]) {
        let along = |axis: usize| (f64::from(position[axis]) - self.low[axis]) / self.size[axis];
        let at = [0, 1, 2].map(|axis| (along(axis) as usize).min(self.boxes[axis] - 1));
        (at, [0, 1, 2].map(|axis| (along(axis) - at[axis] as f64).clamp(0.0, 1.0)))
    }

    fn box_index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.boxes[1] + y) * self.boxes[2] + z
    }

    /// Returns the grid points at the corners of a box, x slowest.
    fn corners(&self, [x, y, z]: [usize; 3]) -> [usize; 8] {
        std::array::from_fn(|corner| {
            let (i, j, k) = (x + (corner >> 2), y + (corner >> 1 & 1), z + (corner & 1));
            (i * (self.boxes[1] + 1) + j) * (self.boxes[2] + 1) + k
        })
    }
}

fn extent(rest: &[[f32; 3]]) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for position in rest {
        for axis in 0..3 {
            low[axis] = low[axis].min(f64::from(position[axis]));
            high[axis] = high[axis].max(f64::from(position[axis]));
        }
    }
    (low, [0, 1, 2].map(|axis| high[axis] - low[axis]))
}

/// Returns the weights of a cell at the corners of its box, x slowest, as the kernel reads them.
fn weights([x, y, z]: [f64; 3]) -> [f32; 8] {
    let side = |corner: usize, bit: usize, t: f64| if corner >> bit & 1 == 1 { t } else { 1.0 - t };
    std::array::from_fn(|corner| {
        (side(corner, 2, x) * side(corner, 1, y) * side(corner, 0, z)) as f32
    })
}

/// The free cells by part of the body and box, with their weights, and the numbers of the functions.
struct Level {
    count: usize,
    rows: Vec<u32>,
    corners: Vec<[u16; 8]>,
    /// In pairs: the last one of a box may be repeated.
    cells: Vec<u16>,
    /// As `cells`, with weights 0 for a repetition.
    weights: Vec<[f32; 8]>,
    entry: Vec<u16>,
}

impl Level {
    fn new(body: &OrderedCells, mobility: &[f32], parts: Parts, spacing: f64) -> Self {
        let grid = Grid::new(&body.rest, spacing);
        let part = |cell: usize| parts.of_cell(cell);
        // The free cells, sorted by box.
        let mut by_box: Vec<_> = (body.rest.iter())
            .enumerate()
            .filter(|&(cell, _)| mobility[cell] > 0.0)
            .map(|(cell, &position)| {
                let (at, inside) = grid.locate(position);
                ((part(cell), grid.box_index(at)), cell as u16, at, inside)
            })
            .collect();
        by_box.sort_unstable_by_key(|&(at_box, cell, ..)| (at_box, cell));
        // Number the grid points with enough support as functions.
        let points = (0..3).map(|axis| grid.boxes[axis] + 1).product();
        let mut support = vec![0.0; points];
        for &(_, _, at, inside) in &by_box {
            for (point, weight) in grid.corners(at).into_iter().zip(weights(inside)) {
                support[point] += weight;
            }
        }
        let kept = |&support: &f32| if support > SUPPORT_MIN { 0 } else { NO_FUNCTION };
        let mut function_of: Vec<u16> = support.iter().map(kept).collect();
        let mut count = 0;
        for function in function_of.iter_mut().filter(|function| **function != NO_FUNCTION) {
            *function = count as u16;
            count += 1;
        }
        // The rows of the boxes, in pairs of cells.
        let mut level = Self {
            count,
            rows: vec![0],
            corners: Vec::new(),
            cells: Vec::new(),
            weights: Vec::new(),
            entry: vec![NO_FUNCTION; body.all_cells()],
        };
        for chunk in by_box.chunk_by(|a, b| a.0 == b.0) {
            level.corners.push(grid.corners(chunk[0].2).map(|point| function_of[point]));
            for &(_, cell, _, inside) in chunk {
                level.entry[usize::from(cell)] = level.cells.len() as u16;
                level.cells.push(cell);
                level.weights.push(weights(inside));
            }
            if !level.cells.len().is_multiple_of(2) {
                level.cells.extend(level.cells.last().copied());
                level.weights.push([0.0; 8]);
            }
            level.rows.push(level.cells.len() as u32 / 2);
        }
        level
    }

    /// Returns true if every entry has a number of 16 bits.
    fn is_addressable(&self) -> bool {
        self.cells.len() <= usize::from(NO_FUNCTION)
    }

    /// Returns the row of P of a cell.
    fn row(&self, cell: u16) -> Vec<(usize, f64)> {
        let entry = self.entry[usize::from(cell)];
        if entry == NO_FUNCTION {
            return Vec::new();
        }
        let entry = usize::from(entry);
        let at_box = self.rows.partition_point(|&start| start as usize <= entry / 2) - 1;
        let functions = self.corners[at_box].iter().zip(self.weights[entry]);
        functions
            .filter(|&(&function, weight)| weight > 0.0 && function != NO_FUNCTION)
            .map(|(&function, weight)| (usize::from(function), f64::from(weight)))
            .collect()
    }

    /// Returns the inverse of P' L P, or of P' K P on all axes, with the margin for rounding.
    fn inverse(&self, bound: &Bound<'_>) -> Result<DMatrix<f64>> {
        let mut matrix = match bound {
            Bound::Links(links, weight) => {
                let mut matrix = DMatrix::<f64>::zeros(self.count, self.count);
                for (&([i, j], _), &w) in links.iter().zip(*weight) {
                    // One link adds w / 2 times the square of the difference of its ends' rows.
                    let mut difference = self.row(i);
                    difference.extend(
                        self.row(j).into_iter().map(|(function, value)| (function, -value)),
                    );
                    add_square(&mut matrix, &difference, 0.5 * f64::from(w));
                }
                matrix
            }
            Bound::Shapes(shapes) => shapes.elasticity(self.count, |cell| self.row(cell)),
        };
        let size = matrix.nrows();
        for function in 0..size {
            matrix[(function, function)] *= 1.0 + ROUNDING_ROOM * (size as f64).sqrt();
        }
        let factor = matrix.cholesky().ok_or_else(|| {
            Error::check(
                "the coarse functions' matrix is not positive definite: bake with `coarse_basis` none",
            )
        })?;
        Ok(factor.inverse())
    }

    /// Returns for each function the free cell with the largest weight.
    fn highest(&self) -> Vec<u16> {
        let mut highest = vec![(0.0, 0); self.count];
        for cell in 0..self.entry.len() as u16 {
            for (function, weight) in self.row(cell) {
                if weight > highest[function].0 {
                    highest[function] = (weight, cell);
                }
            }
        }
        highest.into_iter().map(|(_, cell)| cell).collect()
    }
}

/// Parts of L, the bound of the curvature.
pub(super) enum Bound<'a> {
    /// The Laplacian of weight w / 2 of links.
    Links(&'a [Link], &'a [f32]),
    /// The bound of nodal shapes.
    Shapes(&'a Shapes),
}

impl Bound<'_> {
    /// The parts of a body of these cells.
    fn parts(&self, mobility: &[f32]) -> Parts {
        match self {
            Self::Links(..) => Parts::of_links(mobility.len()),
            Self::Shapes(_) => Parts::of_shapes(mobility.len()),
        }
    }

    /// Returns b, at least the largest eigenvalue of L, from the weights of the cells.
    pub fn largest(&self, weights: &[f32]) -> f32 {
        match self {
            Self::Links(links, _) => {
                let pair =
                    |&([i, j], _): &Link| 0.5 * (weights[usize::from(i)] + weights[usize::from(j)]);
                links.iter().map(pair).fold(0.0, f32::max)
            }
            Self::Shapes(_) => weights.iter().copied().fold(0.0, f32::max),
        }
    }
}

/// Adds a weight times the square of a map.
fn add_square(matrix: &mut DMatrix<f64>, map: &[(usize, f64)], weight: f64) {
    for &(a, x) in map {
        for &(b, y) in map {
            matrix[(a, b)] += weight * x * y;
        }
    }
}

/// Returns the number of links from the fixed cells to the cell farthest from them; `None` if some
/// cell has no path of links to a fixed one.
fn rings(body: &OrderedCells) -> Option<usize> {
    let mut linked = vec![Vec::new(); body.rest.len()];
    for &([i, j], _) in &body.links {
        linked[usize::from(i)].push(j);
        linked[usize::from(j)].push(i);
    }
    let mut reached = vec![false; body.rest.len()];
    let mut front = body.fixed.clone();
    let mut rings = 0;
    while !front.is_empty() {
        for &cell in &front {
            reached[usize::from(cell)] = true;
        }
        let mut next: Vec<u16> = (front.iter().flat_map(|&cell| &linked[usize::from(cell)]))
            .copied()
            .filter(|&cell| !reached[usize::from(cell)])
            .collect();
        next.sort_unstable();
        next.dedup();
        rings += usize::from(!next.is_empty());
        front = next;
    }
    reached.iter().all(|&reached| reached).then_some(rings)
}

/// Returns the default spacing of the functions of a body; `None` for no functions.
fn by_size(body: &OrderedCells, mobility: &[f32], bound: &Bound<'_>) -> Option<f64> {
    let (closest, farthest, most) = match bound {
        Bound::Links(..) => {
            if rings(body).is_some_and(|rings| rings < RINGS_MIN) {
                return None;
            }
            (SPACING_MIN, SPACING_MAX, DEFAULT_MAX)
        }
        Bound::Shapes(_) => {
            let free = mobility.iter().filter(|&&mobility| mobility > 0.0).count();
            let most = ELASTIC_DEFAULT_MAX.min(free / ELASTIC_CELLS_MIN);
            (ELASTIC_SPACING_MIN, ELASTIC_SPACING_MAX, most)
        }
    };
    let mut spacing = closest;
    while spacing <= farthest {
        let level = Level::new(body, mobility, bound.parts(mobility), spacing);
        if level.count <= most && level.is_addressable() {
            return Some(spacing);
        }
        spacing += 0.05;
    }
    None
}

/// Adds the sections of the coarse level, if the body gets one.
pub(super) fn push(
    sections: &mut Sections,
    body: &OrderedCells,
    mobility: &[f32],
    bound: &Bound<'_>,
    spacing: BasisSpacing,
) -> Result<()> {
    let spacing = match spacing {
        BasisSpacing::None => None,
        BasisSpacing::Links(spacing) => Some(spacing),
        BasisSpacing::BySize => by_size(body, mobility, bound),
    };
    // Build the level, and check its size.
    let Some(spacing) = spacing else { return Ok(()) };
    let level = Level::new(body, mobility, bound.parts(mobility), spacing);
    if level.count == 0 {
        return Ok(());
    }
    if !level.is_addressable() {
        return Err(Error::input(format!(
            "`coarse_basis` {spacing}: too many cells for coarse functions that close; set them \
             farther apart"
        )));
    }
    if level.count > COARSE_MAX {
        return Err(Error::input(format!(
            "`coarse_basis` {spacing}: that makes {} coarse functions, the kernel takes {COARSE_MAX}; \
             set them farther apart",
            level.count
        )));
    }
    // Invert its matrix, and write the sections.
    let inverse = level.inverse(bound)?;
    let rows = padded(&inverse, level.count);
    sections.push(kind::COARSE, &[level.count as u32]);
    sections.push(kind::COARSE_ROWS, &level.rows);
    sections.push(kind::COARSE_CORNERS, level.corners.as_flattened());
    sections.push(kind::COARSE_CELLS, &level.cells);
    let pairs = level.weights.chunks_exact(2);
    let weights: Vec<f32> = pairs
        .flat_map(|pair| (0..8).flat_map(|corner| [pair[0][corner], pair[1][corner]]))
        .collect();
    sections.push(kind::COARSE_WEIGHTS, &weights);
    sections.push(kind::COARSE_ENTRY, &level.entry);
    sections.push(kind::COARSE_INVERSE, &rows);
    if let Bound::Shapes(shapes) = bound {
        sections.push(kind::COARSE_TURNS, &level.highest());
        let mut factors = shapes.factors();
        factors.resize(body.all_cells(), 1.0);
        sections.push(kind::COARSE_FACTORS, &factors);
    }
    Ok(())
}

/// Returns the rows of a symmetric matrix of `count` functions, one axis or three, in single precision.
/// Columns of each axis are padded, and with three axes also the rows.
fn padded(inverse: &DMatrix<f64>, count: usize) -> Vec<f32> {
    let (axes, stride) = (inverse.nrows() / count, count.next_multiple_of(8));
    let columns = axes * stride;
    let mut rows = vec![0.0_f32; if axes == 1 { count } else { columns } * columns];
    let place = |at: usize| at / count * stride + at % count;
    for row in 0..inverse.nrows() {
        for column in 0..=row {
            let value = inverse[(row, column)] as f32;
            rows[place(row) * columns + place(column)] = value;
            rows[place(column) * columns + place(row)] = value;
        }
    }
    rows
}
