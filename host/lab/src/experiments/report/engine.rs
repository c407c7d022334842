//! An engine on a scene, and its state in the units of the references.

use chaincell_kernel::ToolPose;
use nalgebra::Vector3;

use super::scene::Scene;
use super::setting::Setting;
use crate::bodies::Variant;
use crate::reference::Links;
use crate::reference::vectors::norm;
use crate::states::State;
use chaincell_host::engine::{Arithmetic, Contact, Engine};
use chaincell_host::error::Result;
use chaincell_host::session::timing::histogram::Latencies;

/// A tool that is away.
pub const RELEASED: ToolPose = ToolPose::at(Vector3::new(0.0, 0.0, 0.0), 0);

/// An engine for a scene; the tool is not slowed down.
///
/// # Errors
/// As [`Variant::unlimited`].
pub fn engine(scene: &Scene, setting: Setting, sweeps: u16) -> Result<Engine<'_>> {
    let contact = Contact::Cells(scene.contacts.clone());
    let variant = Variant::plain(setting.scheme, Arithmetic::F32);
    variant.unlimited(scene.model_for(setting)?, contact, sweeps, |settings| settings)
}

/// Median time of a sweep over the links alone, every link outside its band \[ns\].
///
/// # Errors
/// As [`engine`].
pub fn link_sweep_ns(scene: &Scene, rounds: usize) -> Result<u64> {
    let mut engine = engine(scene, Setting { coarse: false, ..Setting::TRACK }, 1)?;
    let positions = State::Stretched.positions(&scene.model()?, 0);
    let mut times = Latencies::new()?;
    for _ in 0..rounds {
        engine.set_positions(&positions)?;
        // The first sweep takes no momentum along; the second is one of many.
        engine.tick(&RELEASED);
        times.time(|| engine.tick(&RELEASED));
    }
    Ok(times.summary().p50)
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
