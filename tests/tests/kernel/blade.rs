//! The edge of a blade: it presses with the tissue's toughness, opens the faces that it passes, and the account
//! of the hand's work closes.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{
    Budget, ContactError, CutOutput, Cutting, Flags, Network, Settings, ToolPart, ToolPose,
};
use chaincell_tests::bodies::model;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::bench::Bench;

/// A slab of tissue, 60 x 36 x 16 mm, fixed at its ground: 4 mm between nodes.
const SLAB: &str = "box:16x10x5x0.004";
const CELLS: usize = 1400;

pub fn mesh() -> Mesh {
    load(SLAB, &MeshOptions::default()).unwrap()
}

/// The slab, fixed at its ground.
pub fn image(mesh: &Mesh, toughness_j_per_m2: f64, coarse_basis: BasisSpacing) -> ImageBytes {
    image_of(mesh, &mesh.default_fixed, toughness_j_per_m2, coarse_basis)
}

fn image_of(
    mesh: &Mesh,
    fixed: &[u32],
    toughness_j_per_m2: f64,
    coarse_basis: BasisSpacing,
) -> ImageBytes {
    let tissue = Some(Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3)));
    made_of(tissue, mesh, fixed, PerCell::Uniform(toughness_j_per_m2), coarse_basis)
}

/// A body of tissue, or else of links, which make one of about 6 kPa here.
pub fn made_of(
    tissue: Option<Material>,
    mesh: &Mesh,
    fixed: &[u32],
    toughness_j_per_m2: PerCell,
    coarse_basis: BasisSpacing,
) -> ImageBytes {
    let cuttable = Cuttable { spare_share: 0.5, toughness_j_per_m2, ..Cuttable::default() };
    let cuttable = Some(cuttable);
    let options = BakeOptions { tissue, cuttable, coarse_basis, ..BakeOptions::default() };
    bake(mesh, fixed, &options).unwrap()
}

/// A body under a blade.
pub fn under<'a>(image: &'a ImageBytes, sweeps: u16, tool: &[ToolPart]) -> Bench<'a> {
    let model = model(image);
    let settings = Settings { sweeps, max_force_n: 100.0, ..Settings::for_model(&model) };
    Bench::under(Network::new(model, settings).unwrap(), &[tool], 0.0)
}

/// A way down through the slab, 20 mm/s, from 1 mm above it.
fn down(tick: usize) -> [f32; 3] {
    [0.0007, 0.0003, 0.017 - 2.0e-5 * tick as f32]
}

/// The tetrahedra that a walk over shared cells reaches from the first one.
fn reached(bench: &mut Bench<'_>, mesh: &Mesh) -> usize {
    let network = bench.network;
    let mut cells = |at: usize| -> Vec<u16> {
        let view = |corner| bench.view().cell_of_corner(&network, at, corner).unwrap();
        (0..4).map(view).collect()
    };
    let corners: Vec<Vec<u16>> = (0..mesh.tetrahedra.len()).map(&mut cells).collect();
    let mut known = vec![false; corners.len()];
    let mut is_near = vec![false; CELLS];
    known[0] = true;
    loop {
        for (corners, _) in corners.iter().zip(&known).filter(|(_, known)| **known) {
            corners.iter().for_each(|&cell| is_near[usize::from(cell)] = true);
        }
        let before = known.iter().filter(|known| **known).count();
        for (corners, known) in corners.iter().zip(&mut known) {
            *known |= corners.iter().any(|&cell| is_near[usize::from(cell)]);
        }
        if known.iter().filter(|known| **known).count() == before {
            return before;
        }
    }
}

/// A blade longer than the slab, which cuts down.
const BLADE: ToolPart = ToolPart::edge(0.032);
/// Toughness times the width of the slab \[N\].
const LIMIT_N: f32 = 4.0 * 0.06;

/// Faces between tetrahedra whose middles lie on two sides of the blade's plane.
fn faces_across(mesh: &Mesh) -> usize {
    let mut sides: BTreeMap<Vec<u32>, Vec<bool>> = BTreeMap::new();
    for nodes in &mesh.tetrahedra {
        let y_m = nodes.map(|node| mesh.nodes_m[node as usize][1]).iter().sum::<f64>() / 4.0;
        for corner in 0..4 {
            let mut face: Vec<u32> =
                (0..4).filter(|&at| at != corner).map(|at| nodes[at]).collect();
            face.sort_unstable();
            sides.entry(face).or_default().push(y_m < f64::from(down(0)[1]));
        }
    }
    sides.values().filter(|sides| matches!(sides[..], [a, b] if a != b)).count()
}

