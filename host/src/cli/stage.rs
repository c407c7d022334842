//! Arguments of the output stage between the tissue and a device: `run`, `serve`, `cosim`.

use std::ffi::OsString;

use chaincell_kernel::Choice;
use chaincell_kernel::stage::{Coupling, Device, Passivity, StageSettings};
use serde::Serialize;

use super::choice::parser;

/// Time of a tick [s].
const TICK_S: f32 = 1e-3;

/// What stands between the tissue and the device; nothing unless one of these is given.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Output stage")]
pub struct StageArgs {
    /// Device whose profile the stage takes; what is given beside it goes before the profile. Counts
    /// on 0.5 N s/m of damping in the device: give --passivity with your own
    #[arg(long, value_parser = parser::<Device>(), value_name = "DEVICE")]
    device: Option<Device>,
    /// Virtual coupling, a spring [N/m] and a damper [N s/m] between device and tool: K, K:B or none
    #[arg(long, value_name = "K[:B]", value_parser = coupling, allow_hyphen_values = true)]
    coupling: Option<OrNone<Coupling>>,
    /// Passivity observer and controller: the damping that the device has for sure [N s/m], or none.
    /// Where it cannot keep up it lets the force go along --engage-ramp-ms, not without one
    #[arg(long, value_name = "BDEV", value_parser = passivity, allow_hyphen_values = true)]
    passivity: Option<OrNone<Passivity>>,
    /// Largest change of the device's force [N/s]
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    max_slew_n_per_s: Option<f32>,
    /// Largest force on the device [N]
    #[arg(long, value_name = "F", value_parser = positive, allow_hyphen_values = true)]
    max_device_force_n: Option<f32>,
    /// Ticks in which the force rises after engaging [ms]
    #[arg(long, value_name = "MS", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(0..=60_000))]
    engage_ramp_ms: Option<u16>,
}

/// A part of the stage, or the word `none`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OrNone<Part>(Option<Part>);

/// The stage in force, for summaries; absent parts are null.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageReport {
    device: Option<&'static str>,
    coupling_n_per_m: Option<f32>,
    coupling_n_s_per_m: Option<f32>,
    device_damping_n_s_per_m: Option<f32>,
    max_slew_n_per_s: Option<f32>,
    max_device_force_n: Option<f32>,
    engage_ramp_ms: u16,
}

impl StageArgs {
    /// The stage's settings, `None` where nothing was asked for.
    #[must_use]
    pub fn settings(&self) -> Option<StageSettings> {
        let asked = self.device.is_some()
            || self.coupling.is_some()
            || self.passivity.is_some()
            || self.max_slew_n_per_s.is_some()
            || self.max_device_force_n.is_some()
            || self.engage_ramp_ms.is_some();
        let profile = self.device.map_or(StageSettings::NONE, StageSettings::for_device);
        let settings = StageSettings {
            tick_s: TICK_S,
            coupling: self.coupling.map_or(profile.coupling, |part| part.0),
            passivity: self.passivity.map_or(profile.passivity, |part| part.0),
            max_slew_n_per_s: self.max_slew_n_per_s.unwrap_or(profile.max_slew_n_per_s),
            max_force_n: self.max_device_force_n.unwrap_or(profile.max_force_n),
            ramp_ticks: self.engage_ramp_ms.unwrap_or(profile.ramp_ticks),
            // A silence is no tick here: the loop's own watchdog lets the force fall.
            watchdog_ticks: 0,
        };
        asked.then_some(settings)
    }

    /// The same arguments for a child process.
    pub fn to_args(&self) -> Vec<OsString> {
        let mut args = Vec::new();
        args.extend(self.device.map(|device| format!("--device={}", device.name())));
        args.extend(self.coupling.map(|part| match part.0 {
            None => "--coupling=none".to_owned(),
            Some(Coupling { stiffness_n_per_m, damping_n_s_per_m }) => {
                format!("--coupling={stiffness_n_per_m}:{damping_n_s_per_m}")
            }
        }));
        args.extend(self.passivity.map(|part| match part.0 {
            None => "--passivity=none".to_owned(),
            Some(passivity) => format!("--passivity={}", passivity.device_damping_n_s_per_m),
        }));
        args.extend(self.max_slew_n_per_s.map(|value| format!("--max-slew-n-per-s={value}")));
        args.extend(self.max_device_force_n.map(|value| format!("--max-device-force-n={value}")));
        args.extend(self.engage_ramp_ms.map(|value| format!("--engage-ramp-ms={value}")));
        args.into_iter().map(OsString::from).collect()
    }

