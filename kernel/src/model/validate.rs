//! The checks of a model, after which a tick needs none.
//!
//! Every function runs in one pass and needs no memory; together they cost about as much as two sweeps plus
//! the checksum.

use super::coarse_basis::CoarseBasis;
use super::image::{CELLS_MAX, COARSE_FACTOR_MAX, ModelError, NO_CELL, NO_FUNCTION, kind, params};
use super::terms::TermData;
use super::{Model, range, rest_length};
use crate::number::two_float::LANES;

/// Rest lengths, in mean link lengths, are within this factor of 1.
const LENGTH_RANGE: f32 = 1.0e6;
/// Weights, k / `k_ref`, are within this factor of 1.
const WEIGHT_RANGE: f32 = 1.0e9;

/// R_x and C are within this factor of 1.
const CIRCUIT_RANGE: f32 = 1.0e12;
/// Newtons and joules per internal unit are within this factor of 1.
const UNIT_RANGE: f32 = 1.0e18;
/// Largest element of the inverse of the coarse level: far above that of weights in their range.
const INVERSE_MAX: f32 = 1.0e24;
/// Largest weight of a cell at a node of the embedded mesh, of either sign.
const EMBEDDING_WEIGHT_MAX: f32 = 16.0;
/// Largest difference between the sum of a node's weights and 1.
const EMBEDDING_SUM_TOLERANCE: f32 = 1.0e-4;
/// Largest numbering of an input.
const INPUT_NODES_MAX: u32 = 1 << 27;

/// Returns true if a number lies within this factor of 1.
fn within(value: f32, factor: f32) -> bool {
    (1.0 / factor..=factor).contains(&value)
}

/// Checks a whole model: first ranges, then order and symmetry, then the numbers.
pub(crate) fn model(model: &Model<'_>) -> Result<(), ModelError> {
    parameters(model)?;
    let bodily = model.body_cells();
    rows(kind::ROWS, model.rows, model.links())?;
    rows(kind::BACK_ROWS, model.back_rows, model.links())?;
    upper_ends(model)?;
    half_links(model)?;
    rest_positions(model)?;
    link_numbers(model)?;
    slices(model)?;
    ascending(kind::FIXED, model.fixed, bodily)?;
    model.others.check(&model.layout())?;
    model.cuttable.check(model.rest)?;
    dormant(model)?;
    mobilities(model)?;
    slice_values(model)?;
    basis(model)?;
    ascending(kind::SURFACE, model.surface, bodily)?;
    normals(model)?;
    input_ids(model)?;
    embedded_mesh(model)?;
    corners(kind::TRIANGLES, model.triangles.as_flattened(), bodily)?;
    model.contact_surface().map_or(Ok(()), |contact| contact.check(model.cells()))?;
    corners(kind::TETRAHEDRA, model.tetrahedra.as_flattened(), bodily)
}

fn at(position: usize) -> u32 {
    u32::try_from(position).unwrap_or(u32::MAX)
}

fn positive(value: f32) -> bool {
    value > 0.0 && value.is_finite()
}

fn parameters(model: &Model<'_>) -> Result<(), ModelError> {
    let word = |index: usize, holds: bool| {
        if holds { Ok(()) } else { Err(ModelError::Parameter(at(index))) }
    };
    word(params::CELLS, (1..=CELLS_MAX).contains(&model.cells()))?;
    word(params::DIMENSION, (1..=3).contains(&model.dimension))?;
    word(params::UNIT_M, positive(model.unit_m))?;
    word(params::CENTRE_M, model.centre_m.iter().all(|value| value.is_finite()))?;
    word(params::STIFFNESS_N_PER_M, positive(model.stiffness_n_per_m))?;
    let force = 2.0 * model.stiffness_n_per_m * model.unit_m;
    let units = within(force, UNIT_RANGE) && within(force * model.unit_m, UNIT_RANGE);
    word(params::STIFFNESS_N_PER_M, units)?;
    word(params::ALPHA, (0.0..1.0).contains(&model.alpha))?;
    word(params::SATURATION, positive(model.saturation) && model.saturation < 1.0e6)?;
    word(params::RESISTANCE, within(model.resistance, CIRCUIT_RANGE))?;
    word(params::CAPACITANCE, within(model.capacitance, CIRCUIT_RANGE))?;
    word(params::DEGREE_BOUND, positive(model.degree_bound))?;
    let parts = model.parts as usize;
    word(params::PARTS, (1..=model.cells()).contains(&parts))?;
    let numbering = model.body_cells() as u32..=INPUT_NODES_MAX;
    word(params::INPUT_NODES, numbering.contains(&model.input_nodes))?;
    word(params::ENERGY_MAX, positive(model.energy_max) && model.energy_max < 1.0e18)
}

