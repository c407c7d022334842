//! Times steps from the worst state with cold caches: every link is out of its band, and no data of the
//! body is in any cache.

use std::time::Instant;

use chaincell_kernel::ToolPose;
use nalgebra::Vector3;

use crate::engine::Engine;
use crate::error::Result;
use crate::interrupt;
use crate::session::timing::histogram::{Latencies, Summary};
use crate::terminal::Progress;

/// Factor on the rest positions.
const SCALE: f32 = 1.5;
/// Size assumed if the system does not report its last-level cache \[bytes\].
const CACHE_BYTES: usize = 32 << 20;
/// Bytes of a cache line.
const LINE: usize = 64;

/// Times of cold steps.
pub struct ColdSteps {
    /// Step times.
    pub step: Summary,
    /// Data read between two steps, twice the last-level cache \[bytes\].
    pub streamed_bytes: usize,
}

/// Times `ticks` steps, each from the body at rest scaled by 1.5 with the tool in contact, after
/// reading twice the last-level cache.
///
/// # Errors
/// The user's request to stop.
pub fn measure(engine: &mut Engine<'_>, ticks: u64) -> Result<ColdSteps> {
    let model = *engine.network().model();
    let scaled = |cell| model.rest_position(cell).map(|x| SCALE * x);
    let positions: Vec<[f32; 3]> = (0..model.cells()).map(scaled).collect();
    let mut stream = vec![1_u8; 2 * last_level_cache_bytes()];
    let sample = ToolPose::at(Vector3::zeros(), 1);
    let mut times = Latencies::new()?;
    let progress = Progress::new(ticks, "worst");
    for round in 0..ticks {
        interrupt::check()?;
        engine.set_positions(&positions)?;
        for byte in stream.iter_mut().step_by(LINE) {
            *byte = byte.wrapping_add(round as u8);
        }
        std::hint::black_box(&stream);
        let start = Instant::now();
        std::hint::black_box(engine.tick(&sample));
        times.record(u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX));
        progress.step();
    }
    drop(progress);
    engine.reset()?;
    Ok(ColdSteps { step: times.summary(), streamed_bytes: stream.len() })
}

/// Returns the size of the last-level cache that Linux reports, or else a default \[bytes\].
pub fn last_level_cache_bytes() -> usize {
    let size = |index: u32| {
        let path = format!("/sys/devices/system/cpu/cpu0/cache/index{index}/size");
        let text = std::fs::read_to_string(path).ok()?;
        let (number, unit) = text.trim().split_at(text.trim().len().checked_sub(1)?);
        let factor = match unit {
            "K" => 1 << 10,
            "M" => 1 << 20,
            _ => return None,
        };
        number.parse::<usize>().ok()?.checked_mul(factor)
    };
    (0..5).filter_map(size).max().unwrap_or(CACHE_BYTES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::{BakeOptions, bake};
    use crate::engine::Scheme;
    use chaincell_kernel::{Model, Network, Settings};

    #[test]
    fn cold_steps_start_from_a_state_far_above_rest_and_leave_rest_behind() {
        let mesh = crate::mesh::load("box:4x4x4x0.01", &Default::default()).unwrap();
        let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let network = Network::new(model, Settings::for_model(&model)).unwrap();
        let mut engine = Engine::new(network, Scheme::Track, &[]).unwrap();
        let rest = engine.state_hash();
        let cold = measure(&mut engine, 3).unwrap();
        assert!(cold.step.max > 0 && cold.streamed_bytes >= 2 * (1 << 10));
        assert_eq!(engine.state_hash(), rest);
    }
}
