//! Arguments of the output stage between the tissue and a device: `run`, `serve`, `cosim`.

use std::ffi::OsString;

use chaincell_kernel::Choice;
use chaincell_kernel::stage::{
    Coupling, DELAY_MAX, Device, HAND_SPEED_MAX_M_PER_S, Passivity, Stage, StageSettings,
    TICKS_MAX, passive_stiffness_n_per_m,
};
use serde::Serialize;

use super::choice::parser;
use crate::error::{Error, Result};
use crate::session::timing::clock::SECOND_NS;

/// Poses a second of a device, unless it is told.
const DEVICE_HZ: u32 = 1000;

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
    /// Ticks between an answer and the device's pushing with it, 0 to 16: 0 where it does so at once. From
    /// 2 on the coupling is weakened to what is passive: `chaincell info --device` prints it. auto:
    /// measured by serve, from the send times of the poses; it begins with 16. 1 by default
    #[arg(long, value_name = "N|auto", value_parser = delay, allow_hyphen_values = true)]
    delay_ticks: Option<Delay>,
    /// Poses that the device sends in a second: a tick of the stage is one of them. 1000 by default
    #[arg(long, value_name = "HZ", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(10..=100_000))]
    device_hz: Option<u32>,
    /// Largest change of the device's force [N/s]
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    max_slew_n_per_s: Option<f32>,
    /// Largest force on the device [N]
    #[arg(long, value_name = "F", value_parser = positive, allow_hyphen_values = true)]
    max_device_force_n: Option<f32>,
    /// Largest speed of the hand [m/s], or off: an engaged pose farther from the last one is a bad sample.
    /// serve and cosim go by it without an output stage too. 5 by default
    #[arg(long, value_name = "V|off", value_parser = speed, allow_hyphen_values = true)]
    max_speed_m_per_s: Option<f32>,
    /// Ticks in which the force rises after engaging [ms]
    #[arg(long, value_name = "MS", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(0..=60_000))]
    engage_ramp_ms: Option<u16>,
}

/// What clap is told of an argument.
type Checked<T> = std::result::Result<T, String>;

/// A part of the stage, or the word `none`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OrNone<Part>(Option<Part>);

/// The delay of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Delay {
    Told(u8),
    Measured,
}

/// The stage in force, for summaries; absent parts are null.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageReport {
    device: Option<&'static str>,
    coupling_n_per_m: Option<f32>,
    coupling_n_s_per_m: Option<f32>,
    device_damping_n_s_per_m: Option<f32>,
    delay_ticks: Option<u8>,
    delay_measured: bool,
    passive_n_per_m: Option<f32>,
    device_hz: u32,
    max_slew_n_per_s: Option<f32>,
    max_device_force_n: Option<f32>,
    max_speed_m_per_s: Option<f32>,
    engage_ramp_ms: u16,
}

impl StageArgs {
    /// The stage's settings, `None` where nothing was asked for.
    ///
    /// # Errors
    /// A delay without passivity control, or one of several ticks without a coupling.
    pub fn settings(&self) -> Result<Option<StageSettings>> {
        let asked = self.device.is_some()
            || self.coupling.is_some()
            || self.passivity.is_some()
            || self.delay_ticks.is_some()
            || self.device_hz.is_some()
            || self.max_slew_n_per_s.is_some()
            || self.max_device_force_n.is_some()
            || self.engage_ramp_ms.is_some();
        let profile = self.device.map_or(StageSettings::NONE, StageSettings::for_device);
        let hz = self.device_hz.unwrap_or(DEVICE_HZ);
        let ticks = |ms: u16| (u32::from(ms) * hz / 1000).min(TICKS_MAX.into()) as u16;
        let coupling = self.coupling.map_or(profile.coupling, |part| part.0);
        let passivity = self.passivity.map_or(profile.passivity, |part| part.0);
        let passivity = match (passivity, self.delay_ticks) {
            (None, Some(_)) => {
                return Err(Error::input(
                    "`delay_ticks`: it is for passivity control; give `device` or `passivity` too",
                ));
            }
            (Some(of), Some(Delay::Told(delay_ticks))) => Some(Passivity { delay_ticks, ..of }),
            // What is not known yet may be the longest.
            (Some(of), Some(Delay::Measured)) if coupling.is_some() => {
                Some(Passivity { delay_ticks: DELAY_MAX, ..of })
            }
            (passivity, _) => passivity,
        };
        let settings = StageSettings {
            tick_s: 1.0 / hz as f32,
            coupling,
            passivity,
            max_slew_n_per_s: self.max_slew_n_per_s.unwrap_or(profile.max_slew_n_per_s),
            max_force_n: self.max_device_force_n.unwrap_or(profile.max_force_n),
            max_speed_m_per_s: self.max_speed_m_per_s(),
            ramp_ticks: ticks(self.engage_ramp_ms.unwrap_or(profile.ramp_ticks)),
            // A silence is no tick here: the loop's own watchdog lets the force fall.
            watchdog_ticks: 0,
        };
        settings.check().map_err(|why| Error::input(format!("output stage: {why}")))?;
        Ok(asked.then_some(settings))
    }