/// Checks row starts: from 0, never descending, up to `end`.
fn rows(kind: u32, rows: &[u32], end: usize) -> Result<(), ModelError> {
    let mut last = 0;
    for (i, &start) in rows.iter().enumerate() {
        let first_is_zero = i > 0 || start == 0;
        if start < last || start as usize > end || !first_is_zero {
            return Err(ModelError::Index(kind, at(i)));
        }
        last = start;
    }
    if last as usize == end { Ok(()) } else { Err(ModelError::Index(kind, at(rows.len()))) }
}

/// As `rows`, and no row is empty: a tick visits each.
fn filled_rows(kind: u32, starts: &[u32], end: usize) -> Result<(), ModelError> {
    rows(kind, starts, end)?;
    let empty = starts.iter().zip(starts.iter().skip(1)).position(|(start, next)| start == next);
    empty.map_or(Ok(()), |position| Err(ModelError::Index(kind, at(position))))
}

/// Checks `i < j < cells`, ascending and without repeats within each row.
fn upper_ends(model: &Model<'_>) -> Result<(), ModelError> {
    for i in 0..model.cells() {
        let mut last = i;
        for link in model.row(i) {
            let upper = model.upper.get(link).copied().map_or(0, usize::from);
            if upper <= last || upper >= model.cells() {
                return Err(ModelError::Index(kind::UPPER, at(link)));
            }
            last = upper;
        }
    }
    Ok(())
}

/// Checks that the half-links name the same links from the other end.
fn half_links(model: &Model<'_>) -> Result<(), ModelError> {
    for i in 0..model.cells() {
        let mut next = 0;
        for half in model.back_row(i) {
            let lower = model.lower.get(half).copied().map_or(usize::MAX, usize::from);
            let link = model.back_link.get(half).copied().unwrap_or(u32::MAX) as usize;
            let same_link = lower < i
                && lower >= next
                && model.row(lower).contains(&link)
                && model.upper.get(link).copied().map(usize::from) == Some(i);
            if !same_link {
                return Err(ModelError::Index(kind::BACK_LINK, at(half)));
            }
            next = lower + 1;
        }
    }
    Ok(())
}

fn rest_positions(model: &Model<'_>) -> Result<(), ModelError> {
    let bad = model.rest.iter().position(|rest| {
        let inside = rest.iter().all(|x| x.is_finite() && 1.999 * x.abs() <= model.saturation);
        !inside || rest.iter().any(|x| x.to_bits() == (-0.0_f32).to_bits())
    });
    bad.map_or(Ok(()), |cell| Err(ModelError::Value(kind::REST, at(cell))))
}

/// Rest lengths must equal those that the kernel computes from the stored rest positions.
fn link_numbers(model: &Model<'_>) -> Result<(), ModelError> {
    for i in 0..model.cells() {
        for k in model.row(i) {
            let length = model.rest_length.get(k).copied().unwrap_or(0.0);
            let j = model.upper.get(k).copied().map_or(0, usize::from);
            let own = rest_length(model.rest_position(i), model.rest_position(j));
            let in_range = (1.0 / LENGTH_RANGE..=LENGTH_RANGE).contains(&length);
            if !in_range || own.to_bits() != length.to_bits() {
                return Err(ModelError::Value(kind::REST_LENGTH, at(k)));
            }
            if !(0.0..1.0).contains(&model.link_alpha(k)) {
                return Err(ModelError::Value(kind::ALPHA, at(k)));
            }
            let is_spring = (1.0 / WEIGHT_RANGE..=WEIGHT_RANGE).contains(&model.link_weight(k));
            if !is_spring && !model.is_nodal() {
                return Err(ModelError::Value(kind::WEIGHT, at(k)));
            }
        }
    }
    Ok(())
}

