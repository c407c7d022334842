//! Stiffening bands at the splits of a body in random states.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use super::body::CutBody;
use super::memory::{CutRoom, cut_words};
use super::split::Look;
use super::tests::{BANDS, cut_at_random_in, energy_of_bands};
use crate::energy::residual::places;
use crate::model::image::nodal;
use crate::model::stiffening::Stiffening;
use crate::model::{Model, others};

/// Bodies that are cut at random.
const BODIES: usize = 12;

/// The half-links of a body: both ends, with the bits of volume and rest length; of padding both are 0.
fn half_links(bands: Stiffening<'_>) -> BTreeMap<[usize; 2], [u32; 2]> {
    let mut all = BTreeMap::new();
    let number = |numbers, group, cell| Stiffening::at(numbers, group, cell).to_bits();
    for cell in 0..bands.rest.len() {
        let slots = bands.slots_of(cell);
        let numbers = slots.map(|(group, other)| {
            let numbers = [bands.volumes, bands.lengths].map(|of| number(of, group, cell));
            ([cell, other], numbers)
        });
        all.extend(numbers);
    }
    let used = *bands.rows.last().unwrap() as usize;
    let places = bands.volumes[..used].iter().chain(&bands.lengths[..used]).flatten();
    assert_eq!(places.filter(|&&number| number != 0.0).count(), 2 * all.len());
    all
}

/// The shares of a link have its rest length, and together the link's weight, rounded down. Where copies lie where
/// their cells lie they store what the whole body stores, with open and with closed bands.
#[test]
fn the_shares_of_bands_store_what_the_bands_do() {
    let (mut splits, mut shared) = (0, 0);
    cut_at_random_in(BANDS, BODIES, |body, look, _, state| {
        splits += usize::from(matches!(look, Look::Split(_)));
        if splits % 5 != 1 || !matches!(look, Look::Split(_)) {
            return;
        }
        let (now, whole) = (body.bands(), others::bands(&body.model.others));
        let (mut sums, links) = (BTreeMap::<[usize; 2], f64>::new(), half_links(whole));
        let volume = |bits: [u32; 2]| f64::from(f32::from_bits(bits[0]));
        let halves = half_links(now);
        for (&[i, j], &numbers) in &halves {
            let origins = [i, j].map(|cell| body.origin(cell));
            assert_eq!(halves.get(&[j, i]), Some(&numbers), "{i} {j}");
            assert_eq!(links[&origins][1], numbers[1], "{i} {j}");
            *sums.entry(origins).or_default() += volume(numbers);
        }
        for (ends, &numbers) in &links {
            let (sum, whole) = (sums[ends], volume(numbers));
            assert!(sum <= whole && sum > (1.0 - 1e-6) * whole, "{ends:?}: {sum} {whole}");
            shared += usize::from(sum < whole);
        }
        for cell in 0..body.bodily + body.used() {
            let origin = body.origin(cell);
            assert!(now.weight(cell) <= (1.0 + 1e-6) * whole.weight(origin), "{cell}");
        }
        let at = |cell: usize| state[body.origin(cell)].xyz();
        for is_closed in [false, true] {
            let energies = [now, whole].map(|bands| energy_of_bands(bands, &at, is_closed));
            let off = energies[1] - energies[0];
            assert!(off.abs() <= 1e-6 * energies[1], "{energies:?}");
        }
    });
    std::println!("{splits} splits, {shared} links whose shares are rounded down");
    assert!(splits > 300 && shared > 100, "{splits} {shared}");
}

/// Bands follow from the state alone, and those of a whole body are the bake's.
#[test]
fn bands_follow_from_the_state() {
    let mut splits = 0;
    cut_at_random_in(BANDS, BODIES, |body, look, _, _| {
        splits += usize::from(matches!(look, Look::Split(_)));
        if splits % 17 != 1 {
            return;
        }
        let before = half_links(body.bands());
        body.derive();
        assert!(before == half_links(body.bands()));
        // Another one's memory comes to the same.
        let mut words = std::vec![0xAAAA_AAAA; cut_words(body.model)];
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
        assert!(before == half_links(others::bands(&model.others)));
    });
    assert!(splits > 300, "{splits}");
    let model = Model::from_bytes(BANDS).unwrap();
    let mut words = std::vec![0; cut_words(&model)];
    let mut memory = CutRoom::new(&mut words);
    let mut body = CutBody::of(&mut memory, &model).unwrap();
    body.reset();
    (0..body.bodily).for_each(|cell| body.renumber(cell));
    assert!(half_links(body.bands()) == half_links(others::bands(&model.others)));
}

/// The tears' energy of the bands adds up to that of the body.
#[test]
fn the_energy_of_tears_adds_up() {
    let mut splits = 0;
    cut_at_random_in(BANDS, BODIES, |body, look, _, state| {
        splits += usize::from(matches!(look, Look::Split(_)));
        if splits % 29 != 1 {
            return;
        }
        let (bands, at) = (body.bands(), places(body.model, state));
        let of = |cell: usize| {
            let volume = body.number(cell, nodal::VOLUME);
            f64::from(volume * bands.energy_density(cell, volume, &at))
        };
        let (sum, stored): (f64, f64) =
            ((0..bands.rest.len()).map(of).sum(), energy_of_bands(bands, &at, false));
        assert!((sum - stored).abs() <= 1e-5 * stored, "{sum} {stored}");
    });
    assert!(splits > 300, "{splits}");
}