#[test]
fn a_blade_drawn_through_the_slab_parts_it() {
    let mesh = mesh();
    for (coarse, largest_step) in [(BasisSpacing::None, 0.2), (BasisSpacing::BySize, 0.15)] {
        is_parted(&mesh, &image(&mesh, 4.0, coarse), largest_step);
    }
}

/// The slab of links: no split raises the energy, and the blade presses with the toughness.
#[test]
fn a_blade_drawn_through_links_parts_them() {
    let mesh = mesh();
    for (coarse, largest_step) in [(BasisSpacing::None, 0.2), (BasisSpacing::Links(3.0), 0.15)] {
        is_parted(
            &mesh,
            &made_of(None, &mesh, &mesh.default_fixed, PerCell::Uniform(4.0), coarse),
            largest_step,
        );
    }
}

fn is_parted(mesh: &Mesh, image: &ImageBytes, largest_step: f32) {
    let mut bench = under(image, 8, &[BLADE]);
    let (mut work_j, mut most_n, mut step_n, mut last_n) = (0.0, 0.0_f32, 0.0_f32, 0.0_f32);
    let (mut stored_j, mut rolled_back) = (0.0, 0);
    for tick in 0..1000 {
        let output = bench.tick(down(tick));
        work_j += f64::from(output.work_j);
        most_n = most_n.max(output.force_n.z);
        rolled_back += u32::from(output.flags.contains(Flags::ROLLED_BACK));
        if (150..700).contains(&tick) {
            step_n = step_n.max((output.force_n.z - last_n).abs());
        }
        last_n = output.force_n.z;
        // The hand's work is in the body, or has parted it, or is lost: never less than nothing.
        stored_j = f64::from(output.energy_j);
        let cut_j = f64::from(bench.cuts().work_j);
        let most_j = 1.003 * work_j + 1e-6;
        assert!(stored_j + cut_j < most_j, "{tick}: {stored_j} {cut_j} {work_j}");
    }
    let (cuts, side) = (bench.cuts(), reached(&mut bench, mesh));
    let lost = 1.0 - f64::from(cuts.work_j) / work_j;
    println!(
        "{work_j:.3e} J of the hand, {:.1} % neither cut nor stored, largest force {most_n:.4} N of \
         {LIMIT_N}, largest step {:.1} %, {rolled_back} of 8000 passes discarded, {cuts:?}",
        100.0 * lost,
        100.0 * step_n / LIMIT_N,
    );
    assert!(most_n <= 1.0001 * LIMIT_N && most_n > 0.95 * LIMIT_N, "{most_n}");
    assert!(step_n < largest_step * LIMIT_N && lost < 0.15 && stored_j < 0.01 * work_j);
    assert_eq!(cuts.opened_faces as usize, faces_across(mesh));
    assert_eq!((cuts.refused, cuts.waiting), (0, 0));
    // The first tetrahedron's side hangs together, and with nothing of the other one.
    let is_low = |nodes: &[u32; 4]| {
        let y_m = nodes.map(|node| mesh.nodes_m[node as usize][1]).iter().sum::<f64>() / 4.0;
        y_m < f64::from(down(0)[1])
    };
    let first = is_low(&mesh.tetrahedra[0]);
    let its = mesh.tetrahedra.iter().filter(|nodes| is_low(nodes) == first).count();
    assert!(side == its && its < mesh.tetrahedra.len(), "{side} of {its}");
    let area_m2 = 0.06 * 0.016;
    let share = f64::from(cuts.area_m2) / area_m2;
    assert!((0.75..1.05).contains(&share), "{share}: the tissue was pressed as it was cut");
}

