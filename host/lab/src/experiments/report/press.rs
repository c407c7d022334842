//! A scheme through the press of a scene: time a tick, and error against the exact path.

use chaincell_kernel::ToolPose;
use nalgebra::Vector3;
use serde::Serialize;

use super::exact::{ExactPress, HOLD_TICKS, Moment, PRESS_TICKS, depth};
use super::scene::Scene;
use super::setting::Setting;
use super::snaps::{FIRST_TICK, Snaps};
use super::worst;
use crate::bodies::Variant;
use crate::reference::Links;
use crate::reference::vectors::{distance, fields, minus, norm, size};
use chaincell_host::engine::{Arithmetic, Contact, Engine};
use chaincell_host::error::Result;
use chaincell_host::session::timing::histogram::{Latencies, Summary};

/// Field and force errors at one moment, as fractions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Errors {
    /// |u - `u_exact`| over the larger of |`u_exact`| and a fifth of the last |`u_exact`|, L2 over cells.
    pub field: f64,
    /// |F - `F_exact`| over |`F_exact`|.
    pub force: f64,
}

/// One row: a scheme with a number of sweeps through a press.
#[derive(Debug, Clone, Default, Serialize)]
pub struct PressRow {
    /// Name of the scene.
    pub scene: &'static str,
    /// Scheme, with or without a coarse level.
    pub scheme: Setting,
    /// Sweeps a tick: link passes.
    pub sweeps: u16,
    /// Type of the numbers.
    pub number: &'static str,
    /// A tick of the press and the hold.
    pub tick_ns: Summary,
    /// A tick from positions scaled by 1.5.
    pub worst_tick_ns: Summary,
    /// Largest errors from tick 30 to the end of the press, snaps left out.
    pub largest: Errors,
    /// Largest errors inside snaps.
    pub largest_in_snaps: Errors,
    /// At the end of the press.
    pub at_end: Errors,
    /// 20 ms later.
    pub after_20ms: Errors,
    /// 100 ms later.
    pub after_100ms: Errors,
    /// Largest residual of a free cell 100 ms later [mean link lengths].
    pub residual: f64,
    /// Energy above the minimum 100 ms later, as a fraction of it.
    pub energy_above: f64,
    /// Errors at every moment of the exact path, by tick.
    #[serde(skip)]
    pub path: Vec<(usize, Errors)>,
}

/// The tool of a press at a tick; at tick 0 it takes hold.
#[must_use]
pub fn sample(scene: &Scene, unit_m: f32, depth_links: f64) -> ToolPose {
    let way_m = depth_links * f64::from(unit_m);
    let position_m = scene.direction.map(|x| (x * way_m) as f32);
    ToolPose::at(Vector3::from(position_m), 1)
}

/// An engine for a scene; the tool is not slowed down.
///
/// # Errors
/// As [`Variant::unlimited`].
pub fn engine(scene: &Scene, setting: Setting, sweeps: u16) -> Result<Engine<'_>> {
    let contact = Contact::Cells(scene.contacts.clone());
    let variant = Variant::plain(setting.scheme, Arithmetic::F32);
    variant.unlimited(scene.model_for(setting)?, contact, sweeps, |settings| settings)
}

/// Displacements of all cells [mean link lengths].
#[must_use]
pub fn field(engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
    let positions_m = engine.positions_m();
    let model = engine.network().model();
    let (unit_m, centre_m) = (f64::from(model.unit_m()), model.centre_m().map(f64::from));
    let cells = positions_m.into_iter().enumerate();
    cells
        .map(|(cell, p)| {
            let rest = model.rest_position(cell).map(f64::from);
            std::array::from_fn(|x| (p[x] - centre_m[x]) / unit_m - rest[x])
        })
        .collect()
}

/// Times of the ticks of a press and the hold after it, nothing else in between.
///
/// # Errors
/// As [`engine`].
pub fn tick_times(scene: &Scene, setting: Setting, sweeps: u16) -> Result<Summary> {
    let mut engine = engine(scene, setting, sweeps)?;
    let unit_m = engine.network().model().unit_m();
    let mut times = Latencies::new()?;
    for tick in 0..=PRESS_TICKS + HOLD_TICKS {
        let sample = sample(scene, unit_m, depth(tick));
        times.time(|| engine.tick(&sample));
    }
    Ok(times.summary())
}

/// Errors of a state against a moment of the exact path.
fn errors(field: &[[f64; 3]], force_n: [f64; 3], exact: &Moment, last: f64) -> Errors {
    Errors {
        field: distance(field, &exact.field) / size(&exact.field).max(0.2 * last),
        force: norm(minus(force_n, exact.force_n)) / norm(exact.force_n),
    }
}

