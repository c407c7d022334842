//! Error against time of a tick for every way in which a tool acts on a body: cells that it holds,
//! a moving probe, a load. The reference is the same body under the same tool with so many sweeps
//! a tick that more change next to nothing.

use chaincell_kernel::{Drive, Settings, ToolPose};
use nalgebra::Vector3;
use serde::Serialize;

use super::press::field;
use super::scene::Scene;
use super::setting::Setting;
use super::snaps::{FIRST_TICK, Snaps, Spread};
use super::tables::{Table, percent, times};
use crate::bodies::Variant;
use crate::reference::vectors::{distance, size};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme, rest_m};
use chaincell_host::error::Result;
use chaincell_host::session::timing::histogram::{Latencies, Summary};
use chaincell_host::words::counted;

/// Sweeps a tick of the reference.
const REFERENCE_SWEEPS: u16 = 200;
/// Sweeps a tick that are measured.
const SWEEPS: [u16; 4] = [1, 2, 4, 8];
/// Sweeps a tick of the row that tells how far the reference itself may be off.
const CHECK_SWEEPS: u16 = REFERENCE_SWEEPS / 2;
/// Ticks of the motion.
const TICKS: usize = 300;
/// Ticks between two looks at the errors.
const LOOK_TICKS: usize = 10;
/// Part of the largest field and force below which an error is relative to that part.
const FLOOR: f64 = 0.2;
/// Depth of a press, and way of the probe along the surface [mean link lengths].
const DEPTH_LINKS: f64 = 3.0;
const PROBE_DEPTH_LINKS: f64 = 1.0;
const PROBE_SLIDE_LINKS: f64 = 2.0;
/// Radius of the probe [mean link lengths].
const PROBE_LINKS: f64 = 3.0;
/// Largest displacement input of the load [mean link lengths].
const LOAD_LINKS: f64 = 0.3;

/// How the tool acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tool {
    Held,
    Probe,
    Load,
}

/// A tool on a body with a number of sweeps a tick.
#[derive(Debug, Clone, Serialize)]
pub struct ToolRow {
    /// Where the body comes from.
    pub body: String,
    /// Its cells.
    pub cells: usize,
    /// Its links.
    pub links: usize,
    /// What the tool does.
    pub tool: String,
    /// The scheme.
    pub scheme: Setting,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// A tick of the motion.
    pub tick_ns: Summary,
    /// Errors of the field against the reference.
    pub field: Spread,
    /// Errors of the force.
    pub force: Spread,
    /// Snaps of the reference.
    pub snaps: Snaps,
}

/// What a motion gave.
#[derive(Default)]
struct Path {
    /// Force at every tick \[N\].
    forces_n: Vec<Vector3<f64>>,
    /// Displacements at the ticks that are looked at [mean link lengths].
    fields: Vec<(usize, Vec<[f64; 3]>)>,
}

impl Tool {
    fn words(self) -> String {
        match self {
            Self::Held => format!("held cells, pressed by {DEPTH_LINKS} mean link lengths"),
            Self::Probe => format!(
                "moving probe of {PROBE_LINKS} mean link lengths, {PROBE_DEPTH_LINKS} deep, then \
                 {PROBE_SLIDE_LINKS} along the surface"
            ),
            Self::Load => {
                format!("load, up to 2 k times {LOAD_LINKS} mean link lengths on each contact cell")
            }
        }
    }

    fn engine<'s>(self, scene: &'s Scene, setting: Setting, sweeps: u16) -> Result<Engine<'s>> {
        let model = scene.model_for(setting)?;
        let unit_m = model.unit_m();
        let drive = if self == Self::Load { Drive::Current } else { Drive::default() };
        let contact = match self {
            Self::Held | Self::Load => Contact::Cells(scene.contacts.clone()),
            Self::Probe => {
                Contact::Probe { radius_m: PROBE_LINKS as f32 * unit_m, capacity: model.cells() }
            }
        };
        let variant = Variant::plain(setting.scheme, Arithmetic::F32);
        variant.unlimited(model, contact, sweeps, |settings| Settings { drive, ..settings })
    }

    /// The tool at a tick: a ramp to its depth; the probe's first half, then its way aside.
    fn sample(self, scene: &Scene, tick: usize) -> Result<ToolPose> {
        let model = scene.model()?;
        let part = tick as f64 / TICKS as f64;
        let inward = Vector3::from(scene.direction);
        let links = match self {
            Self::Held => DEPTH_LINKS * part * inward,
            Self::Load => LOAD_LINKS * part * inward,
            Self::Probe => {
                let depth = PROBE_DEPTH_LINKS * (2.0 * part).min(1.0) - PROBE_LINKS;
                let along = inward.cross(&Vector3::x());
                let along = if along.norm() > 0.5 { along } else { inward.cross(&Vector3::y()) };
                depth * inward + PROBE_SLIDE_LINKS * (2.0 * part - 1.0).max(0.0) * along.normalize()
            }
        };
        let from_m = if self == Self::Probe { middle_m(scene)? } else { Vector3::zeros() };
        let position_m = from_m + f64::from(model.unit_m()) * links;
        Ok(ToolPose::at(position_m.map(|x| x as f32), 1))
    }

    /// Plays the motion.
    fn play(self, scene: &Scene, setting: Setting, sweeps: u16) -> Result<(Summary, Path)> {
        let mut engine = self.engine(scene, setting, sweeps)?;
        let (mut times, mut path) = (Latencies::new()?, Path::default());
        for tick in 0..=TICKS {
            let sample = self.sample(scene, tick)?;
            let output = times.time(|| engine.tick(&sample));
            path.forces_n.push(output.force_n.map(f64::from));
            if tick >= FIRST_TICK && tick.is_multiple_of(LOOK_TICKS) {
                path.fields.push((tick, field(&mut engine)));
            }
        }
        Ok((times.summary(), path))
    }
}