/// With cutting off a blade feels nothing and cuts nothing; in mid-cut it leaves the tissue at once, and takes hold
/// again only from outside.
#[test]
fn with_cutting_off_a_blade_feels_nothing() {
    let image = image(&mesh(), 4.0, BasisSpacing::BySize);
    let mut bench = under(&image, 4, &[BLADE]);
    let on = bench.network;
    let settings = Settings { cut: Cutting::Off, ..*on.settings() };
    let off = Network::new(bench.model(), settings).unwrap();
    bench.network = off;
    for tick in 0..400 {
        let output = bench.tick(down(tick));
        assert_eq!((output.force_n.norm(), output.work_j), (0.0, 0.0), "{tick}");
    }
    assert_eq!(bench.cuts(), CutOutput::default());
    let mut bench = under(&image, 4, &[BLADE]);
    let mut before = bench.tick(down(0));
    for tick in 1..300 {
        before = bench.tick(down(tick));
    }
    let cuts = bench.cuts();
    assert!(before.force_n.z > 0.9 * LIMIT_N && cuts.opened_faces > 0, "{before:?} {cuts:?}");
    bench.network = off;
    for tick in 300..600 {
        let output = bench.tick(down(tick));
        // The first of these moves is half of a tick with a force.
        let work_j = if tick == 300 { output.work_j } else { 0.0 };
        assert_eq!((output.force_n.norm(), output.work_j), (0.0, work_j), "{tick}");
        assert!(output.energy_j <= before.energy_j + 1e-12, "{tick}: {output:?} {before:?}");
        before = output;
    }
    let after = bench.cuts();
    assert_eq!((after.opened_faces, after.area_m2), (cuts.opened_faces, cuts.area_m2));
    // Deep inside it takes no hold.
    bench.network = on;
    (600..700).for_each(|tick| assert_eq!(bench.tick(down(tick)).force_n.norm(), 0.0, "{tick}"));
}

/// Ticks with the edge 4 mm deep, then drawn back by 3 mm and in again.
#[test]
fn a_blade_drawn_back_feels_nothing_until_it_is_at_its_front_again() {
    let image = image(&mesh(), 4.0, BasisSpacing::BySize);
    let mut bench = under(&image, 8, &[ToolPart::edge(0.02)]);
    for tick in 0..300 {
        bench.tick(down(tick));
    }
    let before = bench.cuts();
    assert!(before.area_m2 > 0.0 && before.opened_faces > 0);
    let back: Vec<f32> = (150..300).rev().map(|tick| bench.tick(down(tick)).force_n.z).collect();
    assert!(back[100..].iter().all(|force_n| *force_n == 0.0), "{back:?}");
    let again: Vec<f32> = (150..300).map(|tick| bench.tick(down(tick)).force_n.z).collect();
    assert!(again[..50].iter().all(|force_n| *force_n == 0.0), "{again:?}");
    let after = bench.cuts();
    assert!(after.area_m2 < 1.1 * before.area_m2, "{before:?} {after:?}");
    // Disengaged it is nowhere.
    let network = bench.network;
    let away = [ToolPose::at(down(300).into(), 0)];
    let output = bench.view().tick(&network, &away, Budget::All);
    assert_eq!((output.force_n.z, output.contacts), (0.0, 0));
}

#[test]
fn a_back_a_late_tick_and_a_blade_that_is_away_cut_nothing() {
    let image = image(&mesh(), 4.0, BasisSpacing::BySize);
    // Turned about x by half a turn it meets the slab with its back.
    let back = ToolPart { orientation: [1.0, 0.0, 0.0, 0.0], ..BLADE };
    let mut bench = under(&image, 4, &[back]);
    for tick in 0..200 {
        assert_eq!(bench.tick(down(tick)).contacts, 0);
    }
    assert_eq!(bench.cuts(), CutOutput::default());
    let mut bench = under(&image, 4, &[BLADE]);
    let network = bench.network;
    for tick in 0..200 {
        let place = down(tick).into();
        bench.view().tick(&network, &[ToolPose::at(place, 0)], Budget::All);
        assert_eq!(bench.cuts(), CutOutput::default());
    }
    for tick in 0..130 {
        bench.tick(down(tick));
    }
    let before = bench.cuts();
    assert!(before.area_m2 > 0.0);
    for tick in 130..180 {
        bench.view().tick(&network, &[ToolPose::at(down(tick).into(), 1)], Budget::LATE);
    }
    assert_eq!(bench.cuts(), before);
}

