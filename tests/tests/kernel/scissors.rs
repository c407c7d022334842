//! Scissors: the crossing of their edges cuts as the edge of a blade, and closing them is work of the hand.
#![allow(clippy::unwrap_used)]

use std::f32::consts::FRAC_1_SQRT_2;

use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{
    Budget, ContactError, CutOutput, Cutting, Network, Scissors, Settings, TickOutput, ToolPart,
    ToolPose,
};
use chaincell_tests::bodies::model;

use crate::bench::Bench;

const SCISSORS: Scissors = Scissors { length_m: 0.04, offset_m: 0.004 };
/// Largest thickness between the blades \[m\]: eight spaces between nine samples, of which seven are in the sheet
/// and stand for its thickness.
const MOUTH_M: f32 = 8.0 / 7.0 * THICKNESS_M;
const TOUGHNESS_J_PER_M2: f32 = 4.0;
const THICKNESS_M: f32 = 0.0133333;
/// Place of the pivot, in front of the sheet's side, on its middle plane \[m\].
const PIVOT_M: [f32; 3] = [0.0003, -0.0215, 0.5 * THICKNESS_M];

/// A sheet of 40 x 27 x 13 mm that is held at both ends.
fn sheet() -> Mesh {
    load("box:13x9x5x0.00333333", &MeshOptions::default()).unwrap()
}

fn image(mesh: &Mesh) -> ImageBytes {
    let nodes = (0..).zip(&mesh.nodes_m);
    let ends: Vec<u32> =
        nodes.filter(|(_, place)| place[0].abs() > 0.0199).map(|(node, _)| node).collect();
    let toughness_j_per_m2 = TOUGHNESS_J_PER_M2.into();
    let cuttable = Some(Cuttable {
        spare_share: 0.5,
        toughness_j_per_m2: PerCell::Uniform(toughness_j_per_m2),
        ..Cuttable::default()
    });
    let tissue = Some(Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3)));
    let coarse_basis = BasisSpacing::BySize;
    let options = BakeOptions { tissue, cuttable, coarse_basis, ..BakeOptions::default() };
    bake(mesh, &ends, &options).unwrap()
}

fn scissors() -> ToolPart {
    ToolPart::scissors(SCISSORS.length_m, SCISSORS.offset_m, MOUTH_M)
}

fn under(image: &ImageBytes) -> Bench<'_> {
    let model = model(image);
    let settings = Settings { sweeps: 4, max_force_n: 100.0, ..Settings::for_model(&model) };
    Bench::under(Network::new(model, settings).unwrap(), &[&[scissors()]], 0.0)
}

/// Opening at which the edges cross at a distance from the pivot \[rad\].
fn opening_rad(crossing_m: f32) -> f32 {
    2.0 * (SCISSORS.offset_m / crossing_m).asin()
}

/// The blades point along y, and open along z.
fn pose(crossing_m: f32) -> ToolPose {
    let orientation = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
    ToolPose { orientation, ..ToolPose::at(PIVOT_M.into(), 1) }
        .with_opening_rad(opening_rad(crossing_m))
}

/// The crossing goes from 8 mm to the tip at 0.1 m/s, through the sheet.
fn crossing_m(tick: usize) -> f32 {
    0.008 + 1.0e-4 * tick as f32
}

const TICKS: usize = 320;

fn tick(bench: &mut Bench<'_>, pose: &ToolPose) -> TickOutput {
    let network = bench.network;
    bench.view().tick(&network, &[*pose], Budget::All)
}

fn torque_n_m(bench: &mut Bench<'_>) -> f32 {
    let network = bench.network;
    bench.view().opening_torque_n_m(&network, 0)
}

/// A body in which the crossing is in mid-sheet, and the ticks that it took.
fn half_way(image: &ImageBytes) -> (Bench<'_>, usize) {
    let mut bench = under(image);
    for at in 0..150 {
        tick(&mut bench, &pose(crossing_m(at)));
    }
    assert!(bench.cuts().opened_faces > 10, "{:?}", bench.cuts());
    (bench, 150)
}

