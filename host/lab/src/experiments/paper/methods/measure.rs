//! A method through the press of a body: what comes out, and what it costs.

use serde::Serialize;

use super::body::{Body, HOLD_TICKS, PRESS_TICKS, turned};
use super::method::Kind;
use crate::reference::profile::{middle_row, nonlinearity};
use crate::reference::vectors::farthest;
use chaincell_host::error::Result;
use chaincell_host::interrupt;
use chaincell_host::session::timing::histogram::Latencies;

/// How far body and push are turned \[degrees\].
pub const TURN_DEGREES: f64 = 30.0;

/// A method on a body after the press and the hold.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The method.
    pub method: Kind,
    /// Distance of the middle row from a pyramid's; of a plane.
    pub nonlinearity: Option<f64>,
    /// Force on the contact node \[N\].
    pub force_n: Option<f64>,
    /// Largest distance of a node from the minimum of the links' energy, over the depth.
    pub off_minimum: f64,
    /// Most times that elements were looked at in a tick of the press.
    pub visited_per_tick: usize,
    /// Whether no tick looked at an element twice.
    pub at_most_once: bool,
    /// Largest rise of the links' energy in a tick of the hold, over the energy at its start.
    pub energy_rise: f64,
    /// The same in the hold after the whole move in one tick.
    pub energy_rise_sudden: f64,
    /// Largest distance of a node when body and push are turned, over the depth.
    pub turned: f64,
    /// Whether a second run ends in the same bits.
    pub repeats: bool,
    /// What speaks for the same bits on every target.
    pub portable: &'static str,
    /// Median tick of the press \[ns\]; of an optimised build only.
    pub tick_ns_p50: Option<u64>,
    /// The same over that of `track`.
    pub time_ratio: Option<f64>,
    /// Positions at the end, in input order \[m\].
    #[serde(skip)]
    pub positions_m: Vec<[f64; 3]>,
}

/// The end of a run.
struct Run {
    positions_m: Vec<[f64; 3]>,
    force_n: Option<f64>,
    visited: usize,
    energy_rise: f64,
}

/// The move in so many ticks, then the hold.
fn run(body: &Body, kind: Kind, press_ticks: usize) -> Result<Run> {
    let mut method = kind.start(body)?;
    let mut visited = 0;
    for tick in 1..=press_ticks {
        visited = visited.max(method.tick(body.way_m(tick, press_ticks))?);
    }
    let start = body.links.energy(&method.positions_m());
    let (mut before, mut rise) = (start, 0.0_f64);
    for _ in 0..HOLD_TICKS {
        method.tick(body.travel_m)?;
        let energy = body.links.energy(&method.positions_m());
        rise = rise.max(energy - before);
        before = energy;
    }
    Ok(Run {
        force_n: method.force_n(),
        positions_m: method.positions_m(),
        visited,
        energy_rise: rise / start,
    })
}

/// Whether two states are the same to the last bit.
fn same_bits(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    let bits = |p: &[[f64; 3]]| p.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    bits(a) == bits(b)
}

/// Every method on a body; `exact` is the minimum of its links' energy, ticks are timed in
/// `rounds` presses, the methods in turn.
///
/// # Errors
/// As the methods; the user asked to stop.
pub fn rows(body: &Body, exact: &[[f64; 3]], rounds: usize) -> Result<Vec<Row>> {
    let other = body.turned(TURN_DEGREES)?;
    let depth_m = body.depth_m();
    let mut rows = Vec::new();
    for method in Kind::ALL {
        interrupt::check()?;
        let [once, again] = [run(body, method, PRESS_TICKS)?, run(body, method, PRESS_TICKS)?];
        let round = run(&other, method, PRESS_TICKS)?;
        let back: Vec<[f64; 3]> =
            round.positions_m.iter().map(|&p| turned(p, -TURN_DEGREES)).collect();
        rows.push(Row {
            method,
            nonlinearity: of_plane(body, &once.positions_m)?,
            force_n: once.force_n,
            off_minimum: farthest(&once.positions_m, exact) / depth_m,
            visited_per_tick: once.visited,
            at_most_once: once.visited < exact.len(),
            energy_rise: once.energy_rise,
            energy_rise_sudden: run(body, method, 1)?.energy_rise,
            turned: farthest(&once.positions_m, &back) / depth_m,
            repeats: same_bits(&once.positions_m, &again.positions_m),
            portable: method.portable(),
            tick_ns_p50: None,
            time_ratio: None,
            positions_m: once.positions_m,
        });
    }
    // Times of a build for tests say nothing.
    if !cfg!(debug_assertions) {
        time(body, &mut rows, rounds)?;
    }
    Ok(rows)
}

/// Non-linearity of the middle row; none for a body that is no plane.
///
/// # Errors
/// None for the bodies made here.
pub fn of_plane(body: &Body, positions_m: &[[f64; 3]]) -> Result<Option<f64>> {
    let [nx, ny, nz] = body.nodes;
    (nz == 1).then(|| Ok(nonlinearity(&middle_row(positions_m, [nx, ny])?))).transpose()
}

/// Times the ticks of the press.
pub(super) fn time(body: &Body, rows: &mut [Row], rounds: usize) -> Result<()> {
    let mut times = rows.iter().map(|_| Latencies::new()).collect::<Result<Vec<_>>>()?;
    for _ in 0..rounds {
        for (row, times) in rows.iter().zip(&mut times) {
            let mut method = row.method.start(body)?;
            for tick in 1..=PRESS_TICKS {
                let way_m = body.way_m(tick, PRESS_TICKS);
                times.time(|| method.tick(way_m))?;
            }
        }
    }
    for (row, times) in rows.iter_mut().zip(&times) {
        row.tick_ns_p50 = Some(times.summary().p50);
    }
    let track = rows.iter().find(|row| row.method == Kind::Track).and_then(|row| row.tick_ns_p50);
    for row in rows {
        let ratio = |ns: u64| Some(ns as f64 / track? as f64);
        row.time_ratio = row.tick_ns_p50.and_then(ratio);
    }
    Ok(())
}