impl Errors {
    pub(super) fn larger(self, other: Self) -> Self {
        Self { field: self.field.max(other.field), force: self.force.max(other.force) }
    }
}

/// Runs a scheme through the press: once for the time, once for the errors.
///
/// # Errors
/// As [`engine`].
pub fn run(scene: &Scene, exact: &ExactPress, setting: Setting, sweeps: u16) -> Result<PressRow> {
    let mut row = PressRow {
        tick_ns: tick_times(scene, setting, sweeps)?,
        worst_tick_ns: worst::tick_times(scene, setting, sweeps)?,
        ..PressRow::new(scene.name, setting, sweeps)
    };
    let mut engine = engine(scene, setting, sweeps)?;
    let unit_m = engine.network().model().unit_m();
    let last = size(&exact.last().field);
    for tick in 0..=PRESS_TICKS + HOLD_TICKS {
        let answer = engine.tick(&sample(scene, unit_m, depth(tick)));
        let asked = tick <= PRESS_TICKS || [20, HOLD_TICKS].contains(&(tick - PRESS_TICKS));
        let Some(moment) = exact.at(tick).filter(|_| asked) else { continue };
        let force_n = answer.force_n.map(f64::from).into();
        let now = errors(&field(&mut engine), force_n, moment, last);
        match tick.checked_sub(PRESS_TICKS) {
            Some(0) => row.at_end = now,
            Some(20) => row.after_20ms = now,
            Some(HOLD_TICKS) => row.after_100ms = now,
            _ => {}
        }
        row.path.push((tick, now));
    }
    row.judge(&exact.snaps);
    rest_of(&mut row, &mut engine, exact);
    Ok(row)
}

impl PressRow {
    pub(super) fn new(scene: &'static str, setting: Setting, sweeps: u16) -> Self {
        Self { scene, scheme: setting, sweeps, number: "f32", ..Self::default() }
    }

    /// Largest errors during the press, those inside snaps apart.
    fn judge(&mut self, snaps: &Snaps) {
        let press = |&&(tick, _): &&(usize, Errors)| (FIRST_TICK..=PRESS_TICKS).contains(&tick);
        for &(tick, now) in self.path.iter().filter(press) {
            if snaps.hold(tick) {
                self.largest_in_snaps = self.largest_in_snaps.larger(now);
            } else {
                self.largest = self.largest.larger(now);
            }
        }
    }
}

/// Residual and energy of the state at the end of the hold.
fn rest_of(row: &mut PressRow, engine: &mut Engine<'_>, exact: &ExactPress) {
    let at = fields(exact.links.rest(), 1.0, &field(engine));
    let energy;
    (energy, row.residual) = free_residual(&exact.links, &at, engine.contacts());
    row.energy_above = energy / exact.last().energy - 1.0;
}

/// Energy of the links at positions, and the largest residual of a cell that is neither fixed nor
/// held by the tool, in internal units.
#[must_use]
pub fn free_residual(links: &Links, at: &[[f64; 3]], contacts: &[u16]) -> (f64, f64) {
    let mut residual = vec![[0.0; 3]; at.len()];
    let energy = links.residual(at, &mut residual);
    for &cell in contacts {
        residual[usize::from(cell)] = [0.0; 3];
    }
    let free = residual.iter().zip(links.fixed()).filter(|(_, fixed)| !**fixed);
    (energy, free.map(|(r, _)| norm(*r)).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors inside snaps count apart, those before tick 30 and after the press not at all.
    #[test]
    fn errors_inside_snaps_are_told_apart() {
        let force = |tick: usize| if tick < 200 { [1.0, 0.0, 0.0] } else { [0.8, 0.0, 0.0] };
        let path: Vec<_> = (0..=PRESS_TICKS).map(|tick| (tick, force(tick))).collect();
        let mut row = PressRow::new("", Setting::TRACK, 4);
        let error = |tick: usize| match tick {
            0..30 | 301.. => 9.0,
            200..=215 => 0.5,
            216 => 0.2,
            _ => 0.05,
        };
        row.path = (0..=PRESS_TICKS + HOLD_TICKS)
            .map(|tick| (tick, Errors { field: error(tick), force: 0.1 * error(tick) }))
            .collect();
        row.judge(&Snaps::of(&path));
        assert_eq!((row.largest.field, row.largest_in_snaps.field), (0.2, 0.5));
        row.largest = Errors::default();
        row.judge(&Snaps::default());
        assert_eq!((row.largest.field, row.largest.force), (0.5, 0.05));
    }
}
