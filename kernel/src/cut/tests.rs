//! Splits of bodies in random states.

#![allow(clippy::unwrap_used)]

use std::vec::Vec;

use super::body::CutBody;
use super::memory::{CutRoom, cut_words};
use super::offset::of_shapes;
use super::random::Random;
use super::split::Look;
use crate::energy::residual::places;
use crate::energy::state::{States, StatesOf, TermState, TermStates, number, put, term_states};
use crate::model::Model;
use crate::model::image::nodal;
use crate::model::nodal::Nodal;
use crate::model::stiffening::{Set, Stiffening};
use crate::number::cell::{Cell, dot, sub};
use crate::number::turn::cross;
use crate::number::two_float::LANES;

/// A block of 4 x 4 x 3 nodes with a spare cell for each, without a band of stretches.
static IMAGE: &[u8] = crate::include_model!("../../../tests/data/cut4.chaincell");
/// The same body with three sets of stiffening bands.
pub(super) static BANDS: &[u8] = crate::include_model!("../../../tests/data/bands4.chaincell");

type Matrix = [[f64; 3]; 3];

/// Bodies that are cut at random.
const BODIES: usize = 60;
/// The same with `CHAINCELL_SLOW=1`.
const BODIES_SLOW: usize = 360;

/// Number of bodies to cut.
fn bodies() -> usize {
    if std::env::var_os("CHAINCELL_SLOW").is_some() { BODIES_SLOW } else { BODIES }
}

fn rotation([w, x, y, z]: [f64; 4]) -> Matrix {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

fn squared(a: &Matrix, b: &Matrix) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (a - b) * (a - b)).sum()
}

/// E of the stiffening bands in double precision, as the module `stiffening` defines it; with bands that are closed if
/// that is asked for.
pub(super) fn energy_of_bands(
    bands: Stiffening<'_>,
    at: &impl Fn(usize) -> [f32; 3],
    is_closed: bool,
) -> f64 {
    let of = |(cell, group, other): (usize, usize, usize)| {
        let [volume, length] = [bands.volumes, bands.lengths]
            .map(|numbers| f64::from(Stiffening::at(numbers, group, cell)));
        let ways = at(cell).into_iter().zip(at(other)).map(|(a, b)| f64::from(a) - f64::from(b));
        let stretch = ways.map(|way| way * way).sum::<f64>().sqrt() / length - 1.0;
        let of_set = |set: Set| {
            let half_width = if is_closed { 0.0 } else { f64::from(set.half_width) };
            let d = (stretch.abs() - half_width).max(0.0) * length;
            f64::from(set.moduli[usize::from(stretch > 0.0)]) * d * d
        };
        volume * bands.sets().map(of_set).sum::<f64>()
    };
    let cells = 0..bands.rest.len();
    let half_links =
        cells.flat_map(|cell| bands.slots_of(cell).map(move |(group, other)| (cell, group, other)));
    0.125 * half_links.map(of).sum::<f64>()
}

/// E of the shapes in double precision, without band of stretches, as the module `nodal` defines it.
fn energy(shapes: Nodal<'_>, at: &impl Fn(usize) -> [f32; 3], states: StatesOf<'_>) -> f64 {
    let unit = rotation([1.0, 0.0, 0.0, 0.0]);
    let moved = |cell: usize| {
        let (now, rest) = (at(cell), shapes.rest_position(cell));
        [0, 1, 2].map(|axis| f64::from(now[axis]) - f64::from(rest[axis]))
    };
    let of = |cell: usize| {
        let own = |row| f64::from(shapes.number(cell, row));
        let (here, mut f, mut spread) = (moved(cell), unit, 0.0);
        for (other, slot) in shapes.slots_of(cell) {
            let there = moved(other);
            for (row, axis) in f.iter_mut().zip([0, 1, 2]) {
                let way = there[axis] - here[axis];
                spread += 0.25 * f64::from(slot.number(nodal::SPREAD)) * way * way;
                for (element, area) in row.iter_mut().zip(slot.three(nodal::AREA)) {
                    *element += way * f64::from(area) / own(nodal::VOLUME);
                }
            }
        }
        let mut moved = f;
        if let Some(offsets) = shapes.offset_of(cell / LANES) {
            for (element, lanes) in moved.as_flattened_mut().iter_mut().zip(offsets) {
                *element += f64::from(lanes[cell % LANES]);
            }
        }
        let rows = states.slice(cell / LANES).unwrap().lasting;
        let state = |row| f64::from(number(rows, row, cell % LANES));
        let turn = rotation([0, 1, 2, 3].map(state));
        let size = [0, 1, 2, 3].map(state).iter().map(|x| x * x).sum::<f64>();
        assert!((size - 1.0).abs() < 1e-4);
        let shape = [4, 7, 10].map(|row| [state(row), state(row + 1), state(row + 2)]);
        let [mu, lambda_3] = [own(nodal::MU), own(nodal::LAMBDA_3)];
        let density = mu * squared(&moved, &turn) + 0.5 * lambda_3 * squared(&moved, &shape)
            - f64::from(nodal::BETA) * mu * squared(&f, &unit);
        own(nodal::VOLUME) * density + spread
    };
    (0..shapes.count).map(of).sum()
}

