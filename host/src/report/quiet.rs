//! What a sweep costs where little happens: at rest, and in a press that reaches few cells.

use std::time::Instant;

use serde::Serialize;

use super::exact::norm;
use super::press::{engine, field, sample};
use super::scene::Scene;
use super::setting::Setting;
use crate::cosim::histogram::{Latencies, Summary};
use crate::engine::Engine;
use crate::error::{Error, Result};

/// Half-width of the band in the local press.
pub const ALPHA: f64 = 0.05;
/// Cells that a local press moves, as a fraction.
const SHARE: f64 = 0.1;
/// A cell has moved when it is farther than this from its rest position [mean link lengths].
const MOVED: f64 = 1e-6;
/// Ticks of the press, and of the stretch at its end that is timed.
const TICKS: usize = 300;
const TIMED: usize = 100;
/// Sweeps a tick of the press.
const SWEEPS: u16 = 4;
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
        let start = Instant::now();
        engine.tick(&released);
        times.record(start.elapsed().as_nanos() as u64);
    }
    if engine.state_hash() != still {
        return Err(Error::check("the body at rest moved"));
    }
    Ok(times.summary())
}

/// A press that moves about a tenth of the cells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Local {
    /// Depth of the press [mean link lengths].
    pub depth_links: f64,
    /// Cells that have moved at its end, as a fraction.
    pub moved: f64,
    /// A sweep of the press, a quarter of a tick of four sweeps, median \[ns\].
    pub sweep_ns: u64,
}

/// Presses to a depth, linearly, and returns the time of the last ticks and the share that moved.
fn press(engine: &mut Engine<'_>, scene: &Scene, depth_links: f64) -> Result<(Summary, f64)> {
    engine.reset()?;
    let unit_m = engine.network().model().unit_m();
    let mut times = Latencies::new()?;
    for tick in 0..=TICKS {
        let sample = sample(scene, unit_m, depth_links * tick as f64 / TICKS as f64);
        let start = Instant::now();
        engine.tick(&sample);
        if tick > TICKS - TIMED {
            times.record(start.elapsed().as_nanos() as u64);
        }
    }
    let field = field(engine);
    let moved = field.iter().filter(|u| norm(&[**u]) > MOVED).count();
    Ok((times.summary(), moved as f64 / field.len() as f64))
}

/// Looks for the depth at which a tenth of the cells has moved, and times the sweeps there.
///
/// # Errors
/// As the engine.
pub fn local(scene: &Scene) -> Result<Local> {
    let mut engine = engine(scene, Setting::TRACK, SWEEPS)?;
    let (mut low, mut high) = (0.0, 3.0);
    let mut best: Option<Local> = None;
    for _ in 0..ROUNDS {
        let depth_links = 0.5 * (low + high);
        let (times, moved) = press(&mut engine, scene, depth_links)?;
        let nearer = |best: &Local| (moved - SHARE).abs() < (best.moved - SHARE).abs();
        if best.as_ref().is_none_or(nearer) {
            best = Some(Local { depth_links, moved, sweep_ns: times.p50 / u64::from(SWEEPS) });
        }
        if moved < SHARE {
            low = depth_links;
        } else {
            high = depth_links;
        }
    }
    best.ok_or_else(|| Error::check("no local press was made"))
}