    /// Largest speed of the hand, infinite for any [m/s].
    #[must_use]
    pub fn max_speed_m_per_s(&self) -> f32 {
        self.max_speed_m_per_s.unwrap_or(HAND_SPEED_MAX_M_PER_S)
    }

    /// A tick of the device, where the delay is measured \[ns\].
    #[must_use]
    pub fn delay_period_ns(&self) -> Option<u64> {
        let period_ns = SECOND_NS / u64::from(self.device_hz.unwrap_or(DEVICE_HZ));
        (self.delay_ticks == Some(Delay::Measured)).then_some(period_ns)
    }

    /// The settings of a run without a clock.
    ///
    /// # Errors
    /// As [`Self::settings`], and a delay that is to be measured.
    pub fn timeless(&self) -> Result<Option<StageSettings>> {
        if self.delay_ticks == Some(Delay::Measured) {
            return Err(Error::input(
                "`delay_ticks` auto: it is measured by serve and cosim; here name the ticks",
            ));
        }
        self.settings()
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
        args.extend(self.delay_ticks.map(|delay| match delay {
            Delay::Told(ticks) => format!("--delay-ticks={ticks}"),
            Delay::Measured => "--delay-ticks=auto".to_owned(),
        }));
        args.extend(self.device_hz.map(|hz| format!("--device-hz={hz}")));
        args.extend(self.max_slew_n_per_s.map(|value| format!("--max-slew-n-per-s={value}")));
        args.extend(self.max_device_force_n.map(|value| format!("--max-device-force-n={value}")));
        args.extend(self.max_speed_m_per_s.map(|value| match value {
            f32::INFINITY => "--max-speed-m-per-s=off".to_owned(),
            value => format!("--max-speed-m-per-s={value}"),
        }));
        args.extend(self.engage_ramp_ms.map(|value| format!("--engage-ramp-ms={value}")));
        args.into_iter().map(OsString::from).collect()
    }

    /// Every parameter in force, `None` without a stage.
    ///
    /// # Errors
    /// As [`Self::settings`].
    pub fn report(&self) -> Result<Option<StageReport>> {
        let finite = |value: f32| Some(value).filter(|value| value.is_finite());
        Ok(self.settings()?.map(|settings| {
            let shown = Stage::new(settings).ok().and_then(|stage| stage.coupling());
            let passive = settings.passivity.map(|of| {
                let [damping, delay] = [of.device_damping_n_s_per_m, of.delay_ticks.into()];
                passive_stiffness_n_per_m(damping, delay, settings.tick_s)
            });
            StageReport {
                device: self.device.map(Choice::name),
                coupling_n_per_m: shown.map(|of| of.stiffness_n_per_m),
                coupling_n_s_per_m: shown.map(|of| of.damping_n_s_per_m),
                device_damping_n_s_per_m: settings.passivity.map(|of| of.device_damping_n_s_per_m),
                delay_ticks: settings.passivity.map(|of| of.delay_ticks),
                delay_measured: self.delay_ticks == Some(Delay::Measured),
                passive_n_per_m: passive,
                device_hz: self.device_hz.unwrap_or(DEVICE_HZ),
                max_slew_n_per_s: finite(settings.max_slew_n_per_s),
                max_device_force_n: finite(settings.max_force_n),
                max_speed_m_per_s: finite(settings.max_speed_m_per_s),
                engage_ramp_ms: (f32::from(settings.ramp_ticks) * settings.tick_s * 1e3).round()
                    as u16,
            }
        }))
    }
}

fn delay(text: &str) -> Checked<Delay> {
    let told = text.parse().ok().filter(|ticks| *ticks <= DELAY_MAX).map(Delay::Told);
    match text {
        "auto" => Ok(Delay::Measured),
        _ => told.ok_or_else(|| format!("must be 0 to {DELAY_MAX}, or auto")),
    }
}

fn positive(text: &str) -> Checked<f32> {
    let number = text.parse().ok().filter(|x: &f32| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "must be above 0 and finite".to_owned())
}