/// Random positions, rotations and shapes.
fn shuffle(random: &mut Random, body: &CutBody<'_, '_>, state: &mut [Cell], states: States<'_>) {
    let size = 0.02 + 0.3 * random.next().abs();
    for (cell, v) in state.iter_mut().enumerate().take(body.bodily + body.used()) {
        let rest = body.shapes().rest_position(cell);
        *v = Cell::at(rest.map(|x| x + size * random.next()));
        let turn = [1.0, 0.0, 0.0, 0.0].map(|x: f32| x + size * random.next());
        let length = turn.iter().map(|x| x * x).sum::<f32>().sqrt();
        let unit = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0].map(|x| x + size * random.next());
        let numbers = turn.iter().map(|x| x / length).chain(unit);
        let memory = of_shapes(states).change(cell / LANES).unwrap();
        put(memory.lasting, cell % LANES, numbers);
    }
}

/// Runs `each` after every look of many, with the body's energy before and after it, at a body that is cut anew once
/// its spare cells are in use.
fn cut_at_random(mut each: impl FnMut(&mut CutBody<'_, '_>, Look, [f64; 2])) {
    cut_at_random_in(IMAGE, bodies(), |body, look, energies, _| each(body, look, energies));
}

/// The same in this many bodies of an image; `each` takes the cells' state too.
pub(super) fn cut_at_random_in(
    image: &[u8],
    bodies: usize,
    mut each: impl FnMut(&mut CutBody<'_, '_>, Look, [f64; 2], &[Cell]),
) {
    let model = Model::from_bytes(image).unwrap();
    let (cells, tetrahedra) = (model.cells(), model.tetrahedra_to_cut());
    let mut random = Random(7);
    for _ in 0..bodies {
        let mut words = std::vec![0xAAAA_AAAA; cut_words(&model)];
        let mut memory = CutRoom::new(&mut words);
        let mut body = CutBody::of(&mut memory, &model).unwrap();
        body.reset();
        let mut state: Vec<Cell> = model.rest.iter().map(|&rest| Cell::at(rest)).collect();
        let mut lines = std::vec![TermState::ZERO; term_states(cells)];
        let mut kept = TermStates::new(&mut lines);
        kept.reset(cells);
        let states = kept.shared(cells);
        for round in 0..80 {
            if round % 3 == 0 {
                shuffle(&mut random, &body, &mut state, states);
            }
            for _ in 0..6 {
                body.open_face(random.below(tetrahedra), random.below(4)).unwrap();
            }
            for cell in (0..cells).filter(|&cell| body.arrays.marks[cell] == 1).collect::<Vec<_>>()
            {
                body.mark(cell, 0);
                let stored = |body: &CutBody<'_, '_>, state: &[Cell]| {
                    let at = places(&model, state);
                    energy(body.shapes(), &at, of_shapes(states))
                        + energy_of_bands(body.bands(), &at, false)
                };
                let before = stored(&body, &state);
                let first = body.bodily + body.used();
                let look = body.look(cell, &places(&model, &state), states);
                for copy in first..body.bodily + body.used() {
                    state[copy] = state[cell];
                }
                let after = stored(&body, &state);
                each(&mut body, look, [before, after], &state);
            }
        }
    }
}

#[test]
fn no_split_raises_the_energy() {
    for image in [IMAGE, BANDS] {
        no_split_raises_the_energy_of(image);
    }
}

