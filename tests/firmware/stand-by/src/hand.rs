//! The hand at this board's own device, after the takeover: it holds on, lets go, takes hold again and presses.
//!
//! As with `serve --stand-by` the tissue goes on with the tool that holds it, and the device feels no force before the
//! tool was released once.

use chaincell_kernel::number::sqrt::sqrt;
use chaincell_kernel::{Budget, ToolPose};

use super::console;
use super::session::Session;

/// Ticks in which the hand holds on; until which it has let go; until which it presses in, and all.
const HOLDS: u16 = 100;
const FREE: u16 = HOLDS + 50;
const PRESSES: u16 = FREE + 40;
const ALL: u16 = PRESSES + 260;
/// Way of a tick into the body \[m\].
const STEP_M: f32 = 1.0 / 8192.0;

/// What the device gets.
#[derive(Default)]
struct Device {
    /// The force now, the largest one, and the largest step of it \[N\].
    force_n: [f32; 3],
    largest_n: f32,
    step_n: f32,
    /// The largest force before the tool was released \[N\].
    withheld_n: f32,
}

impl Device {
    fn apply(&mut self, force_n: [f32; 3], is_withheld: bool) {
        let [from_x, from_y, from_z] = self.force_n;
        let [x, y, z] = force_n;
        self.step_n = self.step_n.max(length([x - from_x, y - from_y, z - from_z]));
        self.largest_n = self.largest_n.max(length(force_n));
        if is_withheld {
            self.withheld_n = self.largest_n;
        }
        self.force_n = force_n;
    }
}

/// Goes on with a session.
pub fn press(session: &mut Session) {
    let (mut device, mut is_withheld) = (Device::default(), true);
    let from = session.pose;
    session.stage.restart_ramp();
    for tick in 0..ALL {
        let way_m = STEP_M * f32::from(tick.clamp(FREE, PRESSES) - FREE);
        let [x, y, z] = from.position_m.into();
        let is_free = (HOLDS..FREE).contains(&tick);
        let engaged = if is_free {
            0
        } else if tick < HOLDS {
            from.engaged
        } else {
            1
        };
        let pose = ToolPose::at([x, y, z - way_m].into(), engaged.into());
        if session.is_paused() {
            device.apply([0.0; 3], is_withheld);
            continue;
        }
        // The device gets another force than the stage's: the next one begins at the foot of the ramp.
        if is_withheld {
            session.stage.restart_ramp();
        }
        is_withheld &= engaged != 0;
        let output = session.tick(&pose, Budget::All);
        let force_n = if is_withheld { [0.0; 3] } else { output.force_n.into() };
        device.apply(force_n, is_withheld);
    }
    // The step of a ramp that rises to the largest force.
    let stage = session.stage.settings();
    let most_n = stage.max_force_n.min(session.network.settings().max_force_n);
    let ramp_n = most_n / f32::from(stage.ramp_ticks.max(1));
    for (name, force_n) in [
        ("withheld_un", device.withheld_n),
        ("largest_un", device.largest_n),
        ("step_un", device.step_n),
        ("ramp_step_un", ramp_n),
    ] {
        console::number(name, (1.0e6 * force_n) as u32);
    }
    console::bits("hash_after", session.state_hash());
}

fn length([x, y, z]: [f32; 3]) -> f32 {
    sqrt(x * x + y * y + z * z)
}