#[test]
fn closing_scissors_part_a_sheet_and_the_hand_pays_by_its_torque() {
    let mesh = sheet();
    let image = image(&mesh);
    let mut bench = under(&image);
    let (mut work_j, mut by_torque_j, mut stored_j, mut lost) = (0.0, 0.0, 0.0, 0.0);
    let (mut last, mut forces_n) = ([0.0, pose(crossing_m(0)).opening_rad()], Vec::new());
    for at in 0..TICKS {
        let pose = pose(crossing_m(at));
        let output = tick(&mut bench, &pose);
        let now = [torque_n_m(&mut bench), pose.opening_rad()];
        // The torque on the handles is that of the force at the crossing.
        let wanted = SCISSORS.opening_torque_n_m(output.force_n.y, pose.opening_rad());
        assert!((now[0] - wanted).abs() <= 2e-3 * wanted.abs(), "{at}: {now:?} {wanted}");
        assert!(now[0] >= 0.0, "{at}: {now:?}");
        by_torque_j += f64::from(0.5 * (now[0] + last[0]) * (last[1] - now[1]));
        work_j += f64::from(output.work_j);
        stored_j = f64::from(output.energy_j);
        last = now;
        forces_n.push(-output.force_n.y);
        let kept_j = stored_j + f64::from(bench.cuts().work_j);
        // As the last strip gives way, what it has stored is lost.
        lost = if at < 270 { 1.0 - kept_j / work_j.max(1e-9) } else { lost };
        assert!(kept_j < 1.003 * work_j + 1e-6, "{at}: {kept_j} {work_j}");
    }
    let (cuts, steady) = (bench.cuts(), &forces_n[120..230]);
    let mean_n = steady.iter().sum::<f32>() / steady.len() as f32;
    println!(
        "{mean_n:.5} N of {:.3}, {work_j:.3e} J of the hand, {by_torque_j:.3e} J by the torque, {:.1} % neither cut \
         nor stored, {cuts:?}",
        TOUGHNESS_J_PER_M2 * THICKNESS_M,
        100.0 * lost,
    );
    assert!((mean_n / (TOUGHNESS_J_PER_M2 * THICKNESS_M) - 1.0).abs() < 0.01, "{mean_n}");
    assert!((by_torque_j / work_j - 1.0).abs() < 0.01, "{by_torque_j} {work_j}");
    assert!((-0.003..0.12).contains(&lost) && stored_j < 0.01 * work_j, "{lost} {stored_j}");
    // Through: nothing is left to cut, and the area is that of the sheet.
    assert_eq!(forces_n[TICKS - 5..], [0.0; 5]);
    let area_m2 = f64::from(cuts.area_m2) / (0.02667 * f64::from(THICKNESS_M));
    assert!((0.75..1.05).contains(&area_m2), "{area_m2}");
    assert!(cuts.opened_faces > 30 && cuts.copies > 20, "{cuts:?}");
}

#[test]
fn opening_again_cuts_nothing_and_has_no_force() {
    let image = image(&sheet());
    let (mut bench, ticks) = half_way(&image);
    let before = bench.cuts();
    for at in (50..ticks).rev() {
        let output = tick(&mut bench, &pose(crossing_m(at)));
        if at < ticks - 20 {
            assert_eq!((output.force_n.norm(), torque_n_m(&mut bench)), (0.0, 0.0), "{at}");
        }
    }
    let open = bench.cuts();
    assert!(open.area_m2 <= 1.01 * before.area_m2, "{before:?} {open:?}");
    assert!(open.opened_faces <= before.opened_faces + 2, "{before:?} {open:?}");
}