fn no_split_raises_the_energy_of(image: &[u8]) {
    let (mut splits, mut falls, mut refused) = (0, 0, 0);
    cut_at_random_in(image, bodies(), |_, look, [before, after], _| {
        let room = 2e-6 * before.abs();
        assert!(after <= before + room, "{before} {after}");
        match look {
            Look::Split(change) => {
                splits += 1;
                falls += usize::from(after < before - room);
                // The bound that the level takes is one.
                assert!(change >= after - before - 1e-7 * before.abs(), "{change}");
                assert!(change <= after - before + 1e-4 * before.abs(), "{change}");
            }
            Look::Refused => refused += 1,
            Look::Whole => assert_eq!(before, after),
        }
    });
    std::println!("{splits} splits, of which {falls} lower the energy; {refused} refused");
    let least = if bodies() == BODIES { 2000 } else { 10_000 };
    assert!(splits > least && falls > splits / 2 && refused > 100, "{splits} {falls} {refused}");
}

/// Lowering offsets changes the energy by no more than it reports, and ends.
#[test]
fn offsets_decay() {
    let model = Model::from_bytes(IMAGE).unwrap();
    let (mut decays, mut seen) = (0, 0);
    cut_at_random(|body, look, _| {
        seen += usize::from(matches!(look, Look::Split(_)));
        if seen != 7 || !matches!(look, Look::Split(_)) {
            return;
        }
        seen = 0;
        // At the rest shape, with the states at rest.
        let mut lines = std::vec![TermState::ZERO; term_states(model.cells())];
        let mut kept = TermStates::new(&mut lines);
        kept.reset(model.cells());
        let states = kept.shared(model.cells());
        let rest: Vec<[f32; 3]> = body.arrays.rest.to_vec();
        let at = |cell: usize| rest[cell];
        let mut ticks = 0;
        loop {
            let before = energy(body.shapes(), &at, of_shapes(states));
            let Some(change) = body.decay(f64::INFINITY, &at, states) else { break };
            let after = energy(body.shapes(), &at, of_shapes(states));
            assert!(change >= after - before - 1e-7 * before, "{before} {after} {change}");
            let room = 1e-4 * (before + before.sqrt());
            assert!(change <= after - before + room, "{before} {after} {change}");
            ticks += 1;
        }
        assert!((100..160).contains(&ticks), "{ticks}");
        assert!(body.arrays.offsets.as_flattened().as_flattened().iter().all(|&x| x == 0.0));
        decays += 1;
    });
    assert!(decays > 20, "{decays}");
}

/// In a tear offsets decay by a step that is halved until the sweeps have paid for it, at most three times.
#[test]
fn offsets_decay_as_far_as_that_is_paid_for() {
    let model = Model::from_bytes(IMAGE).unwrap();
    let (mut seen, mut counts) = (0, [0; 3]);
    cut_at_random(|body, look, _| {
        seen += usize::from(matches!(look, Look::Split(_)));
        if seen % 7 != 0 || !matches!(look, Look::Split(_)) {
            return;
        }
        // Bent, with the states at rest and small offsets, so that these lower the energy as often as not.
        for cell in 0..model.cells() {
            let offset = body.offset(cell).map(|row| row.map(|x| 0.05 * x));
            body.set_offset(cell, offset);
        }
        let mut lines = std::vec![TermState::ZERO; term_states(model.cells())];
        let mut kept = TermStates::new(&mut lines);
        kept.reset(model.cells());
        let states = kept.shared(model.cells());
        let rest: Vec<[f32; 3]> = body.arrays.rest.to_vec();
        let at = |cell: usize| {
            let [x, y, z] = rest[cell];
            [x + 0.1 * x * x, y + 0.1 * x * z, z]
        };
        let offsets = body.arrays.offsets.to_vec();
        let is_offset = body.arrays.is_offset.to_vec();
        let before = energy(body.shapes(), &at, of_shapes(states));
        let free = body.decay(f64::INFINITY, &at, states).unwrap();
        for (step, share) in [1.0, 0.6, 0.3, 0.05].into_iter().enumerate() {
            body.arrays.offsets.copy_from_slice(&offsets);
            body.arrays.is_offset.copy_from_slice(&is_offset);
            if free < 1e-4 * before {
                continue;
            }
            let most = share * free;
            let change = body.decay(most, &at, states);
            let rise = energy(body.shapes(), &at, of_shapes(states)) - before;
            assert!(rise <= most + 1e-7 * before, "{step}: {rise} {most}");
            assert!(change.is_none_or(|change| change <= most), "{step}: {change:?} {most}");
            assert_eq!(*body.arrays.offsets == *offsets, change.is_none(), "{step}");
            assert!(step > 0 || change.is_some(), "{most}");
            counts[if change.is_none() { 2 } else { step.min(1) }] += 1;
        }
    });
    std::println!("{counts:?} whole steps, shorter ones and none");
    assert!(counts.into_iter().all(|count| count > 5), "{counts:?}");
}

