//! The stiffness that a device can show without generating energy, by the delay of its force.

use std::fmt::Write as _;

use chaincell_kernel::Choice;
use chaincell_kernel::stage::{Device, Passivity, Stage, StageSettings, passive_stiffness_n_per_m};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::terminal;

/// Longest delay that is printed \[ticks\].
const TICKS: u8 = 6;

/// A device at a rate of poses.
#[derive(Debug, PartialEq, Serialize)]
pub struct DeviceReport {
    device: &'static str,
    device_hz: u32,
    device_damping_n_s_per_m: f32,
    max_force_n: f32,
    max_speed_m_per_s: f32,
    delays: Vec<Row>,
}

/// A delay.
#[derive(Debug, PartialEq, Serialize)]
struct Row {
    delay_ticks: u8,
    /// 2 b / ((1 + 2 d) h) \[N/m\].
    passive_n_per_m: f32,
    /// Of the coupling that the stage shows \[N/m\].
    shown_n_per_m: f32,
}

impl DeviceReport {
    /// Of the device's own profile.
    ///
    /// # Errors
    /// A rate that the stage refuses.
    pub fn new(device: Device, device_hz: u32) -> Result<Self> {
        let profile = StageSettings::for_device(device);
        let damping = profile.passivity.map_or(0.0, |of| of.device_damping_n_s_per_m);
        let tick_s = 1.0 / device_hz as f32;
        let row = |delay_ticks: u8| {
            let passivity = Some(Passivity { device_damping_n_s_per_m: damping, delay_ticks });
            let stage = Stage::new(StageSettings { tick_s, passivity, ..profile })
                .map_err(|why| Error::input(format!("output stage: {why}")))?;
            let passive_n_per_m = passive_stiffness_n_per_m(damping, delay_ticks.into(), tick_s);
            let shown_n_per_m = stage.coupling().map_or(0.0, |of| of.stiffness_n_per_m);
            Ok(Row { delay_ticks, passive_n_per_m, shown_n_per_m })
        };
        Ok(Self {
            device: device.name(),
            device_hz,
            device_damping_n_s_per_m: damping,
            max_force_n: profile.max_force_n,
            max_speed_m_per_s: profile.max_speed_m_per_s,
            delays: (0..=TICKS).map(row).collect::<Result<_>>()?,
        })
    }

    /// For people.
    ///
    /// # Errors
    /// Standard output that is closed.
    pub fn print(&self) -> Result<()> {
        let Self { device, device_hz, device_damping_n_s_per_m, max_force_n, .. } = self;
        let max_speed_m_per_s = self.max_speed_m_per_s;
        let mut text = format!(
            "  device        {device}: {max_force_n} N, {device_damping_n_s_per_m} N s/m of its own, \
             {device_hz} poses a second\n  hand          up to {max_speed_m_per_s} m/s; a pose farther from the last one is \
             a bad sample\n  delay         passive without control    shown\n"
        );
        for Row { delay_ticks, passive_n_per_m, shown_n_per_m } in &self.delays {
            let ticks = if *delay_ticks == 1 { "tick " } else { "ticks" };
            let _ = writeln!(
                text,
                "    {delay_ticks} {ticks}     {passive_n_per_m:>8.0} N/m       {shown_n_per_m:>8.0} N/m"
            );
        }
        terminal::say(text.trim_end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_two_ticks_on_less_is_shown_than_is_passive_and_at_least_half() {
        for device in [Device::Touch, Device::Omega] {
            let report = DeviceReport::new(device, 1000).unwrap();
            assert_eq!(report.delays.len(), 7);
            for Row { delay_ticks, passive_n_per_m, shown_n_per_m } in report.delays {
                if delay_ticks < 2 {
                    assert_eq!(shown_n_per_m, device.coupling_n_per_m());
                } else {
                    let share = shown_n_per_m / passive_n_per_m;
                    assert!((0.5..=0.81).contains(&share), "{delay_ticks}: {share}");
                }
            }
        }
    }
}
