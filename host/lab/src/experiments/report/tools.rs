//! Error against time of a tick for every way in which a tool acts on a body: cells that it holds,
//! a moving probe, a load. The reference is the same body under the same tool with so many sweeps
//! a tick that more change next to nothing.

use chaincell_kernel::{Drive, Settings, ToolSample};
use nalgebra::Vector3;
use serde::Serialize;

use super::press::{Errors, FIRST_TICK, field};
use super::scene::Scene;
use super::setting::Setting;
use super::tables::{Table, percent, times};
use crate::bodies::Variant;
use crate::reference::vectors::{distance, size};
use chaincell_host::engine::{Arithmetic, Contact, Engine, rest_m};
use chaincell_host::error::Result;
use chaincell_host::session::timing::histogram::{Latencies, Summary};
use chaincell_host::words::counted;

/// Sweeps a tick of the reference.
const REFERENCE_SWEEPS: u16 = 200;
/// Sweeps a tick that are measured. The last number tells how far the reference itself may be off.
const SWEEPS: [u16; 5] = [1, 2, 4, 8, REFERENCE_SWEEPS / 2];
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
    /// Sweeps a tick of `track`.
    pub sweeps: u16,
    /// A tick of the motion.
    pub tick_ns: Summary,
    /// Largest errors against the reference.
    pub largest: Errors,
}

/// Displacements [mean link lengths] and force \[N\] at the ticks that are looked at.
type Path = Vec<(Vec<[f64; 3]>, Vector3<f64>)>;

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

    fn engine(self, scene: &Scene, sweeps: u16) -> Result<Engine<'_>> {
        let model = scene.model()?;
        let unit_m = model.unit_m();
        let drive = if self == Self::Load { Drive::Current } else { Drive::default() };
        let contact = match self {
            Self::Held | Self::Load => Contact::Cells(scene.contacts.clone()),
            Self::Probe => {
                Contact::Probe { radius_m: PROBE_LINKS as f32 * unit_m, capacity: model.cells() }
            }
        };
        let variant = Variant::plain(Setting::TRACK.scheme, Arithmetic::F32);
        variant.unlimited(model, contact, sweeps, |settings| Settings { drive, ..settings })
    }

    /// The tool at a tick: a ramp to its depth; the probe's first half, then its way aside.
    fn sample(self, scene: &Scene, tick: usize) -> Result<ToolSample> {
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
        Ok(ToolSample { position_m: position_m.map(|x| x as f32), engaged: 1 })
    }

    /// Plays the motion.
    fn play(self, scene: &Scene, sweeps: u16) -> Result<(Summary, Path)> {
        let mut engine = self.engine(scene, sweeps)?;
        let (mut times, mut path) = (Latencies::new()?, Path::new());
        for tick in 0..=TICKS {
            let sample = self.sample(scene, tick)?;
            let output = times.time(|| engine.tick(&sample));
            if tick >= FIRST_TICK && tick.is_multiple_of(LOOK_TICKS) {
                path.push((field(&mut engine), output.force_n.map(f64::from)));
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

/// Largest errors of a path against the reference; not finite where the reference has no force.
fn largest(path: &Path, reference: &Path) -> Errors {
    let field_max = reference.iter().map(|(field, _)| size(field)).fold(0.0, f64::max);
    let force_max = reference.iter().map(|(_, force)| force.norm()).fold(0.0, f64::max);
    let each = path.iter().zip(reference).map(|(now, exact)| Errors {
        field: distance(&now.0, &exact.0) / size(&exact.0).max(FLOOR * field_max),
        force: (now.1 - exact.1).norm() / exact.1.norm().max(FLOOR * force_max),
    });
    each.fold(Errors::default(), Errors::larger)
}

/// Every tool with every number of sweeps on a body; `after` is called behind each.
///
/// # Errors
/// As the engine; what `after` says.
pub fn run(scene: &Scene, mut after: impl FnMut() -> Result<()>) -> Result<Vec<ToolRow>> {
    let model = scene.model()?;
    let mut rows = Vec::new();
    for tool in [Tool::Held, Tool::Probe, Tool::Load] {
        let (_, reference) = tool.play(scene, REFERENCE_SWEEPS)?;
        for sweeps in SWEEPS {
            let (tick_ns, path) = tool.play(scene, sweeps)?;
            rows.push(ToolRow {
                body: scene.source.clone(),
                cells: model.cells(),
                links: model.links(),
                tool: tool.words(),
                sweeps,
                tick_ns,
                largest: largest(&path, &reference),
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
        .column("sweeps a tick", |row| row.sweeps)
        .column("tick p50 / p99 / max [us]", |row| times(row.tick_ns))
        .column("field, largest error [%]", |row| percent(row.largest.field))
        .column("force, largest error [%]", |row| percent(row.largest.force));
    format!(
        "## Held cells, a moving probe, a load\n\n{}: {}, {}, `track`, alpha 0, each motion {TICKS} \
         ms long. The reference is the same tool with {} a tick; the row with {} shows how far it \
         may be off itself. Errors: from tick {FIRST_TICK} on, of field and force over the larger \
         of the reference at that tick and a fifth of its largest value. A body that snaps from one \
         equilibrium to another makes every setting lag.\n\n{}",
        first.body,
        counted(first.cells, "cell"),
        counted(first.links, "link"),
        counted(REFERENCE_SWEEPS, "sweep"),
        SWEEPS[SWEEPS.len() - 1],
        table.table().markdown()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_sweeps_bring_every_tool_nearer_to_its_reference() {
        let rows = run(&Scene::plane(true).unwrap(), || Ok(())).unwrap();
        assert_eq!(rows.len(), 3 * SWEEPS.len());
        for of_tool in rows.chunks(SWEEPS.len()) {
            let error = |at: usize| of_tool[at].largest.field;
            let tool = &of_tool[0].tool;
            assert!(error(4) < error(0).min(0.05), "{tool}: {} {}", error(0), error(4));
            assert!(of_tool.iter().all(|row| row.largest.force.is_finite()), "{tool}");
        }
    }
}