/// The numbers of a cut body follow from its state; copies have the weights of their originals.
#[test]
fn numbers_follow_from_the_state() {
    let mut splits = 0;
    cut_at_random(|body, look, _| {
        splits += usize::from(matches!(look, Look::Split(_)));
        if splits % 29 != 1 {
            return;
        }
        let bits = |body: &CutBody<'_, '_>| {
            let arrays = &body.arrays;
            let listed = arrays.listed[0] as usize;
            let floats = [
                arrays.numbers[..listed].as_flattened(),
                arrays.cells.as_flattened().as_flattened(),
                arrays.rest.as_flattened(),
                arrays.lip_numbers.as_flattened(),
                &*arrays.mobility,
                &*arrays.factors,
                arrays.weights.as_flattened().as_flattened(),
            ];
            let used = *arrays.rows.last().unwrap() as usize;
            let slots = arrays.slots[..used].as_flattened().as_flattened();
            let floats = floats.into_iter().chain([slots]).flatten().map(|x| x.to_bits());
            let whole = [
                arrays.ids[..used].as_flattened(),
                &*arrays.entry,
                arrays.pairs.as_flattened(),
                arrays.triangles[..body.model.triangles.len() + listed].as_flattened(),
            ];
            let whole = whole.into_iter().flatten().map(|&x| u32::from(x));
            let ends = *arrays.lip_rows.last().unwrap() as usize;
            let words =
                [&arrays.listed[..], arrays.names[..listed].as_flattened(), &arrays.ends[..ends]];
            let words = words.into_iter().flatten().chain(&*arrays.box_rows).copied();
            floats.chain(whole).chain(words).collect::<Vec<u32>>()
        };
        body.list();
        let before = bits(body);
        body.derive();
        assert!(before == bits(body));
        // Every triangle is a face of a tetrahedron.
        let all = body.model.triangles.len() + body.arrays.listed[0] as usize;
        for triangle in &body.arrays.triangles[..all] {
            let mut tetrahedra = body.arrays.corners.iter();
            assert!(tetrahedra.any(|corners| triangle.iter().all(|id| corners.contains(id))));
        }
    });
    assert!(splits > 2000);
}

/// Number of sides of opened faces with a cell that the other side has not.
fn parted_sides(body: &CutBody<'_, '_>) -> usize {
    let cells_of = |at: usize, opposite: usize| {
        let cells = body.arrays.corners[at];
        (0..4).filter(move |&corner| corner != opposite).map(move |corner| cells[corner])
    };
    let sides =
        (0..body.arrays.corners.len()).flat_map(|at| (0..4).map(move |corner| (at, corner)));
    let open = sides.filter(|&(at, corner)| body.arrays.faces[at] >> corner & 1 == 1);
    let parted = open.filter(|&(at, corner)| {
        let (other, opposite) = body.across(at, corner).unwrap();
        cells_of(at, corner).any(|cell| cells_of(other, opposite).all(|there| there != cell))
    });
    parted.count()
}

/// Checks the list of a body's opened faces. Returns the numbers of triangles and of faces without a place.
fn check_opened(body: &mut CutBody<'_, '_>) -> (usize, usize) {
    body.list();
    let (arrays, outer) = (&body.arrays, body.model.triangles.len());
    let [count, lacking] = arrays.listed.map(|listed| listed as usize);
    let names = &arrays.names[..count];
    assert!(names.is_sorted_by(|a, b| a[0] < b[0]));
    assert_eq!(parted_sides(body), count + 2 * lacking);
    for (place, [name, other]) in names.iter().enumerate() {
        // The other side has the same cells of the image, and not the same cells.
        let triangle = arrays.triangles[outer + place];
        let there = arrays.triangles[outer + *other as usize];
        assert_eq!(names[*other as usize][1] as usize, place);
        let sorted = |cells: [u16; 3]| {
            let mut cells = cells.map(|cell| body.origin(cell.into()));
            cells.sort_unstable();
            cells
        };
        assert_eq!(sorted(triangle), sorted(there));
        assert!(triangle.iter().any(|cell| !there.contains(cell)));
        // Its face is open. Its corners are those of its tetrahedron without the opposite one, outward.
        let (tetrahedron, opposite) = ((*name as usize - outer) / 4, (*name as usize - outer) % 4);
        assert!(arrays.faces[tetrahedron] >> opposite & 1 == 1);
        let cells = arrays.corners[tetrahedron];
        assert!(!triangle.contains(&cells[opposite]));
        assert!(triangle.iter().all(|cell| cells.contains(cell)));
        let at = |cell: u16| body.rest_position(body.origin(cell.into()) as u16);
        let [a, b, c] = triangle.map(at);
        assert!(dot(cross(sub(b, a), sub(c, a)), sub(at(cells[opposite]), a)) < 0.0);
    }
    (count, lacking)
}