#[test]
fn a_cut_goes_on_from_a_snapshot_with_the_same_bits_on_any_unit() {
    let image = image(&mesh(), 4.0, BasisSpacing::BySize);
    let mut bench = under(&image, 3, &[BLADE]);
    let mut scalar = under(&image, 3, &[BLADE]);
    scalar.view().go_scalar();
    let network = bench.network;
    let mut bytes = Vec::new();
    let mut hashes = [const { Vec::new() }; 2];
    for tick in 0..260 {
        if tick == 190 {
            bytes = vec![0; bench.view().snapshot_bytes(&network).unwrap()];
            bench.view().save(&network, &mut bytes).unwrap();
        }
        for (bench, hashes) in [&mut bench, &mut scalar].into_iter().zip(&mut hashes) {
            let force_n = bench.tick(down(tick)).force_n;
            hashes.push((bench.view().state_hash(network.model()), force_n));
        }
    }
    assert!(bench.cuts().opened_faces > 0);
    assert_eq!(hashes[0], hashes[1]);
    let mut other = under(&image, 3, &[BLADE]);
    other.view().restore(&network, &bytes).unwrap();
    for (tick, (hash, force_n)) in (0..260).zip(&hashes[0]).skip(190) {
        assert_eq!(other.tick(down(tick)).force_n, *force_n, "{tick}");
        assert_eq!(other.view().state_hash(network.model()), *hash, "{tick}");
    }
    assert_eq!(other.cuts(), bench.cuts());
}

/// Area and mean force of a pass of a blade down into the slab, moved by `beside_m`, and out again; the hand's work
/// pays for the area.
fn pass(bench: &mut Bench<'_>, beside_m: f32, ticks: usize) -> (f64, f64) {
    let network = bench.network;
    let (before, mut work_j, mut sum_n) = (bench.cuts(), 0.0, 0.0);
    let back = (0..ticks / 4).rev().map(|tick| (4 * tick, 1));
    let ways = (0..ticks).map(|tick| (tick, 1)).chain(back).chain((0..300).map(|_| (0, 0)));
    for (at, (tick, engaged)) in ways.enumerate() {
        let [x, y, z] = down(tick);
        let pose = ToolPose::at([x, y + beside_m, z].into(), engaged);
        let output = bench.view().tick(&network, &[pose], Budget::All);
        work_j += f64::from(output.work_j);
        let is_in = (100..ticks).contains(&at);
        sum_n += if is_in { f64::from(output.force_n.z) } else { 0.0 };
    }
    let after = bench.cuts();
    let cut_j = f64::from(after.work_j - before.work_j);
    assert!(cut_j < 1.003 * work_j + 1e-6, "{beside_m}: {cut_j} J of {work_j}");
    (f64::from(after.area_m2 - before.area_m2), sum_n / (ticks - 100) as f64)
}

/// In an open wound a blade presses on nothing and sweeps nothing, up to half an edge from the wound's end; an edge
/// beside it, it cuts as in whole tissue. The second pass ends 1 mm before the first one's end.
#[test]
fn a_blade_in_an_open_wound_has_no_force() {
    let mesh = mesh();
    for is_of_links in [false, true] {
        let tissue = Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3));
        let tissue = (!is_of_links).then_some(tissue);
        let image =
            made_of(tissue, &mesh, &mesh.default_fixed, PerCell::Uniform(4.0), BasisSpacing::None);
        let edge_m = model(&image).unit_m();
        for (beside, shares) in [(0.0, 0.0..0.1), (0.1, 0.0..0.1), (1.0, 0.95..1.1)] {
            let mut bench = under(&image, 4, &[BLADE]);
            let (first_m2, first_n) = pass(&mut bench, 0.0, 650);
            let (again_m2, again_n) = pass(&mut bench, beside * edge_m, 600);
            let (area, force) = (again_m2 / first_m2, again_n / first_n);
            println!(
                "links {is_of_links}, {beside} edges beside: area {area:.3}, force {force:.3}"
            );
            // A pass that is 1 mm shorter has that much less to cut.
            let rest = first_m2 - 0.06 * 0.001;
            let area = if beside < 1.0 { area } else { again_m2 / rest };
            assert!(shares.contains(&area) && shares.contains(&force), "{beside}: {area} {force}");
        }
    }
}

