//! The schemes that the tables of a moving hand compare.

use super::scene::Scene;
use super::setting::Setting;
use crate::bodies::Variant;
use chaincell_host::engine::{Arithmetic, Contact, Engine};
use chaincell_host::error::Result;
use chaincell_kernel::Settings;

/// A scheme with its name in the tables.
pub struct Candidate {
    /// The name.
    pub name: &'static str,
    /// Whether it is another one, bit for bit, unless the tool holds cells.
    pub for_held_cells: bool,
    /// Whether it uses the coarse level of a model.
    pub hats: bool,
    /// Builds an engine at rest: the body, what the tool touches, sweeps a tick, and a change of
    /// the settings. The tool is not slowed down.
    pub engine: for<'s> fn(&'s Scene, Contact, u16, Change<'_>) -> Result<Engine<'s>>,
}

/// A change of the settings that a scheme has by itself.
pub type Change<'c> = &'c dyn Fn(Settings) -> Settings;

/// All of them; the first one is the default of the engine.
pub const CANDIDATES: [Candidate; 4] = [
    Candidate {
        name: "track",
        for_held_cells: false,
        hats: true,
        engine: |scene, contact, sweeps, change| of(scene, Setting::TRACK, contact, sweeps, change),
    },
    Candidate {
        name: "predict",
        for_held_cells: true,
        hats: true,
        engine: |scene, contact, sweeps, change| {
            of(scene, Setting::PREDICT, contact, sweeps, change)
        },
    },
    Candidate {
        name: "predict without hats",
        for_held_cells: true,
        hats: false,
        engine: |scene, contact, sweeps, change| {
            let bare = Setting { hats: false, ..Setting::PREDICT };
            of(scene, bare, contact, sweeps, change)
        },
    },
    Candidate {
        name: "track without hats",
        for_held_cells: false,
        hats: false,
        engine: |scene, contact, sweeps, change| {
            let bare = Setting { hats: false, ..Setting::TRACK };
            of(scene, bare, contact, sweeps, change)
        },
    },
];

fn of<'s>(
    scene: &'s Scene,
    setting: Setting,
    contact: Contact,
    sweeps: u16,
    change: Change<'_>,
) -> Result<Engine<'s>> {
    let variant = Variant::plain(setting.scheme, Arithmetic::F32);
    variant.unlimited(scene.model_for(setting)?, contact, sweeps, change)
}
