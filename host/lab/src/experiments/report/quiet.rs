//! What a sweep costs where little happens: at rest, and in a press that reaches few cells.

use std::time::Instant;

use nalgebra::Vector3;
use serde::Serialize;

use super::press::{engine, field, sample};
use super::scene::Scene;
use super::setting::Setting;
use crate::reference::vectors::norm;
use chaincell_host::engine::Engine;
use chaincell_host::error::{Error, Result};
use chaincell_host::session::timing::histogram::{Latencies, Summary};

/// Half-width of the band in the local press.
pub const ALPHA: f64 = 0.05;
/// Cells that a local press moves, as a fraction.
const SHARE: f64 = 0.1;
/// A cell has moved when it is farther than this from its rest position [mean link lengths].
const MOVED: f64 = 1e-6;
/// Ticks of the press, and of the stretch at its end that is timed.
const TICKS: usize = 300;
const TIMED: usize = 100;
/// Ticks in which the force settles.
const HELD: usize = 500;
/// Sweeps a tick of the press.
const SWEEPS: u16 = 4;
/// A force below this is the rounding of single precision, and no base for a relative error [force
/// of a link that is stretched by a mean link length].
const FORCE_MIN: f64 = 1e-5;
/// Halvings of the depth.
const ROUNDS: usize = 9;

/// Time of a sweep in an untouched body, a tick of one sweep \[ns\].
///
/// # Errors
/// As the engine.
pub fn rest(scene: &Scene, ticks: usize) -> Result<Summary> {
    let mut engine = engine(scene, Setting::TRACK, 1)?;
    let unit_m = engine.network().model().unit_m();
    let mut released = sample(scene, unit_m, 0.0);
    released.engaged = 0;
    let mut times = Latencies::new()?;
    let still = engine.state_hash();
    for _ in 0..ticks {
        times.time(|| engine.tick(&released));
    }
    if engine.state_hash() != still {
        return Err(Error::check("the body at rest moved"));
    }
    Ok(times.summary())
}

/// A press that moves about a tenth of the cells, on a body without a coarse level; and the same
/// press with it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Local {
    /// Depth of the press [mean link lengths].
    pub depth_links: f64,
    /// Cells that have moved at its end, as a fraction.
    pub moved: f64,
    /// A sweep of the press, a quarter of a tick of four sweeps, median \[ns\].
    pub sweep_ns: u64,
    /// Difference between the force at the end of the press and the force that it settles to, over
    /// the latter; none where it settles to no force.
    pub force_error: Option<f64>,
    /// That difference \[N\].
    pub force_off_n: f64,
    /// A sweep with the coarse level, which moves every cell, median \[ns\].
    pub hats_sweep_ns: u64,
    /// Its force error.
    pub hats_force_error: Option<f64>,
    /// Its difference \[N\].
    pub hats_force_off_n: f64,
}

/// `part` over `base`; none where the base is below `base_min` or not a number.
fn relative(part: f64, base: f64, base_min: f64) -> Option<f64> {
    (base >= base_min).then(|| part / base)
}

/// What a press gave.
struct Pressed {
    times: Summary,
    moved: f64,
    force_error: Option<f64>,
    force_off_n: f64,
}

/// Presses to a depth, linearly, and holds until the force has settled.
fn press(engine: &mut Engine<'_>, scene: &Scene, depth_links: f64) -> Result<Pressed> {
    engine.reset()?;
    let unit_m = engine.network().model().unit_m();
    let mut times = Latencies::new()?;
    let mut force_n = Vector3::zeros();
    for tick in 0..=TICKS {
        let sample = sample(scene, unit_m, depth_links * tick as f64 / TICKS as f64);
        let start = Instant::now();
        force_n = engine.tick(&sample).force_n;
        if tick > TICKS - TIMED {
            times.record(start.elapsed().as_nanos() as u64);
        }
    }
    let field = field(engine);
    let moved = field.iter().filter(|u| norm(**u) > MOVED).count();
    let held = sample(scene, unit_m, depth_links);
    let mut settled_n = force_n;
    for _ in 0..HELD {
        settled_n = engine.tick(&held).force_n;
    }
    let force_off_n = f64::from((force_n - settled_n).norm());
    let force_min_n = FORCE_MIN * f64::from(engine.network().model().force_unit_n());
    Ok(Pressed {
        times: times.summary(),
        moved: moved as f64 / field.len() as f64,
        force_error: relative(force_off_n, settled_n.norm().into(), force_min_n),
        force_off_n,
    })
}

/// Looks for the depth at which a tenth of the cells has moved, and times the sweeps there.
///
/// # Errors
/// As the engine.
pub fn local(scene: &Scene) -> Result<Local> {
    let bare = Setting { hats: false, ..Setting::TRACK };
    let mut without = engine(scene, bare, SWEEPS)?;
    let (mut low, mut high) = (0.0, 3.0);
    let mut best: Option<(f64, Pressed)> = None;
    for _ in 0..ROUNDS {
        let depth_links = 0.5 * (low + high);
        let pressed = press(&mut without, scene, depth_links)?;
        let off = |pressed: &Pressed| (pressed.moved - SHARE).abs();
        if pressed.moved < SHARE {
            low = depth_links;
        } else {
            high = depth_links;
        }
        if best.as_ref().is_none_or(|(_, best)| off(&pressed) < off(best)) {
            best = Some((depth_links, pressed));
        }
    }
    let (depth_links, pressed) = best.ok_or_else(|| Error::check("no local press was made"))?;
    let with = press(&mut engine(scene, Setting::TRACK, SWEEPS)?, scene, depth_links)?;
    let sweep_ns = |pressed: &Pressed| pressed.times.p50 / u64::from(SWEEPS);
    Ok(Local {
        depth_links,
        moved: pressed.moved,
        sweep_ns: sweep_ns(&pressed),
        force_error: pressed.force_error,
        force_off_n: pressed.force_off_n,
        hats_sweep_ns: sweep_ns(&with),
        hats_force_error: with.force_error,
        hats_force_off_n: with.force_off_n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_without_a_base_is_none() {
        assert_eq!(relative(0.1, 2.0, 1e-5), Some(0.05));
        for base in [0.0, 1e-300, f64::NAN] {
            assert_eq!(relative(2.7e-4, base, 1e-5), None, "{base}");
        }
    }
}