/// Middle of the cells that the scene presses \[m\].
///
/// # Errors
/// As [`Scene::model`].
pub fn middle_m(scene: &Scene) -> Result<Vector3<f64>> {
    let model = scene.model()?;
    let at = |&cell: &u16| Vector3::from(rest_m(&model, cell.into()));
    Ok(scene.contacts.iter().map(at).sum::<Vector3<f64>>() / scene.contacts.len() as f64)
}

impl Path {
    /// Where the force jumps.
    fn snaps(&self) -> Snaps {
        let forces = self.forces_n.iter().map(|&force| force.into());
        Snaps::of(&forces.enumerate().collect::<Vec<_>>())
    }

    /// Errors of field and force against the reference; not finite where that has no force.
    fn errors(&self, reference: &Self, snaps: &Snaps) -> [Spread; 2] {
        let fields = reference.fields.iter().map(|(_, field)| size(field));
        let field_min = FLOOR * fields.fold(0.0, f64::max);
        let forces = reference.forces_n.iter().map(|force| force.norm());
        let force_min = FLOOR * forces.fold(0.0, f64::max);
        let fields = self.fields.iter().zip(&reference.fields).map(|((tick, now), (_, exact))| {
            (*tick, distance(now, exact) / size(exact).max(field_min))
        });
        let forces = self.forces_n.iter().zip(&reference.forces_n);
        let forces = forces.map(|(now, exact)| (now - exact).norm() / exact.norm().max(force_min));
        let fields: Vec<(usize, f64)> = fields.collect();
        let forces: Vec<(usize, f64)> = forces.enumerate().collect();
        [snaps.spread(&fields), snaps.spread(&forces)]
    }
}

/// Every tool with every scheme and number of sweeps on a body; `after` is called behind each tool.
///
/// # Errors
/// As the engine; what `after` says.
pub fn run(scene: &Scene, mut after: impl FnMut() -> Result<()>) -> Result<Vec<ToolRow>> {
    let model = scene.model()?;
    let best = Setting::TRACK;
    let all =
        Setting::COMPARED.into_iter().flat_map(|setting| SWEEPS.map(|sweeps| (setting, sweeps)));
    let all: Vec<_> = all.chain([(best, CHECK_SWEEPS)]).collect();
    let mut rows = Vec::new();
    for tool in [Tool::Held, Tool::Probe, Tool::Load] {
        let (_, reference) = tool.play(scene, best, REFERENCE_SWEEPS)?;
        let snaps = reference.snaps();
        let is_new = |setting: Setting| tool == Tool::Held || setting.scheme != Scheme::Predict;
        let of_tool = all.iter().filter(|(setting, _)| is_new(*setting));
        for &(setting, sweeps) in of_tool {
            let (tick_ns, path) = tool.play(scene, setting, sweeps)?;
            let [field, force] = path.errors(&reference, &snaps);
            rows.push(ToolRow {
                body: scene.source.clone(),
                cells: model.cells(),
                links: model.links(),
                tool: tool.words(),
                scheme: setting,
                sweeps,
                tick_ns,
                field,
                force,
                snaps: snaps.clone(),
            });
        }
        after()?;
    }
    Ok(rows)
}

/// The section of the report.
#[must_use]
pub fn markdown(rows: &[ToolRow]) -> String {
    let Some(first) = rows.first() else { return String::new() };
    let table = Table::of(rows)
        .column("tool", |row| &row.tool)
        .column("scheme", |row| row.scheme)
        .column("sweeps a tick", |row| row.sweeps)
        .column("tick p50 / p99 / max [us]", |row| times(row.tick_ns))
        .column("field, largest error [%]", |row| percent(row.field.largest))
        .column("force, largest error [%]", |row| percent(row.force.largest))
        .column("p90 [%]", |row| percent(row.force.p90))
        .column("median [%]", |row| percent(row.force.median))
        .column("largest in snaps [%]", |row| percent(row.force.in_snaps))
        .column("left out as snaps [%]", |row| row.snaps.share_words());
    format!(
        "## Held cells, a moving probe, a load\n\n{}: {}, {}, alpha 0, each motion {TICKS} ms \
         long. The reference is the same tool under `{}` with {} a tick; the row with \
         {CHECK_SWEEPS} shows how far it may be off itself. Errors are those over the larger of the \
         reference at that tick and a fifth of its largest value. With a probe and under a load \
         `predict` is `track`, bit for bit: it has no rows there. {}\n\n{}",
        first.body,
        counted(first.cells, "cell"),
        counted(first.links, "link"),
        Setting::TRACK,
        counted(REFERENCE_SWEEPS, "sweep"),
        Snaps::rule(),
        table.table().markdown()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_sweeps_bring_every_tool_nearer_to_its_reference() {
        let rows = run(&Scene::plane(true).unwrap(), || Ok(())).unwrap();
        let by_tool: Vec<_> = rows.chunk_by(|a, b| a.tool == b.tool).collect();
        assert_eq!(by_tool.iter().map(|rows| rows.len()).collect::<Vec<_>>(), [17, 9, 9]);
        for rows in by_tool {
            let error = |at: usize| rows[at].field.largest;
            let (tool, last) = (&rows[0].tool, rows.len() - 1);
            assert!(error(last) < error(0).min(0.05), "{tool}: {} {}", error(0), error(last));
            assert!(rows.iter().all(|row| row.force.largest.is_finite()), "{tool}");
            assert!(rows.iter().all(|row| row.force.median <= row.force.p90), "{tool}");
        }
    }
}