/// Opened faces whose cells differ are listed, each with both sides, outward, by ascending name; no other is. Those
/// without a place are counted.
#[test]
fn opened_faces_are_listed_with_both_sides() {
    let (mut splits, mut most, mut lacked) = (0, 0, 0);
    cut_at_random(|body, look, _| {
        splits += usize::from(matches!(look, Look::Split(_)));
        if splits % 29 != 1 {
            return;
        }
        let (count, lacking) = check_opened(body);
        (most, lacked) = (most.max(count), lacked.max(lacking));
        // From here on the body has fewer places, an odd number.
        if count > 60 {
            let names = core::mem::take(&mut body.arrays.names);
            body.arrays.names = &mut names[..31];
            assert_eq!(check_opened(body).0, 30);
        }
    });
    std::println!("{most} triangles, {lacked} faces without a place");
    assert!(most > 60 && lacked > 10);
}

/// Triangles of opened faces have the contact numbers that a bake gives to those of the surface.
#[test]
fn contact_numbers_are_those_of_the_bake() {
    let model = Model::from_bytes(IMAGE).unwrap();
    let mut words = std::vec![0; cut_words(&model)];
    let mut memory = CutRoom::new(&mut words);
    let mut body = CutBody::of(&mut memory, &model).unwrap();
    body.reset();
    for (triangle, baked) in model.triangles.iter().zip(model.contact.unwrap()) {
        for (number, baked) in body.contact_numbers(*triangle).iter().zip(baked) {
            assert!((number / baked - 1.0).abs() < 1e-5, "{number} {baked}");
        }
    }
}

#[test]
fn numbers_are_those_of_the_bake() {
    let model = Model::from_bytes(IMAGE).unwrap();
    let mut words = std::vec![0; cut_words(&model)];
    let mut memory = CutRoom::new(&mut words);
    let mut body = CutBody::of(&mut memory, &model).unwrap();
    body.reset();
    let baked = crate::model::others::shapes(&model.others);
    (0..body.bodily).for_each(|cell| body.renumber(cell));
    let now = body.shapes();
    for cell in 0..body.bodily {
        for row in 0..nodal::CELL_ROWS {
            let [a, b] = [now.number(cell, row), baked.number(cell, row)];
            assert!(
                (a - b).abs() <= 1e-6 * baked.number(cell, nodal::BOUND),
                "{cell} {row}: {a} {b}"
            );
        }
        for (other, slot) in baked.slots_of(cell).filter(|(other, _)| *other != cell) {
            let (_, again) = now.slots_of(cell).find(|(id, _)| *id == other).unwrap();
            for row in 0..nodal::SLOT_ROWS {
                let [a, b] = [again.number(row), slot.number(row)];
                assert!((a - b).abs() < 2e-6, "{cell} {other} {row}: {a} {b}");
            }
        }
    }
}

#[test]
fn copies_have_the_weights_of_their_originals() {
    let mut copies = 0;
    cut_at_random(|body, look, _| {
        if body.used() < 40 || copies > 100 || !matches!(look, Look::Split(_)) {
            return;
        }
        let basis = body.model.coarse_basis.unwrap();
        let now = basis.with_cells(
            body.arrays.box_rows,
            body.arrays.pairs,
            body.arrays.weights,
            body.arrays.entry,
            body.arrays.factors,
        );
        for cell in 0..body.bodily + body.used() {
            let whole: Vec<_> = basis.row_of(body.origin(cell)).collect();
            let part: Vec<_> = now.row_of(cell).collect();
            assert_eq!(whole, part);
            copies += usize::from(cell >= body.bodily && !part.is_empty());
        }
    });
    assert!(copies > 30, "{copies}");
}
