//! A tool far from a blade hardly feels that faces open.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::BasisSpacing;
use chaincell_kernel::{Network, Settings, ToolPart};
use chaincell_tests::bodies::model;

use crate::bench::Bench;
use crate::blade::{image, mesh};

/// Radius of the ball, its place above the slab's top, and its depth \[m\].
const BALL_M: f32 = 0.006;
const BALL_AT_M: [f32; 2] = [0.020, 0.0];
const TOP_M: f32 = 0.016;
const DEPTH_M: f32 = 0.002;
/// Ticks in which the ball comes to its place, and those in which the body comes to rest.
const COMING: u16 = 300;
const RESTING: u16 = 300;
/// Ticks of the cut, and how far the blade moves in each \[m\].
const CUTTING: u16 = 700;
const STEP_M: f32 = 2.0e-5;
/// Largest change of the ball's force in a tick, as a share of its mean.
const LARGEST_STEP: f32 = 0.03;

/// Places of blade and ball: the ball presses, then the blade goes down at the slab's other end, 28 mm away.
fn places_m(tick: u16) -> [[f32; 3]; 2] {
    let depth_m = 0.0005 + DEPTH_M;
    let rest_m = depth_m * (1.0 - f32::from(tick.min(COMING)) / f32::from(COMING));
    let cut_m = STEP_M * f32::from(tick.saturating_sub(COMING + RESTING));
    let [x, y] = BALL_AT_M;
    [[-0.018, 0.0003, 0.017 - cut_m], [x, y, TOP_M + BALL_M - DEPTH_M + rest_m]]
}

#[test]
fn a_tool_far_from_a_blade_feels_no_step_while_faces_open() {
    let mesh = mesh();
    for coarse in [BasisSpacing::None, BasisSpacing::BySize] {
        let image = image(&mesh, 4.0, coarse);
        let model = model(&image);
        let settings = Settings { sweeps: 4, max_force_n: 100.0, ..Settings::for_model(&model) };
        let network = Network::new(model, settings).unwrap();
        let tools: [&[ToolPart]; 2] = [&[ToolPart::edge(0.010)], &[ToolPart::sphere(BALL_M)]];
        let mut bench: Bench<'_> = Bench::under(network, &tools, 0.0);
        let mut forces_n = Vec::new();
        for tick in 0..COMING + RESTING + CUTTING {
            bench.tick_all(&places_m(tick));
            if tick >= COMING + RESTING {
                forces_n.push(bench.tool(1).force_n.norm());
            } else {
                assert_eq!(bench.cuts().opened_faces, 0, "{tick}");
            }
        }
        let mean_n = forces_n.iter().sum::<f32>() / forces_n.len() as f32;
        let steps_n = forces_n.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let share = steps_n.fold(0.0, f32::max) / mean_n;
        let cuts = bench.cuts();
        println!("{coarse:?}: {mean_n:.4} N, largest step {:.2} %, {cuts:?}", 100.0 * share);
        assert!(cuts.opened_faces > 12 && cuts.copies > 4 && mean_n > 0.01, "{cuts:?} {mean_n}");
        assert!(share <= LARGEST_STEP, "{coarse:?}: {share}");
    }
}
