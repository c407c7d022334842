//! Splits of a body of links in random states.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::vec::Vec;

use super::body::CutBody;
use super::memory::{CutRoom, cut_words};
use super::random::Random;
use super::split::Look;
use crate::energy::residual::places;
use crate::energy::state::States;
use crate::model::{Model, range};
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// A block of 4 x 4 x 3 nodes with a spare cell for each; links differ in weight and in band.
static IMAGE: &[u8] = crate::include_model!("../../../tests/data/links4.chaincell");

/// The half-links of a body: both ends, with the bits of rest length, weight and half-width of the band.
fn half_links(body: &CutBody<'_, '_>) -> BTreeMap<[u16; 2], [u32; 3]> {
    let mut all = BTreeMap::new();
    let links = &body.arrays.links;
    for cell in 0..body.arrays.rest.len() {
        let (lane, mut last) = (cell % LANES, None);
        for group in range(body.arrays.rows, cell / LANES) {
            let end = body.arrays.ids[group][lane];
            let numbers = [&links.lengths, &links.weights, &links.alphas];
            let numbers = numbers.map(|numbers| numbers[group][lane].to_bits());
            if usize::from(end) == cell {
                assert_eq!(numbers, [0.0, 1.0, 0.0].map(f32::to_bits));
                continue;
            }
            assert!(last < Some(end), "{cell}: {last:?} {end}");
            last = Some(end);
            all.insert([cell as u16, end], numbers);
        }
    }
    all
}

/// Four times the energy of the links in double precision.
fn energy(links: &BTreeMap<[u16; 2], [u32; 3]>, state: &[Cell], is_closed: bool) -> f64 {
    let of = |(&[i, j], numbers): (&[u16; 2], &[u32; 3])| {
        let [length, weight, alpha] = numbers.map(|bits| f64::from(f32::from_bits(bits)));
        let alpha = if is_closed { 0.0 } else { alpha };
        let at = |cell: u16| state[usize::from(cell)].xyz().map(f64::from);
        let way = at(i).into_iter().zip(at(j)).map(|(a, b)| (a - b) * (a - b));
        let stretch = way.sum::<f64>().sqrt() / length - 1.0;
        let beyond = (stretch.abs() - alpha).max(0.0) * length;
        if i < j { weight * beyond * beyond } else { 0.0 }
    };
    links.iter().map(of).sum()
}

/// Runs `each` with every split: the body after it, its half-links and those before, and the state.
fn cut_at_random(
    mut each: impl FnMut(
        &mut CutBody<'_, '_>,
        Look,
        &BTreeMap<[u16; 2], [u32; 3]>,
        &BTreeMap<[u16; 2], [u32; 3]>,
        &[Cell],
    ),
) {
    let model = Model::from_bytes(IMAGE).unwrap();
    let (cells, tetrahedra) = (model.cells(), model.tetrahedra_to_cut());
    let mut random = Random(11);
    for _ in 0..12 {
        let mut words = std::vec![0xAAAA_AAAA; cut_words(&model)];
        let mut memory = CutRoom::new(&mut words);
        let mut body = CutBody::of(&mut memory, &model).unwrap();
        body.reset();
        let mut state: Vec<Cell> = model.rest.iter().map(|&rest| Cell::at(rest)).collect();
        for _ in 0..80 {
            for v in &mut state[..body.bodily + body.used()] {
                *v = Cell::at(v.xyz().map(|x| x + 0.05 * random.next()));
            }
            for _ in 0..6 {
                body.open_face(random.below(tetrahedra), random.below(4)).unwrap();
            }
            for cell in (0..cells).filter(|&cell| body.arrays.marks[cell] == 1).collect::<Vec<_>>()
            {
                body.mark(cell, 0);
                let before = half_links(&body);
                let first = body.bodily + body.used();
                let look = body.look(cell, &places(&model, &state), States::NONE);
                for copy in first..body.bodily + body.used() {
                    state[copy] = state[cell];
                }
                let after = half_links(&body);
                each(&mut body, look, &before, &after, &state);
            }
        }
    }
}

/// A split leaves the energy, with open and with closed bands, but for what the level takes.
#[test]
fn the_shares_of_links_store_what_the_links_do() {
    let (mut splits, mut refused) = (0, 0);
    cut_at_random(|_, look, before, after, state| match look {
        Look::Split(change) => {
            splits += 1;
            for is_closed in [false, true] {
                let [before, after] =
                    [before, after].map(|links| 0.25 * energy(links, state, is_closed));
                assert!((after - before).abs() <= 1e-6 * before, "{before} {after}");
                // The bound that the level takes is one, and small beside the energy with closed bands.
                assert!(change >= after - before, "{before} {after} {change}");
                assert!(!is_closed || change < 1e-5 * before, "{change} {before}");
            }
        }
        _ => {
            refused += usize::from(look == Look::Refused);
            assert!(before == after);
        }
    });
    std::println!("{splits} splits, {refused} refused");
    assert!(splits > 300 && refused > 20, "{splits} {refused}");
}

