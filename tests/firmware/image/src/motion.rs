//! The tool's motion: presses and pulls of three mean link lengths, 50 ticks each.

use chaincell_kernel::ToolSample;
use nalgebra::Vector3;

pub fn sample(unit_m: f32, tick: u32) -> ToolSample {
    let at = (tick % 50) as u16;
    let depth_m = 0.075 * f32::from(at) * unit_m;
    let side = if tick / 50 % 2 == 0 { -1.0 } else { 1.0 };
    ToolSample {
        position_m: Vector3::new(0.2 * depth_m, 0.0, side * depth_m),
        engaged: u32::from(at < 40),
    }
}
