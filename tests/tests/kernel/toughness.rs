//! A body whose parts differ in toughness: a blade presses with that of the tissue where it is, and the work is summed
//! by it.
#![allow(clippy::unwrap_used)]

use std::ops::Range;

use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BasisSpacing, ImageBytes, PerCell};
use chaincell_kernel::Flags;

use crate::blade::{ACROSS, drawn, made_of, sheet, under};

/// Toughness of the two halves of the slab in the order in which the edge passes them.
const SOFT_FIRST: [f32; 2] = [2.0, 8.0];
const TOUGH_FIRST: [f32; 2] = [8.0, 2.0];
/// Ticks in which the edge is in whole tissue and its fronts are in one of the halves.
const WITHIN: [Range<usize>; 2] = [60..100, 190..250];
const THICKNESS_M: f32 = 0.01;
/// A sample at the slab's side stands for all of its length: one spacing more at most, as in a slab of one toughness.
const SAMPLE_M: f32 = 4.0 * 0.0011;
/// Largest step of the force from tick to tick over its limit in the tougher half, where faces open: on the way into
/// that half, and out of it, where the slab springs back.
const STEPS: [f32; 2] = [0.078, 0.15];
/// Largest share of the hand's work that is neither cut nor stored, on the same ways.
const LOST: [f64; 2] = [0.12, 0.16];

/// The slab of two halves, in the way of an edge that is drawn towards y.
fn slab(halves_j_per_m2: [f32; 2], is_of_links: bool) -> ImageBytes {
    let (mesh, ends) = sheet();
    let half = |place: &[f64; 3]| halves_j_per_m2[usize::from(place[1] > -0.001)].into();
    let toughness = PerCell::Each(mesh.nodes_m.iter().map(half).collect());
    let tissue = Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3));
    let tissue = (!is_of_links).then_some(tissue);
    made_of(tissue, &mesh, &ends, toughness, BasisSpacing::BySize)
}

#[test]
fn a_drawn_blade_has_the_force_of_each_half() {
    for (halves_j_per_m2, is_of_links) in
        [(SOFT_FIRST, false), (SOFT_FIRST, true), (TOUGH_FIRST, false), (TOUGH_FIRST, true)]
    {
        let image = slab(halves_j_per_m2, is_of_links);
        let mut bench = under(&image, 4, &[ACROSS]);
        let (mut work_j, mut stored_j) = (0.0, 0.0);
        let mut halves_n = [const { Vec::new() }; 2];
        let (mut last_n, mut step_n, mut rolled_back) = (0.0, 0.0_f32, 0);
        for tick in 0..250 {
            let output = bench.tick(drawn(tick));
            let force_n = -output.force_n.y;
            work_j += f64::from(output.work_j);
            stored_j = f64::from(output.energy_j);
            rolled_back += u32::from(output.flags.contains(Flags::ROLLED_BACK));
            if let Some(half) = WITHIN.iter().position(|ticks| ticks.contains(&tick)) {
                halves_n[half].push(force_n);
            }
            step_n = if tick > 60 { step_n.max((force_n - last_n).abs()) } else { 0.0 };
            last_n = force_n;
        }
        let cuts = bench.cuts();
        let lost = 1.0 - (f64::from(cuts.work_j) + stored_j) / work_j;
        let means_n = halves_n.map(|all| all.iter().sum::<f32>() / all.len() as f32);
        println!(
            "{halves_j_per_m2:?}, links {is_of_links}: {means_n:?} N, largest step {step_n:.5} N, {rolled_back} passes discarded, \
             {work_j:.3e} J of the hand, {:.1} % neither cut nor stored, {cuts:?}",
            100.0 * lost
        );
        for (mean_n, toughness) in means_n.into_iter().zip(halves_j_per_m2) {
            let range = 0.99 * toughness * THICKNESS_M..toughness * (THICKNESS_M + SAMPLE_M);
            assert!(range.contains(&mean_n), "{means_n:?}");
        }
        // Within a row of elements the limit goes from one to the other, 2 % of the larger in a tenth of a millimetre.
        let is_out = usize::from(halves_j_per_m2 == TOUGH_FIRST);
        assert!(step_n < STEPS[is_out] * means_n[0].max(means_n[1]), "{step_n} {means_n:?}");
        assert!((-0.003..LOST[is_out]).contains(&lost), "{lost}");
        assert!(cuts.opened_faces > 30 && cuts.copies > 20, "{cuts:?}");
    }
}

/// The work is that of each half, and not that of one toughness for all of the area.
#[test]
fn the_work_is_summed_where_the_blade_cuts() {
    let image = slab(SOFT_FIRST, false);
    let mut bench = under(&image, 4, &[ACROSS]);
    let mut cuts = Vec::new();
    for tick in 0..250 {
        let before = bench.cuts();
        bench.tick(drawn(tick));
        let after = bench.cuts();
        cuts.push((after.area_m2 - before.area_m2, after.work_j - before.work_j));
    }
    for (ticks, toughness) in WITHIN.into_iter().zip(SOFT_FIRST) {
        let (area_m2, work_j) =
            cuts[ticks].iter().fold((0.0, 0.0), |sum, now| (sum.0 + now.0, sum.1 + now.1));
        assert!(
            (work_j / area_m2 / toughness - 1.0).abs() < 1e-3,
            "{toughness}: {work_j} {area_m2}"
        );
    }
    // A reset forgets it.
    let network = bench.network;
    bench.view().reset(&network).unwrap();
    assert_eq!(bench.cuts().work_j, 0.0);
}

#[test]
fn a_cut_between_the_halves_goes_on_from_a_snapshot_with_the_same_bits() {
    let image = slab(SOFT_FIRST, false);
    let mut bench = under(&image, 3, &[ACROSS]);
    let mut scalar = under(&image, 3, &[ACROSS]);
    scalar.view().go_scalar();
    let network = bench.network;
    let (mut bytes, mut all) = (Vec::new(), [const { Vec::new() }; 2]);
    for tick in 0..180 {
        if tick == 110 {
            bytes = vec![0; bench.view().snapshot_bytes(&network).unwrap()];
            bench.view().save(&network, &mut bytes).unwrap();
        }
        for (bench, all) in [&mut bench, &mut scalar].into_iter().zip(&mut all) {
            let force_n = bench.tick(drawn(tick)).force_n;
            all.push((bench.hash(), force_n, bench.cuts().work_j));
        }
    }
    assert!(bench.cuts().opened_faces > 20);
    assert_eq!(all[0], all[1]);
    let mut other = under(&image, 3, &[ACROSS]);
    other.view().restore(&network, &bytes).unwrap();
    for (tick, expected) in (0..180).zip(&all[0]).skip(110) {
        let force_n = other.tick(drawn(tick)).force_n;
        assert_eq!((other.hash(), force_n, other.cuts().work_j), *expected, "{tick}");
    }
}