/// Both half-links of a link are the same bit by bit, and no cell has more weight than the one of the image.
#[test]
fn shares_are_symmetric_and_never_more_than_the_whole() {
    let mut shared = 0;
    cut_at_random(|body, look, _, after, _| {
        if !matches!(look, Look::Split(_)) {
            return;
        }
        let (model, mut weights) = (body.model, std::vec![0.0; body.arrays.rest.len()]);
        let mut shares: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for (&[i, j], numbers) in after {
            assert_eq!(after.get(&[j, i]), Some(numbers), "{i} {j}");
            let weight = f64::from(f32::from_bits(numbers[1]));
            weights[usize::from(i)] += weight;
            *shares.entry([i, j].map(|cell| body.origin(cell.into()))).or_default() += weight;
        }
        for (cell, weight) in weights.iter().enumerate().take(body.bodily + body.used()) {
            let origin = body.origin(cell);
            let whole =
                model.neighbours(origin).map(|(link, _)| f64::from(model.link_weight(link)));
            assert!(*weight <= whole.sum::<f64>() * (1.0 + 1e-12), "{cell}");
        }
        for cell in 0..body.bodily {
            for (link, other) in model.neighbours(cell) {
                let (share, whole) = (shares[&[cell, other]], f64::from(model.link_weight(link)));
                assert!(share <= whole && share > (1.0 - 1e-6) * whole, "{share} {whole}");
                shared += usize::from(share < whole);
            }
        }
    });
    assert!(shared > 100, "{shared}");
}

/// Half-links follow from the state alone, and the links by their ends from the half-links.
#[test]
fn links_follow_from_the_state() {
    let mut splits = 0;
    cut_at_random(|body, look, _, after, _| {
        splits += usize::from(matches!(look, Look::Split(_)));
        if splits % 17 != 1 {
            return;
        }
        body.derive();
        assert!(*after == half_links(body));
        let mut words = std::vec![0; cut_words(body.model)];
        let mut memory = CutRoom::new(&mut words);
        let mut copy = CutBody::of(&mut memory, body.model).unwrap();
        copy.reset();
        copy.arrays.counts.copy_from_slice(&*body.arrays.counts);
        copy.arrays.corners.copy_from_slice(body.arrays.corners);
        copy.arrays.origins.copy_from_slice(body.arrays.origins);
        copy.arrays.rows.copy_from_slice(body.arrays.rows);
        copy.arrays.faces.copy_from_slice(body.arrays.faces);
        copy.derive();
        let model = copy.into_model();
        let (mut links, cells) = (0, model.cells());
        for cell in 0..cells {
            let ends: Vec<u16> = after
                .keys()
                .filter(|[one, _]| usize::from(*one) == cell)
                .map(|ends| ends[1])
                .collect();
            let neighbours: Vec<u16> =
                model.neighbours(cell).map(|(_, other)| other as u16).collect();
            assert_eq!(neighbours, ends, "{cell}");
            for (link, other) in model.neighbours(cell) {
                links += usize::from(other > cell);
                let numbers =
                    [model.rest_length[link], model.link_weight(link), model.link_alpha(link)];
                let ends = [cell as u16, other as u16];
                assert_eq!(after.get(&ends), Some(&numbers.map(f32::to_bits)), "{ends:?}");
            }
        }
        assert_eq!(links, model.links());
    });
    assert!(splits > 300, "{splits}");
}

/// A renumbered whole body is the one of the image, with the contact numbers that the bake gives to the surface.
#[test]
fn links_of_a_whole_body_are_those_of_the_bake() {
    let model = Model::from_bytes(IMAGE).unwrap();
    let mut words = std::vec![0; cut_words(&model)];
    let mut memory = CutRoom::new(&mut words);
    let mut body = CutBody::of(&mut memory, &model).unwrap();
    body.reset();
    let before = half_links(&body);
    (0..body.bodily).for_each(|cell| body.renumber(cell));
    assert!(before == half_links(&body));
    assert_eq!(before.len(), 2 * model.links());
    for (triangle, baked) in model.triangles.iter().zip(model.contact.unwrap()) {
        for (number, baked) in body.contact_numbers(*triangle).iter().zip(baked) {
            assert!((number / baked - 1.0).abs() < 1e-5, "{number} {baked}");
        }
    }
}
