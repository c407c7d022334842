//! Path files, strict and recorded, played by the rules of `serve`.

use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::order::{TickOrder, TickPlace};
use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_host::files::path::{Rules, parse, to_text};
use chaincell_kernel::{Network, Settings, ToolPose};
use chaincell_lab::monitor::Monitor;

use super::{bodies, tick};

/// Most poses that are played.
const PLAYED_MAX: usize = 48;

/// A path: what is read is written and read again to the same bits.
pub fn path(data: &[u8]) {
    let strict = parse(data, "fuzz.csv", Rules::Strict);
    let recorded = parse(data, "fuzz.csv", Rules::Recorded);
    if let Ok(strict) = &strict {
        assert!(strict.poses.len() == 1 && recorded.is_ok());
    }
    let Ok(paths) = recorded else { return };
    let poses = || paths.poses.iter().flatten().copied();
    let again = parse(to_text(poses()).as_bytes(), "again.csv", Rules::Recorded).unwrap();
    let key = |pose: Pose| {
        let bits = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
        (pose.tick, pose.position_m.map(bits), pose.engaged)
    };
    assert!(again.poses.iter().flatten().copied().map(key).eq(poses().map(key)));
    play(&paths.poses);
}

fn play(sequences: &[Vec<Pose>]) {
    let model = bodies::model(4);
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    let cells = bodies::free_cells(&model, 0, 1);
    let mut engine = Engine::new(network, Scheme::Track, &cells).unwrap();
    let mut monitor = Monitor::new(&engine, Arithmetic::F32);
    let mut left = PLAYED_MAX;
    for poses in sequences {
        let mut order = TickOrder::default();
        for pose in poses.iter().take(left) {
            if order.take(pose.tick) == TickPlace::Next {
                tick(&mut monitor, &mut engine, &[ToolPose::from(*pose)], pose.sweeps);
            }
        }
        left = left.saturating_sub(poses.len());
    }
}
