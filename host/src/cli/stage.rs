//! Arguments of the output stage between the tissue and a device: `run`, `serve`, `cosim`.

use std::fmt;
use std::str::FromStr;

use chaincell_kernel::Choice;
use chaincell_kernel::stage::{
    Coupling, DELAY_MAX, Device, HAND_SPEED_MAX_M_PER_S, Passivity, Stage, StageSettings,
    TICKS_MAX, passive_stiffness_n_per_m,
};
use serde::{Deserialize, Serialize};

use super::choice::parser;
use crate::bake::tissue::DEVICE_HZ;
use crate::choice::{self, by_text};
use crate::error::{Error, Result};
use crate::session::timing::clock::SECOND_NS;

/// Options of the output stage between tissue and device; there is none unless one of these is given.
#[derive(Debug, Clone, Default, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
#[command(next_help_heading = "Output stage")]
pub struct StageArgs {
    /// Device whose profile the stage takes; options that are given replace values of the profile. Counts
    /// on 0.5 N s/m of damping in the device: give --passivity with your own
    #[serde(with = "choice::optional")]
    #[arg(long, value_parser = parser::<Device>(), value_name = "DEVICE")]
    device: Option<Device>,
    /// Virtual coupling, a spring [N/m] and a damper [N s/m] between device and tool: K, K:B or none
    #[arg(long, value_name = "K[:B]", allow_hyphen_values = true)]
    coupling: Option<OrNone<Coupling>>,
    /// Passivity observer and controller: the damping that the device has for sure [N s/m], or none.
    /// Where it cannot keep up it lets the force go along --engage-ramp-ms, not without one
    #[arg(long, value_name = "BDEV", allow_hyphen_values = true)]
    passivity: Option<OrNone<Passivity>>,
    /// Ticks between an answer and the device's pushing with it, 0 to 16: 0 where it does so at once. From
    /// 2 on the coupling is weakened to what is passive: `chaincell info --device` prints it. auto:
    /// measured by serve, from the send times of the poses; it begins with 16. 1 by default
    #[arg(long, value_name = "N|auto", allow_hyphen_values = true)]
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
    #[arg(long, value_name = "V|off", allow_hyphen_values = true)]
    max_speed_m_per_s: Option<SpeedLimit>,
    /// Ticks in which the force rises after engaging [ms]
    #[arg(long, value_name = "MS", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(0..=60_000))]
    engage_ramp_ms: Option<u16>,
}

/// An argument as clap takes it.
type Checked<T> = std::result::Result<T, String>;

/// A part of the stage, or the word `none`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OrNone<Part>(Option<Part>);

impl FromStr for OrNone<Coupling> {
    type Err = String;

    fn from_str(text: &str) -> Checked<Self> {
        if text == "none" {
            return Ok(Self(None));
        }
        let (stiffness, damping) = text.split_once(':').unwrap_or((text, "0"));
        let coupling =
            Coupling { stiffness_n_per_m: number(stiffness)?, damping_n_s_per_m: number(damping)? };
        part(coupling, |coupling| StageSettings { coupling, ..StageSettings::NONE })
    }
}

impl FromStr for OrNone<Passivity> {
    type Err = String;

    fn from_str(text: &str) -> Checked<Self> {
        if text == "none" {
            return Ok(Self(None));
        }
        let passivity = Passivity { device_damping_n_s_per_m: number(text)?, delay_ticks: 1 };
        part(passivity, |passivity| StageSettings { passivity, ..StageSettings::NONE })
    }
}

impl fmt::Display for OrNone<Coupling> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => f.write_str("none"),
            Some(of) => write!(f, "{}:{}", of.stiffness_n_per_m, of.damping_n_s_per_m),
        }
    }
}

impl fmt::Display for OrNone<Passivity> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => f.write_str("none"),
            Some(of) => of.device_damping_n_s_per_m.fmt(f),
        }
    }
}

/// The delay of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Delay {
    Told(u8),
    Measured,
}

impl FromStr for Delay {
    type Err = String;

    fn from_str(text: &str) -> Checked<Self> {
        let told = text.parse().ok().filter(|ticks| *ticks <= DELAY_MAX).map(Self::Told);
        match text {
            "auto" => Ok(Self::Measured),
            _ => told.ok_or_else(|| format!("must be 0 to {DELAY_MAX}, or auto")),
        }
    }
}

impl fmt::Display for Delay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Told(ticks) => ticks.fmt(f),
            Self::Measured => f.write_str("auto"),
        }
    }
}

/// Largest speed of the hand, infinite for any \[m/s\].
#[derive(Debug, Clone, Copy, PartialEq)]
struct SpeedLimit(f32);

impl FromStr for SpeedLimit {
    type Err = String;

    fn from_str(text: &str) -> Checked<Self> {
        match text {
            "off" => Ok(Self(f32::INFINITY)),
            _ => positive(text).map(Self).map_err(|why| why + ", or off"),
        }
    }
}

impl fmt::Display for SpeedLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_infinite() { f.write_str("off") } else { self.0.fmt(f) }
    }
}

by_text!(OrNone<Coupling>, OrNone<Passivity>, Delay, SpeedLimit);

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
        let hz = self.hz();
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
            // A delay that is not known yet may be the longest.
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

    /// Ticks in a second.
    #[must_use]
    pub fn hz(&self) -> u32 {
        self.given_hz().unwrap_or(DEVICE_HZ)
    }

    /// Ticks in a second, where they are given.
    #[must_use]
    pub fn given_hz(&self) -> Option<u32> {
        self.device_hz
    }

    /// Largest speed of the hand, infinite for any [m/s].
    #[must_use]
    pub fn max_speed_m_per_s(&self) -> f32 {
        self.max_speed_m_per_s.map_or(HAND_SPEED_MAX_M_PER_S, |limit| limit.0)
    }

    /// A tick of the device, where the delay is measured \[ns\].
    #[must_use]
    pub fn delay_period_ns(&self) -> Option<u64> {
        let period_ns = SECOND_NS / u64::from(self.hz());
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
                device_hz: self.hz(),
                max_slew_n_per_s: finite(settings.max_slew_n_per_s),
                max_device_force_n: finite(settings.max_force_n),
                max_speed_m_per_s: finite(settings.max_speed_m_per_s),
                engage_ramp_ms: (f32::from(settings.ramp_ticks) * settings.tick_s * 1e3).round()
                    as u16,
            }
        }))
    }
}

fn positive(text: &str) -> Checked<f32> {
    let number = text.parse().ok().filter(|x: &f32| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "must be above 0 and finite".to_owned())
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
            let text = serde_json::to_string(&parent).unwrap();
            let child: StageArgs = serde_json::from_str(&text).unwrap();
            assert_eq!(child.settings().unwrap(), parent.settings().unwrap(), "{text}");
            assert_eq!(child.report().unwrap(), parent.report().unwrap(), "{text}");
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
