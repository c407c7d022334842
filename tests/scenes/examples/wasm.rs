//! The golden scenes for WebAssembly: exports functions that `tests/scenes/golden.mjs` calls.
//!
//! `cargo build --release -p chaincell-scenes --example wasm --target wasm32-unknown-unknown`
#![allow(unsafe_code, reason = "exported names")]

use std::sync::Mutex;

use chaincell_kernel::{Dynamics, TissueMut};
use chaincell_scenes::report::{self, Wish};
use chaincell_scenes::{Act, Run, SCENES, Scene, Stepper, Tier, stage};

/// The last report.
static TEXT: Mutex<String> = Mutex::new(String::new());

/// Writes one report; numbers below 0 stand for none.
struct Emit {
    tier: Tier,
    ticks: u32,
    cells_after: i32,
    fault_tick: i32,
    fault_cell: u32,
}

impl Act for Emit {
    type Output = Option<String>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).ok()?;
        if let Ok(tick) = u32::try_from(self.fault_tick) {
            run.fault(tick, self.fault_cell as usize);
        }
        let cells_after = u32::try_from(self.cells_after).ok();
        let wish = Wish { tier: self.tier, ticks: self.ticks, cells_after };
        let mut text = String::new();
        report::write(&mut text, &mut run, wish).ok()?;
        Some(text)
    }
}

/// Number of scenes.
#[unsafe(no_mangle)]
pub extern "C" fn scenes() -> u32 {
    SCENES.len() as u32
}

/// Plays a scene in all its number types and gives the length of its reports, 0 where it cannot
/// be played.
#[unsafe(no_mangle)]
pub extern "C" fn emit(
    scene: u32,
    ticks: u32,
    cells_after: i32,
    fault_tick: i32,
    fault_cell: u32,
) -> usize {
    let Some(scene) = SCENES.get(scene as usize) else { return 0 };
    let one = |&tier: &Tier| {
        let act = Emit { tier, ticks, cells_after, fault_tick, fault_cell };
        stage(scene.name, tier, act).flatten()
    };
    let text: Option<String> = scene.tiers.iter().map(one).collect();
    let text = text.unwrap_or_default();
    let length = text.len();
    if let Ok(mut last) = TEXT.lock() {
        *last = text;
    }
    length
}

/// Where the last report stands.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> usize {
    TEXT.lock().map_or(0, |text| text.as_ptr().addr())
}