#[test]
fn an_opening_that_jumps_a_bad_one_and_late_ticks_cut_nothing() {
    let image = image(&sheet());
    let (mut bench, ticks) = half_way(&image);
    let before = bench.cuts();
    let here = pose(crossing_m(ticks - 1));
    for jump_m in [0.032, 0.036, 0.04] {
        tick(&mut bench, &pose(jump_m));
        tick(&mut bench, &here);
    }
    for _ in 0..20 {
        tick(&mut bench, &here);
    }
    // No more than the samples that enter anew press their fronts on.
    let after = bench.cuts();
    assert_eq!(after.opened_faces, before.opened_faces);
    assert!(after.area_m2 < 1.15 * before.area_m2, "{before:?} {after:?}");
    // Bad openings are bad samples: the last good pose stays.
    let (mut bench, ticks) = half_way(&image);
    tick(&mut bench, &pose(crossing_m(ticks - 1)));
    let before = bench.cuts();
    for opening_turns_q16 in [32769, u16::MAX] {
        let bad = ToolPose { opening_turns_q16, ..here };
        let output = tick(&mut bench, &bad);
        assert!(output.flags.contains(chaincell_kernel::Flags::BAD_SAMPLE), "{output:?}");
    }
    assert_eq!(bench.cuts().opened_faces, before.opened_faces);
    // Late ticks, and cutting that is off.
    let (mut bench, ticks) = half_way(&image);
    let (network, before) = (bench.network, bench.cuts());
    for at in ticks..ticks + 50 {
        bench.view().tick(&network, &[pose(crossing_m(at))], Budget::LATE);
    }
    assert_eq!(bench.cuts(), before);
    let settings = Settings { cut: Cutting::Off, ..*network.settings() };
    bench.network = Network::new(bench.model(), settings).unwrap();
    for at in ticks..ticks + 50 {
        tick(&mut bench, &pose(crossing_m(at)));
    }
    assert_eq!((bench.cuts().opened_faces, torque_n_m(&mut bench)), (before.opened_faces, 0.0));
}

#[test]
fn a_cut_of_scissors_goes_on_from_a_snapshot_with_the_same_bits() {
    let image = image(&sheet());
    let (mut bench, ticks) = half_way(&image);
    let network = bench.network;
    let mut bytes = vec![0; bench.view().snapshot_bytes(&network).unwrap()];
    bench.view().save(&network, &mut bytes).unwrap();
    let mut other = under(&image);
    other.view().restore(&network, &bytes).unwrap();
    for at in ticks..ticks + 60 {
        let pose = pose(crossing_m(at));
        assert_eq!(tick(&mut bench, &pose), tick(&mut other, &pose), "{at}");
        assert_eq!(bench.hash(), other.hash(), "{at}");
        assert_eq!(torque_n_m(&mut bench), torque_n_m(&mut other), "{at}");
    }
    assert_eq!(bench.cuts(), other.cuts());
}

/// The opening of a blade's pose means nothing.
#[test]
fn a_blade_ignores_the_opening() {
    let image = image(&sheet());
    let edge = ToolPart { orientation: [0.5, -0.5, 0.5, 0.5], ..ToolPart::edge(0.008) };
    let model = model(&image);
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    let mut bodies = [(); 2].map(|()| Bench::under(network, &[&[edge]], 0.0));
    for at in 0..80 {
        let place_m = [0.0003, -0.0140 + 1.0e-4 * at as f32, 0.005];
        let plain = ToolPose::at(place_m.into(), 1);
        let open = plain.with_opening_rad(0.01 * at as f32);
        let [one, other] = &mut bodies;
        assert_eq!(tick(one, &plain), tick(other, &open), "{at}");
        assert_eq!(one.hash(), other.hash(), "{at}");
    }
    assert!(bodies[1].cuts() != CutOutput::default());
}

#[test]
fn scissors_that_cannot_be_are_refused() {
    let image = image(&sheet());
    let mut bench = under(&image);
    let network = bench.network;
    let bad = ContactError::Part { tool: 0, part: 0 };
    for (tool, why) in [
        (vec![ToolPart::scissors(0.04, 0.05, 0.02)], bad),
        (vec![ToolPart::scissors(0.04, 0.04, 0.02)], bad),
        (vec![ToolPart::scissors(f32::INFINITY, 0.004, 0.02)], bad),
        (vec![ToolPart::scissors(0.04, 0.004, 0.0)], bad),
        (vec![ToolPart::scissors(0.04, f32::NAN, 0.02)], bad),
        (vec![scissors(), ToolPart::sphere(0.004)], ContactError::Edge { tool: 0, part: 0 }),
    ] {
        assert_eq!(bench.view().choose_tools(&network, &[&tool], 0.0), Err(why), "{tool:?}");
    }
}
