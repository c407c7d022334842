//! The tool's motion: integer and `f32` arithmetic alone, the same bits everywhere.

use chaincell_kernel::ToolPose;
use nalgebra::Vector3;

/// Ticks of a stroke: press, drag, partly back, free.
const STROKE: u32 = 50;
/// Ways of the strokes, in turn.
const WAYS: [[f32; 3]; 4] =
    [[0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [0.0, -0.6, 0.8], [0.3, 0.2, -1.0]];
/// Ways of tools, all of them into the body.
const INTO: [[f32; 3]; 4] =
    [[0.0, 0.0, -1.0], [0.5, 0.0, -0.8], [0.0, -0.5, -0.9], [0.3, 0.2, -1.0]];
/// One stroke in eight goes so many times as far, beyond every limit.
const FAR: f32 = 20.0;

/// Sample of a tick for presses `reach_m` deep \[m\].
///
/// Single samples are not finite now and then; 14 bad ones in a row, every 400 ticks, reach the
/// safe state.
#[must_use]
pub fn sample(reach_m: f32, tick: u32) -> ToolPose {
    let way = along(&WAYS, reach_m, tick);
    // Not at the origin: what counts is the way from where the tool took hold.
    let position_m = Vector3::new(0.25 + way.position_m.x, way.position_m.y, way.position_m.z);
    ToolPose { position_m, ..way }
}

/// The same for a tool that begins at a place beside the body.
pub(crate) fn press(start_m: [f32; 3], reach_m: f32, tick: u32) -> ToolPose {
    let way = along(&INTO, reach_m, tick);
    ToolPose { position_m: Vector3::from(start_m) + way.position_m, ..way }
}

/// The way of a tick from where the tool takes hold.
fn along(ways: &[[f32; 3]; 4], reach_m: f32, tick: u32) -> ToolPose {
    let (stroke, at) = (tick / STROKE, (tick % STROKE) as u16);
    let part = |from: u16, to: u16| f32::from(at.clamp(from, to) - from) / f32::from(to - from);
    let far = if stroke % 8 == 5 { FAR } else { 1.0 };
    let depth = (part(0, 16) - 0.5 * part(28, 36)) * far * reach_m;
    let aside = 0.5 * part(16, 28) * reach_m;
    let [x, y, z] = ways.get(stroke as usize % ways.len()).copied().unwrap_or_default();
    let mut position_m = Vector3::new(x * depth, y * depth + aside, z * depth);
    let mut engaged = u32::from(at < 36);
    let long_gap = (66..80).contains(&(tick % 400));
    if tick % 61 == 30 || long_gap && tick.is_multiple_of(2) {
        position_m.y = f32::NAN;
    } else if long_gap {
        engaged = 2;
    }
    ToolPose::at(position_m, engaged)
}