#[test]
fn a_pose_that_jumps_through_the_tissue_cuts_nothing() {
    let image = image(&mesh(), 4.0, BasisSpacing::BySize);
    let mut bench = under(&image, 4, &[BLADE]);
    for tick in 0..130 {
        bench.tick(down(tick));
    }
    let before = bench.cuts();
    assert!(before.area_m2 > 0.0);
    let [x, y, z] = down(130);
    for jump_m in [[0.0, 0.0, -0.012], [0.0, 0.02, 0.0], [f32::NAN; 3], [0.0, -0.02, -0.006]] {
        let [dx, dy, dz] = jump_m;
        bench.tick([x + dx, y + dy, z + dz]);
        bench.tick([x, y, z]);
    }
    let half = ToolPose { orientation: [0.0, 0.7, 0.0, 0.7], ..ToolPose::at([x, y, z].into(), 1) };
    let network = bench.network;
    bench.view().tick(&network, &[half], Budget::All);
    for _ in 0..20 {
        bench.tick([x, y, z]);
    }
    let after = bench.cuts();
    // No more than the samples that enter anew press their fronts on.
    assert!(after.area_m2 < 1.3 * before.area_m2, "{before:?} {after:?}");
    assert_eq!(after.opened_faces, before.opened_faces);
}

/// Blades on random ways through the slab, turned at random: each goes in from outside for 120 ticks.
#[test]
fn random_cuts_stay_within_the_hands_work() {
    let mesh = mesh();
    let image = image(&mesh, 4.0, BasisSpacing::BySize);
    let mut random = Pcg64::seed_from_u64(7);
    let mut draw = move |most: f32| most * ((random.next_u32() >> 8) as f32 / 8_388_608.0 - 1.0);
    let mut bench = under(&image, 2, &[ToolPart::edge(0.012)]);
    let network = bench.network;
    let (mut work_j, mut ticks) = (0.0, 0);
    for stroke in 0..60 {
        let from = [draw(0.028), draw(0.016), 0.022];
        let way = [draw(4.0e-5), draw(4.0e-5), -1.3e-4];
        let orientation = [draw(0.35), draw(0.35), draw(1.0), 1.0];
        let length = orientation.iter().map(|x| x * x).sum::<f32>().sqrt();
        for tick in 0..=120_u16 {
            let at = |axis: usize| from[axis] + f32::from(tick) * way[axis];
            let pose = ToolPose {
                orientation: orientation.map(|x| x / length),
                ..ToolPose::at([at(0), at(1), at(2)].into(), u32::from(tick < 120))
            };
            let output = bench.view().tick(&network, &[pose], Budget::All);
            work_j += f64::from(output.work_j);
            ticks += 1;
            let kept_j = f64::from(output.energy_j) + f64::from(bench.cuts().work_j);
            assert!(kept_j < 1.02 * work_j + 1e-5, "{stroke} {tick}: {kept_j} {work_j}");
            assert!(output.force_n.iter().all(|x| x.abs() <= 4.0 * 0.024 * 1.001));
            assert!(output.energy_j.is_finite());
        }
    }
    let cuts = bench.cuts();
    println!("{ticks} ticks, work {work_j:.3e} J, {cuts:?}");
    assert!(cuts.copies > 100 && cuts.area_m2 > 0.0, "{cuts:?}");
    // The body still comes to rest.
    for _ in 0..2000 {
        bench.view().tick(&network, &[ToolPose::AWAY], Budget::All);
    }
    let output = bench.view().tick(&network, &[ToolPose::AWAY], Budget::All);
    assert!(output.energy_j < 1e-6, "{output:?}");
}

/// Blades that engage up to 1 mm below the surface and do not move: fronts begin, where the blade is.
#[test]
fn a_blade_that_engages_in_the_tissue_gives_no_energy() {
    let image = image(&mesh(), 4.0, BasisSpacing::BySize);
    let mut random = Pcg64::seed_from_u64(7);
    let mut draw = move |most: f32| most * ((random.next_u32() >> 8) as f32 / 8_388_608.0 - 1.0);
    let (mut area_m2, ahead) = (0.0, [0.0, 0.0, -1.0e-4]);
    for place in 0..20 {
        let mut bench = under(&image, 2, &[ToolPart::edge(0.012)]);
        let from = [draw(0.012), draw(0.012), 0.0155 + draw(0.0005)];
        for _ in 0..5 {
            let output = bench.tick(from);
            let given_j = bench.given_j();
            assert!(output.energy_j < 1e-10 && given_j < 1e-10, "{place}: {output:?} {given_j} J");
        }
        // It cuts from there on.
        for tick in 1..=30_u16 {
            bench.tick([0, 1, 2].map(|axis| from[axis] + f32::from(tick) * ahead[axis]));
        }
        area_m2 += bench.cuts().area_m2;
    }
    assert!(area_m2 > 20.0 * 0.024 * 0.001, "{area_m2} m^2");
}