/// The slices name every cell's links in ascending order of the other end, then pad with the cell
/// itself.
fn slices(model: &Model<'_>) -> Result<(), ModelError> {
    let Some(slices) = model.slices else { return Ok(()) };
    rows(kind::SLICE_ROWS, slices.rows, slices.neighbours.len())?;
    for slice in 0..slices.rows.len().saturating_sub(1) {
        let groups = range(slices.rows, slice);
        let longest = (0..LANES).map(|lane| model.neighbours(slice * LANES + lane).count()).max();
        if longest != Some(groups.len()) {
            return Err(ModelError::Index(kind::SLICE_ROWS, at(slice)));
        }
        for lane in 0..LANES {
            let cell = slice * LANES + lane;
            let mut expected = model.neighbours(cell);
            for group in groups.clone() {
                let slot = |_| Some((slices.neighbours.get(group)?, slices.lengths.get(group)?));
                let (ids, lengths) = Some(()).and_then(slot).ok_or(ModelError::Layout)?;
                let id = ids.get(lane).copied().map_or(usize::MAX, usize::from);
                let length = lengths.get(lane).copied().unwrap_or(f32::NAN);
                let (wanted, wanted_length) = match expected.next() {
                    Some((link, other)) => {
                        (other, model.rest_length.get(link).copied().unwrap_or(f32::NAN))
                    }
                    None => (cell.min(model.cells() - 1), 0.0),
                };
                if id != wanted || length.to_bits() != wanted_length.to_bits() {
                    return Err(ModelError::Index(kind::SLICE_NEIGHBOURS, at(group)));
                }
            }
        }
    }
    Ok(())
}

/// Alpha and weight of each slot are those of its link; padding has weight 1 and no alpha.
fn slice_values(model: &Model<'_>) -> Result<(), ModelError> {
    let Some(slices) = model.slices else { return Ok(()) };
    let check =
        |kind: u32, values: Option<&[[f32; LANES]]>, padding: f32, of: &dyn Fn(usize) -> f32| {
            let Some(values) = values else { return Ok(()) };
            for cell in 0..model.cells() {
                let mut links = model.neighbours(cell);
                for group in range(slices.rows, cell / LANES) {
                    let value =
                        values.get(group).and_then(|lanes| lanes.get(cell % LANES)).copied();
                    let wanted = links.next().map_or(padding, |(link, _)| of(link));
                    if value.map(f32::to_bits) != Some(wanted.to_bits()) {
                        return Err(ModelError::Value(kind, at(group)));
                    }
                }
            }
            Ok(())
        };
    check(kind::SLICE_ALPHAS, slices.alphas, 0.0, &|link| model.link_alpha(link))?;
    check(kind::SLICE_WEIGHTS, slices.weights, 1.0, &|link| model.link_weight(link))
}

/// Every free cell lies in one box, and its weights sum to at most 1. The inverse must be symmetric and
/// finite; its values are not compared with the matrix.
fn basis(model: &Model<'_>) -> Result<(), ModelError> {
    let Some(basis) = model.coarse_basis else { return Ok(()) };
    // Check the rows and the corners of the boxes.
    filled_rows(kind::COARSE_ROWS, basis.rows, basis.cells.len())?;
    let known = |function: &u16| usize::from(*function) < basis.count || *function == NO_FUNCTION;
    if let Some(at_box) = basis.corners.iter().position(|corners| !corners.iter().all(known)) {
        return Err(ModelError::Index(kind::COARSE_CORNERS, at(at_box)));
    }
    // The entry of each free cell must name that cell; other cells have no entry.
    let stands = basis.cells.as_flattened();
    for (cell, (&entry, &mobility)) in basis.entry.iter().zip(model.mobility).enumerate() {
        let here = stands.get(usize::from(entry)).copied().map(usize::from);
        let expected = if mobility > 0.0 { Some(cell) } else { None };
        if here != expected || (here.is_none() && entry != NO_FUNCTION) {
            return Err(ModelError::Index(kind::COARSE_ENTRY, at(cell)));
        }
    }
    // Each position is its cell's entry, or repeats the one before with weights of 0.
    for (stand, &cell) in stands.iter().enumerate() {
        let entry = basis.entry.get(usize::from(cell)).copied().map(usize::from);
        let weights = || (0..LANES).map(|corner| basis.weight(stand, corner));
        let again = stand % 2 == 1 && entry == Some(stand - 1) && weights().all(|w| w == 0.0);
        if entry != Some(stand) && !again {
            return Err(ModelError::Index(kind::COARSE_CELLS, at(stand)));
        }
        if !weights().all(|w| (0.0..=1.0).contains(&w)) || weights().sum::<f32>() > 1.0001 {
            return Err(ModelError::Value(kind::COARSE_WEIGHTS, at(stand)));
        }
    }
    // Check the inverse and the numbers of an elastic level.
    inverse(&basis)?;
    let Some(elastic) = basis.elastic() else { return Ok(()) };
    corners(kind::COARSE_TURNS, elastic.turns, model.body_cells())?;
    let is_factor = |factor: &f32| (1.0..=COARSE_FACTOR_MAX).contains(factor);
    let bad = elastic.factors.iter().position(|factor| !is_factor(factor));
    bad.map_or(Ok(()), |cell| Err(ModelError::Value(kind::COARSE_FACTORS, at(cell))))
}