    /// Every parameter in force, `None` without a stage.
    #[must_use]
    pub fn report(&self) -> Option<StageReport> {
        let finite = |value: f32| Some(value).filter(|value| value.is_finite());
        self.settings().map(|settings| StageReport {
            device: self.device.map(Choice::name),
            coupling_n_per_m: settings.coupling.map(|of| of.stiffness_n_per_m),
            coupling_n_s_per_m: settings.coupling.map(|of| of.damping_n_s_per_m),
            device_damping_n_s_per_m: settings.passivity.map(|of| of.device_damping_n_s_per_m),
            max_slew_n_per_s: finite(settings.max_slew_n_per_s),
            max_device_force_n: finite(settings.max_force_n),
            engage_ramp_ms: settings.ramp_ticks,
        })
    }
}

fn positive(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|x: &f32| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "must be above 0 and finite".to_owned())
}

fn number(text: &str) -> Result<f32, String> {
    text.parse().map_err(|_| format!("\"{text}\" is no number"))
}

/// A part of the stage in the ranges that the kernel takes.
fn part<Part: Copy>(
    part: Part,
    settings: impl FnOnce(Option<Part>) -> StageSettings,
) -> Result<OrNone<Part>, String> {
    settings(Some(part)).check().map_err(|why| why.to_string())?;
    Ok(OrNone(Some(part)))
}

fn coupling(text: &str) -> Result<OrNone<Coupling>, String> {
    if text == "none" {
        return Ok(OrNone(None));
    }
    let (stiffness, damping) = text.split_once(':').unwrap_or((text, "0"));
    let coupling =
        Coupling { stiffness_n_per_m: number(stiffness)?, damping_n_s_per_m: number(damping)? };
    part(coupling, |coupling| StageSettings { coupling, ..StageSettings::NONE })
}

fn passivity(text: &str) -> Result<OrNone<Passivity>, String> {
    if text == "none" {
        return Ok(OrNone(None));
    }
    let passivity = Passivity { device_damping_n_s_per_m: number(text)?, delay_ticks: 1 };
    part(passivity, |passivity| StageSettings { passivity, ..StageSettings::NONE })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        stage: StageArgs,
    }

    fn stage(args: &[&str]) -> StageArgs {
        Line::try_parse_from([&["chaincell"], args].concat()).map(|line| line.stage).unwrap()
    }

    #[test]
    fn without_arguments_there_is_no_stage() {
        assert_eq!(stage(&[]).settings(), None);
        assert_eq!(stage(&[]).report(), None);
        assert!(stage(&[]).to_args().is_empty());
    }

    #[test]
    fn what_is_given_goes_before_the_profile() {
        let falcon = stage(&["--device", "falcon"]).settings().unwrap();
        let profile = StageSettings::for_device(Device::Falcon);
        assert_eq!(falcon, StageSettings { watchdog_ticks: 0, ..profile });
        let args = ["--device=falcon", "--coupling=none", "--max-device-force-n=2"];
        let mine = stage(&args).settings().unwrap();
        assert_eq!((mine.max_force_n, mine.coupling), (2.0, None));
        assert_eq!(mine.passivity, falcon.passivity);
    }

    #[test]
    fn a_child_gets_the_same_stage() {
        let all: &[&str] = &[
            "--device=sigma",
            "--coupling=700.5:0.25",
            "--passivity=0.1",
            "--max-slew-n-per-s=50",
            "--max-device-force-n=2.5",
            "--engage-ramp-ms=7",
        ];
        for args in [all, &["--coupling=none", "--passivity=none"], &["--device=touch"]] {
            let parent = stage(args);
            let passed: Vec<String> =
                parent.to_args().into_iter().map(|arg| arg.into_string().unwrap()).collect();
            let passed: Vec<&str> = passed.iter().map(String::as_str).collect();
            assert_eq!(stage(&passed).settings(), parent.settings(), "{args:?}");
            assert_eq!(stage(&passed).report(), parent.report(), "{args:?}");
        }
    }

    #[test]
    fn bad_values_are_refused() {
        for args in [
            "--coupling=0",
            "--coupling=100:-1",
            "--coupling=inf",
            "--coupling=stiff",
            "--passivity=-0.1",
            "--max-slew-n-per-s=0",
            "--max-device-force-n=NaN",
            "--engage-ramp-ms=60001",
            "--device=hammer",
        ] {
            assert!(Line::try_parse_from(["chaincell", args]).is_err(), "{args}");
        }
    }
}