#[test]
fn edges_that_cannot_be_are_refused() {
    let mesh = mesh();
    let image = image(&mesh, 4.0, BasisSpacing::BySize);
    let mut bench = under(&image, 1, &[BLADE]);
    let network = bench.network;
    let ball = ToolPart::sphere(0.004);
    for (tool, why) in [
        (vec![BLADE, ball], ContactError::Edge { tool: 0, part: 0 }),
        (vec![ball, BLADE, BLADE], ContactError::Edge { tool: 0, part: 1 }),
        (vec![ToolPart::edge(f32::INFINITY)], ContactError::Part { tool: 0, part: 0 }),
    ] {
        assert_eq!(bench.view().choose_tools(&network, &[&tool], 0.0), Err(why));
    }
    assert_eq!(bench.view().choose_tools(&network, &[&[ball, BLADE]], 0.0), Ok(()));
    // Without memory for cuts.
    bench.words.clear();
    let refused = bench.view().choose_tools(&network, &[&[BLADE]], 0.0);
    assert_eq!(refused, Err(ContactError::CannotCut));
}

/// A slab of 40 x 27 x 10 mm, and its nodes at both ends.
pub fn sheet() -> (Mesh, Vec<u32>) {
    let mesh = load("box:13x9x4x0.00333333", &MeshOptions::default()).unwrap();
    let nodes = (0..).zip(&mesh.nodes_m);
    let ends = nodes.filter(|(_, place)| place[0].abs() > 0.0199).map(|(node, _)| node).collect();
    (mesh, ends)
}

/// An edge along z that cuts towards y.
pub const ACROSS: ToolPart =
    ToolPart { orientation: [0.5, -0.5, 0.5, 0.5], ..ToolPart::edge(0.008) };

/// The way of that edge through the slab at 0.1 m/s.
pub fn drawn(tick: usize) -> [f32; 3] {
    [0.0003, -0.0140 + 1.0e-4 * tick as f32, 0.005]
}

/// The edge stands across a slab that is held at both ends, and is drawn through it.
#[test]
fn a_drawn_blade_has_the_force_of_the_toughness() {
    let (mesh, ends) = sheet();
    for (sweeps, coarse, is_of_links) in [
        (1, BasisSpacing::BySize, false),
        (4, BasisSpacing::None, false),
        (4, BasisSpacing::BySize, false),
        (4, BasisSpacing::BySize, true),
    ] {
        let tissue = Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3));
        let tissue = (!is_of_links).then_some(tissue);
        let image = made_of(tissue, &mesh, &ends, PerCell::Uniform(4.0), coarse);
        let mut bench = under(&image, sweeps, &[ACROSS]);
        let (mut work_j, mut stored_j, mut forces_n, mut rolled_back) = (0.0, 0.0, Vec::new(), 0);
        for tick in 0..260 {
            let output = bench.tick(drawn(tick));
            work_j += f64::from(output.work_j);
            stored_j = f64::from(output.energy_j);
            rolled_back += u32::from(output.flags.contains(Flags::ROLLED_BACK));
            forces_n.push(-output.force_n.y);
        }
        let (cuts, steady) = (bench.cuts(), &forces_n[100..250]);
        let mean_n = steady.iter().sum::<f32>() / steady.len() as f32;
        let step_n = steady.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        let lost = 1.0 - (f64::from(cuts.work_j) + stored_j) / work_j;
        println!(
            "{sweeps} sweeps, {coarse:?}, links {is_of_links}: {mean_n:.4} N of 0.04, largest step {:.2} %, {rolled_back} passes \
             discarded, {work_j:.2e} J of the hand, {:.1} % neither cut nor stored, {cuts:?}",
            100.0 * step_n / mean_n,
            100.0 * lost,
        );
        // A sample at the slab's side stands for all of its length: one spacing more at most.
        assert!((0.99 * 0.04..0.04 + 4.0 * 0.0011).contains(&mean_n), "{mean_n}");
        assert!(step_n < 0.05 * mean_n, "{step_n} {mean_n}");
        assert!((-0.003..0.12).contains(&lost), "{lost}");
        assert!(cuts.opened_faces > 30 && cuts.copies > 20, "{cuts:?}");
    }
}
