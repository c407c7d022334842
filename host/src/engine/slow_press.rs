//! A press so slow that the body is at rest at every depth: finds where the proxy sphere first stays behind
//! the tool.
//!
//! The tool moves in by small steps and waits after each, so a motion that is shortened because of its speed
//! is completed before the next one. A motion that is still shortened then is limited by the depth.

use chaincell_kernel::{Flags, Model, Network, TickOutput, ToolPose};
use nalgebra::Vector3;

use super::place::place;
use super::reach::extent_m;
use super::{Arithmetic, Contact, Engine, Scheme};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::terminal::Progress;

/// Depth of the press, in lengths of the body along the press.
const SHARE: f64 = 0.6;
/// Length of a step [radii], and the smallest and largest number of steps.
const STEP: f64 = 0.1;
const STEPS: [f64; 2] = [60.0, 400.0];
/// Sweeps of a tick.
const SWEEPS: u16 = 8;
/// The body is at rest if the force changes by at most this share per tick. The wait is at most `WAIT_TICKS`
/// ticks, and at least `SHORTENED_TICKS` if a motion is shortened for the first time.
const SETTLED: f32 = 1e-3;
const WAIT_TICKS: usize = 60;
const SHORTENED_TICKS: usize = 20;
/// Share of the largest energy above which the energy bound is what shortens a motion.
const LOADED: f32 = 0.95;

/// Result of a slow press.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowPress {
    /// Largest depth of the tool \[m\].
    pub pressed_m: f64,
    /// Length of a step \[m\].
    pub step_m: f64,
    /// The depth at which the sphere first stayed behind; `None` if it always followed.
    pub behind: Option<Behind>,
    /// Depth at which the tool no longer touches the body after it had touched: it slid off its side, or
    /// slack tissue let it by \[m\]. The press ends there.
    pub lost_m: Option<f64>,
}

/// The first depth at which the proxy sphere stays behind the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Behind {
    /// Depth of the tool below its first touch \[m\].
    pub depth_m: f64,
    /// Force there \[N\].
    pub force_n: f32,
    /// Smallest force from there on \[N\].
    pub least_n: f32,
    /// True if the largest energy that a tool may load limits the motion.
    pub by_energy: bool,
}

/// Presses a sphere of a radius \[m\] into a body at rest, at the place of the built-in press.
///
/// # Errors
/// No place for the press; a radius that the kernel refuses; Ctrl-C.
pub fn slow_press(model: &Model<'_>, radius_m: f32) -> Result<SlowPress> {
    // Prepare the body, the press and its steps.
    let contact = Contact::sphere(radius_m, 0.0);
    let way = place(model, &contact, None)?;
    let settings = Scheme::Track.settings(model, SWEEPS);
    let network = Network::new(*model, settings).map_err(Error::check)?;
    let mut engine = Engine::with_contact(network, Scheme::Track, Arithmetic::F32, contact)?;
    let deepest_m = SHARE * extent_m(model, way.direction);
    let [fewest, most] = STEPS;
    let steps = (deepest_m / (STEP * f64::from(radius_m))).ceil().clamp(fewest, most);
    let step_m = deepest_m / steps;
    let (touch_m, direction) = (Vector3::from(way.touch_m), Vector3::from(way.direction));
    let progress = Progress::new(steps as u64, "press");
    let mut press = SlowPress { pressed_m: 0.0, step_m, behind: None, lost_m: None };
    let mut has_touched = false;
    // Press step by step, and let the body come to rest after each.
    for step in 0..=steps as u64 {
        interrupt::check()?;
        progress.step();
        press.pressed_m = step_m * step as f64;
        let position_m = (touch_m + direction * press.pressed_m).map(|x| x as f32);
        let sample = ToolPose::at(position_m, 1);
        let output = settle(&mut engine, &sample, press.behind.is_none());
        let (force_n, depth_m) = (output.force_n.norm(), press.pressed_m);
        // Nothing touches the tool any more.
        if has_touched && output.contacts == 0 {
            press.lost_m = Some(depth_m);
            break;
        }
        has_touched |= output.contacts > 0;
        // The proxy stays behind, for the first time or still.
        if let Some(behind) = &mut press.behind {
            behind.least_n = behind.least_n.min(force_n);
        } else if output.flags.contains(Flags::MOTION_CLAMPED) {
            let most_j = LOADED * model.energy_max() * model.energy_unit_j();
            let by_energy = output.energy_j > most_j;
            press.behind = Some(Behind { depth_m, force_n, least_n: force_n, by_energy });
        }
    }
    drop(progress);
    Ok(press)
}

/// The output after the force has settled.
fn settle(engine: &mut Engine<'_>, sample: &ToolPose, may_catch_up: bool) -> TickOutput {
    let mut last = engine.tick(sample);
    for tick in 1..WAIT_TICKS {
        let next = engine.tick(sample);
        let change_n = (next.force_n - last.force_n).norm();
        let stays = change_n <= SETTLED * next.force_n.norm();
        let is_shortened = may_catch_up && next.flags.contains(Flags::MOTION_CLAMPED);
        last = next;
        if stays && (!is_shortened || tick >= SHORTENED_TICKS) {
            break;
        }
    }
    last
}
