//! The output stage's settings in a header.

use super::error::TraceError;
use crate::stage::{Coupling, Passivity, StageSettings};

/// Words of the settings.
const WORDS: usize = 10;
/// Bytes of the settings, between the fixed part of the header and the contact cells.
pub(super) const STAGE_BYTES: usize = 4 * WORDS;
/// Flags of the optional settings.
const COUPLING: u32 = 1;
const PASSIVITY: u32 = 2;

pub(super) fn words(settings: &StageSettings) -> [u32; WORDS] {
    let (coupling, stiffness, damping) = settings.coupling.map_or((0, 0, 0), |of| {
        (COUPLING, of.stiffness_n_per_m.to_bits(), of.damping_n_s_per_m.to_bits())
    });
    let (passivity, device_damping, delay) = settings.passivity.map_or((0, 0, 0), |of| {
        (PASSIVITY, of.device_damping_n_s_per_m.to_bits(), of.delay_ticks.into())
    });
    let is_limited = settings.max_speed_m_per_s != f32::INFINITY;
    let speed = if is_limited { settings.max_speed_m_per_s.to_bits() } else { 0 };
    [
        coupling | passivity,
        settings.tick_s.to_bits(),
        stiffness,
        damping,
        device_damping,
        delay,
        settings.max_slew_n_per_s.to_bits(),
        settings.max_force_n.to_bits(),
        u32::from(settings.ramp_ticks) | u32::from(settings.watchdog_ticks) << 16,
        speed,
    ]
}

/// Reads the settings from these bytes, `None` if there are none. The stage checks their ranges.
pub(super) fn read(bytes: &[u8]) -> Result<Option<StageSettings>, TraceError> {
    if bytes.is_empty() {
        return Ok(None);
    }
    let mut found = [0; WORDS];
    for (word, bytes) in found.iter_mut().zip(bytes.chunks_exact(4)) {
        *word = bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
    }
    let [parts, tick, stiffness, damping, device_damping, delay, slew, force, ticks, speed] = found;
    let [ramp_ticks, watchdog_ticks]: [u16; 2] = bytemuck::cast(ticks);
    let coupling = Coupling {
        stiffness_n_per_m: f32::from_bits(stiffness),
        damping_n_s_per_m: f32::from_bits(damping),
    };
    let passivity = Passivity {
        device_damping_n_s_per_m: f32::from_bits(device_damping),
        delay_ticks: delay as u8,
    };
    let settings = StageSettings {
        tick_s: f32::from_bits(tick),
        coupling: (parts & COUPLING != 0).then_some(coupling),
        passivity: (parts & PASSIVITY != 0).then_some(passivity),
        max_slew_n_per_s: f32::from_bits(slew),
        max_force_n: f32::from_bits(force),
        max_speed_m_per_s: if speed == 0 { f32::INFINITY } else { f32::from_bits(speed) },
        ramp_ticks,
        watchdog_ticks,
    };
    // Absent settings must be zero, and no other bits may be set.
    if words(&settings) == found { Ok(Some(settings)) } else { Err(TraceError::Layout) }
}