/// The inverse is symmetric and finite, its diagonal positive, its padding 0.
fn inverse(basis: &CoarseBasis<'_>) -> Result<(), ModelError> {
    let columns = basis.row_blocks() * LANES;
    let rows = if basis.elastic().is_some() { columns } else { basis.count };
    let is_function =
        |row: usize| row.checked_rem(basis.stride()).is_some_and(|at| at < basis.count);
    for row in 0..rows {
        for column in 0..columns {
            let value = basis.inverse_at(row, column);
            let is_any = is_function(row) && is_function(column);
            let mirrored = if is_any { basis.inverse_at(column, row) } else { 0.0 };
            let is_below = row != column || !is_any || value > 0.0;
            if !(value.abs() <= INVERSE_MAX && is_below) || value != mirrored {
                return Err(ModelError::Value(kind::COARSE_INVERSE, at(row)));
            }
        }
    }
    Ok(())
}

/// Checks for strictly ascending cell ids.
fn ascending(kind: u32, ids: &[u16], cells: usize) -> Result<(), ModelError> {
    let mut next = 0;
    for (position, &id) in ids.iter().enumerate() {
        if usize::from(id) < next || usize::from(id) >= cells {
            return Err(ModelError::Index(kind, at(position)));
        }
        next = usize::from(id) + 1;
    }
    Ok(())
}

/// Mobilities and the degree bound must meet the conditions of the proof that the energy falls.
fn mobilities(model: &Model<'_>) -> Result<(), ModelError> {
    let mut fixed = model.fixed.iter().copied().map(usize::from).peekable();
    let bodily = model.body_cells();
    for i in 0..model.cells() {
        let is_fixed = fixed.next_if_eq(&i).is_some();
        let bound = model.cell_bound(i);
        let is_held = is_fixed || bound == 0.0 || i >= bodily;
        let expected = if is_held { 0.0 } else { 1.0 / bound };
        if model.mobility.get(i).map(|m| m.to_bits()) != Some(expected.to_bits()) {
            return Err(ModelError::Value(kind::MOBILITY, at(i)));
        }
        for k in model.row(i) {
            let j = model.upper.get(k).copied().map_or(0, usize::from);
            if (bound + model.cell_bound(j)) * 0.5 > model.degree_bound {
                return Err(ModelError::Parameter(at(params::DEGREE_BOUND)));
            }
        }
    }
    Ok(())
}

/// Checks that spare cells have no link, rest at the centre and exert no force, and that the edges of tetrahedra
/// are links: a split takes its numbers to their slots. Links are then shared by the tetrahedra at their edges: each
/// has some, in slices.
fn dormant(model: &Model<'_>) -> Result<(), ModelError> {
    let cuttable = model.cuttable();
    if !cuttable.is_any() {
        return Ok(());
    }
    if !model.is_nodal() && model.slices.is_none() {
        return Err(ModelError::Layout);
    }
    for cell in model.body_cells()..model.cells() {
        if model.neighbours(cell).next().is_some() {
            return Err(ModelError::Index(kind::CUTTING, at(cell)));
        }
        if model.rest_position(cell).map(f32::to_bits) != [0; 3] {
            return Err(ModelError::Value(kind::REST, at(cell)));
        }
        if !model.others.is_dormant(cell) {
            return Err(ModelError::Value(kind::NODAL_CELLS, at(cell)));
        }
    }
    for (number, &[a, b, c, d]) in cuttable.corners().iter().enumerate() {
        let edges = [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]];
        let is_link = |[one, other]: [u16; 2]| {
            let (lower, upper) = if one < other { (one, other) } else { (other, one) };
            let row = model.upper.get(model.row(lower.into())).unwrap_or(&[]);
            row.binary_search(&upper).is_ok()
        };
        if !edges.into_iter().all(is_link) {
            return Err(ModelError::Index(kind::CUT_CORNERS, at(number)));
        }
    }
    for cell in 0..if model.is_nodal() { 0 } else { model.body_cells() } {
        for link in model.row(cell) {
            let upper = model.upper.get(link);
            let is_there = |&tetrahedron: &u32| {
                let corners = cuttable.corners().get(tetrahedron as usize);
                corners.zip(upper).is_some_and(|(corners, upper)| corners.contains(upper))
            };
            if !cuttable.star(cell).iter().any(is_there) {
                return Err(ModelError::Index(kind::UPPER, at(link)));
            }
        }
    }
    Ok(())
}