fn speed(text: &str) -> Checked<f32> {
    if text == "off" { Ok(f32::INFINITY) } else { positive(text).map_err(|why| why + ", or off") }
}

fn number(text: &str) -> Checked<f32> {
    text.parse().map_err(|_| format!("\"{text}\" is no number"))
}

/// A part of the stage in the ranges that the kernel takes.
fn part<Part: Copy>(
    part: Part,
    settings: impl FnOnce(Option<Part>) -> StageSettings,
) -> Checked<OrNone<Part>> {
    settings(Some(part)).check().map_err(|why| why.to_string())?;
    Ok(OrNone(Some(part)))
}

fn coupling(text: &str) -> Checked<OrNone<Coupling>> {
    if text == "none" {
        return Ok(OrNone(None));
    }
    let (stiffness, damping) = text.split_once(':').unwrap_or((text, "0"));
    let coupling =
        Coupling { stiffness_n_per_m: number(stiffness)?, damping_n_s_per_m: number(damping)? };
    part(coupling, |coupling| StageSettings { coupling, ..StageSettings::NONE })
}

fn passivity(text: &str) -> Checked<OrNone<Passivity>> {
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
        assert_eq!(stage(&[]).settings().unwrap(), None);
        assert_eq!(stage(&[]).report().unwrap(), None);
        assert!(stage(&[]).to_args().is_empty());
    }

    #[test]
    fn what_is_given_goes_before_the_profile() {
        let falcon = stage(&["--device", "falcon"]).settings().unwrap().unwrap();
        let profile = StageSettings::for_device(Device::Falcon);
        assert_eq!(falcon, StageSettings { watchdog_ticks: 0, ..profile });
        let args = ["--device=falcon", "--coupling=none", "--max-device-force-n=2"];
        let mine = stage(&args).settings().unwrap().unwrap();
        assert_eq!((mine.max_force_n, mine.coupling), (2.0, None));
        assert_eq!(mine.passivity, falcon.passivity);
    }

    #[test]
    fn a_child_gets_the_same_stage() {
        let all: &[&str] = &[
            "--device=sigma",
            "--coupling=700.5:0.25",
            "--passivity=0.1",
            "--delay-ticks=3",
            "--device-hz=4000",
            "--max-slew-n-per-s=50",
            "--max-device-force-n=2.5",
            "--max-speed-m-per-s=3.5",
            "--engage-ramp-ms=7",
        ];
        let any = &["--device=touch", "--max-speed-m-per-s=off"];
        for args in [all, &["--coupling=none", "--passivity=none"], &["--device=touch"], any] {
            let parent = stage(args);
            let passed: Vec<String> =
                parent.to_args().into_iter().map(|arg| arg.into_string().unwrap()).collect();
            let passed: Vec<&str> = passed.iter().map(String::as_str).collect();
            let (settings, report) = (parent.settings().unwrap(), parent.report().unwrap());
            assert_eq!(stage(&passed).settings().unwrap(), settings, "{args:?}");
            assert_eq!(stage(&passed).report().unwrap(), report, "{args:?}");
        }
    }

    #[test]
    fn a_delay_is_the_stages_and_a_tick_is_the_devices() {
        let late = stage(&["--device=omega", "--delay-ticks=4", "--device-hz=500"]);
        let settings = late.settings().unwrap().unwrap();
        assert_eq!((settings.tick_s, settings.ramp_ticks), (2.0e-3, 50));
        assert_eq!(settings.passivity.unwrap().delay_ticks, 4);
        let report = late.report().unwrap().unwrap();
        // 2 b / ((1 + 2 d) h) of 0.5 N s/m, and 0.65 of it.
        assert!((report.passive_n_per_m.unwrap() - 1.0 / 0.018).abs() < 1e-3, "{report:?}");
        assert!((report.coupling_n_per_m.unwrap() - 0.65 / 0.018).abs() < 1e-3, "{report:?}");
        assert_eq!(report.engage_ramp_ms, 100);
    }

    #[test]
    fn a_delay_that_nothing_makes_up_for_is_refused() {
        for args in [&["--delay-ticks=2"][..], &["--passivity=0.5", "--delay-ticks=2"]] {
            assert!(stage(args).settings().is_err(), "{args:?}");
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
            "--max-speed-m-per-s=0",
            "--max-speed-m-per-s=none",
            "--engage-ramp-ms=60001",
            "--delay-ticks=17",
            "--device-hz=9",
            "--device=hammer",
        ] {
            assert!(Line::try_parse_from(["chaincell", args]).is_err(), "{args}");
        }
    }
}