fn normals(model: &Model<'_>) -> Result<(), ModelError> {
    let bad = model.normals.iter().position(|n| {
        let squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        !(0.99..1.01).contains(&squared)
    });
    bad.map_or(Ok(()), |position| Err(ModelError::Value(kind::NORMALS, at(position))))
}

fn input_ids(model: &Model<'_>) -> Result<(), ModelError> {
    let bad = model.input_id.iter().position(|&id| id >= model.input_nodes);
    bad.map_or(Ok(()), |cell| Err(ModelError::Index(kind::INPUT_ID, at(cell))))
}

/// Every node of the embedded mesh has cells that exist, with weights that sum to 1, or is left out. Each
/// cell lies at its own node. Elements join nodes that are not left out.
fn embedded_mesh(model: &Model<'_>) -> Result<(), ModelError> {
    let Some(mesh) = model.embedded else { return Ok(()) };
    let bodily = model.body_cells();
    // Check the cells, weights and rest position of each node.
    for (node, (cells, weights)) in mesh.cells.iter().zip(mesh.weights).enumerate() {
        let left_out = cells.iter().all(|&cell| cell == NO_CELL);
        if !left_out && cells.iter().any(|&cell| usize::from(cell) >= bodily) {
            return Err(ModelError::Index(kind::FINE_CELLS, at(node)));
        }
        let total = weights.iter().fold(0.0, |sum, w| sum + w);
        let wanted = if left_out { 0.0 } else { 1.0 };
        let bounded = weights.iter().all(|w| w.abs() <= EMBEDDING_WEIGHT_MAX);
        let summed = (total - wanted).abs() <= EMBEDDING_SUM_TOLERANCE;
        if !bounded || !summed {
            return Err(ModelError::Value(kind::FINE_WEIGHTS, at(node)));
        }
        let inside = |x: &f32| x.abs() <= model.saturation;
        if !mesh.rest.get(node).is_some_and(|rest| rest.iter().all(inside)) {
            return Err(ModelError::Value(kind::FINE_REST, at(node)));
        }
    }
    // Each cell must lie at its node.
    for (cell, (&id, rest)) in model.input_id.iter().zip(model.rest).enumerate() {
        if mesh.own_cell(id as usize).map(usize::from) != Some(cell) {
            return Err(ModelError::Index(kind::INPUT_ID, at(cell)));
        }
        let there = mesh.rest.get(id as usize);
        if there.is_none_or(|there| there.map(f32::to_bits) != rest.map(f32::to_bits)) {
            return Err(ModelError::Value(kind::FINE_REST, id));
        }
    }
    // Elements must not use a node that is left out.
    let joined = |kind: u32, ids: &[u32]| {
        let bad = ids.iter().position(|&id| mesh.own_cell(id as usize).is_none());
        bad.map_or(Ok(()), |position| Err(ModelError::Index(kind, at(position))))
    };
    joined(kind::FINE_TRIANGLES, mesh.triangles.as_flattened())?;
    joined(kind::FINE_TETRAHEDRA, mesh.tetrahedra.as_flattened())
}

fn corners(kind: u32, ids: &[u16], cells: usize) -> Result<(), ModelError> {
    let bad = ids.iter().position(|&id| usize::from(id) >= cells);
    bad.map_or(Ok(()), |position| Err(ModelError::Index(kind, at(position))))
}
