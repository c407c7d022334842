//! Arguments of the built-in press, shared by `run` and `control`.

use chaincell_kernel::Model;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::bake::tissue::DEVICE_HZ;
use crate::engine::Contact;
use crate::engine::motion::{Pose, Press};
use crate::engine::place::place;
use crate::engine::reach::size_m;
use crate::error::{Error, Result};
use crate::words::length;

/// Depth unless given [mean link lengths], and where no model is known [m].
const DEPTH_LINKS: f64 = 3.0;
const DEPTH_M: f64 = 0.01;
/// Depth that nobody means [lengths of the body].
const TOO_DEEP: f64 = 10.0;

/// A built-in motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
pub enum Motion {
    /// Approach, press, hold, retreat
    #[default]
    Press,
}

/// Where the press goes, how deep and how long.
#[derive(Debug, Clone, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct PressArgs {
    /// Point where the press touches, x,y,z [m]; with a tool its position then, all of it outside
    /// [default: at the contact of the model; 0,0,0 where no model is known]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true,
        conflicts_with = "path")]
    touch_m: Option<Vector>,
    /// Direction of the press [default: into the model's body; 0,0,-1 where no model is known]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true,
        conflicts_with = "path")]
    direction: Option<Vector>,
    /// Depth of the press [m] [default: 3 mean link lengths; 0.01 where no model is known]
    #[arg(long, value_name = "D", allow_negative_numbers = true, conflicts_with = "path")]
    depth_m: Option<f64>,
    /// Length of the press [s]
    #[arg(
        long,
        default_value_t = 10.0,
        value_name = "S",
        allow_negative_numbers = true,
        conflicts_with = "path"
    )]
    seconds: f64,
}

/// Three coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Vector(pub [f64; 3]);

/// Reads `X,Y,Z`.
pub fn vector(text: &str) -> std::result::Result<Vector, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    let three = numbers.and_then(|numbers| numbers.try_into().ok());
    three.map(Vector).ok_or_else(|| "give three finite numbers, x,y,z".to_owned())
}

/// Ticks in a number of seconds, at a rate \[Hz\].
///
/// # Errors
/// Less than the built-in press has room for, more than a day, or no number.
pub fn ticks(seconds: f64, hz: u32) -> Result<u64> {
    if seconds.is_finite() && (0.02..=86_400.0).contains(&seconds) {
        Ok((seconds * f64::from(hz)).round() as u64)
    } else {
        Err(Error::input(format!("--seconds {seconds}: must be from 0.02 to 86400")))
    }
}

/// A press of a depth \[m\] on a body, in a number of ticks.
///
/// # Errors
/// No place for it, see [`place`]; a bad depth; too few ticks.
pub fn press_on(
    model: &Model<'_>,
    contact: &Contact,
    depth_m: Option<f64>,
    ticks: u64,
) -> Result<Vec<Pose>> {
    let args = PressArgs { touch_m: None, direction: None, depth_m, seconds: 0.0 };
    args.along(model, contact, ticks, DEVICE_HZ)
}

impl PressArgs {
    /// The press on a body, at a rate of ticks \[Hz\].
    ///
    /// # Errors
    /// As [`press_on`]; a bad number of seconds.
    pub fn on(&self, model: &Model<'_>, contact: &Contact, hz: u32) -> Result<Vec<Pose>> {
        self.along(model, contact, ticks(self.seconds, hz)?, hz)
    }

    /// The press where the body is not known.
    ///
    /// # Errors
    /// A bad direction, depth or number of seconds.
    pub fn anywhere(&self) -> Result<Vec<Pose>> {
        let touch_m = self.touch_m.map_or([0.0; 3], |touch| touch.0);
        let direction = self.direction.map_or([0.0, 0.0, -1.0], |direction| direction.0);
        let depth_m = self.depth_m.unwrap_or(DEPTH_M);
        Ok(Press::new(touch_m, direction, depth_m, ticks(self.seconds, DEVICE_HZ)?)?.poses())
    }

    /// Returns true if an option says where it touches.
    pub fn is_placed(&self) -> bool {
        self.touch_m.is_some()
    }

    /// The press on a body, in a number of ticks at a rate \[Hz\].
    fn along(
        &self,
        model: &Model<'_>,
        contact: &Contact,
        ticks: u64,
        hz: u32,
    ) -> Result<Vec<Pose>> {
        let direction = self.direction.map(|direction| direction.0);
        let depth_m = self.depth_m.unwrap_or(DEPTH_LINKS * f64::from(model.unit_m()));
        let size_m = size_m(model);
        if self.depth_m.is_some_and(|depth_m| depth_m.is_finite() && depth_m > TOO_DEEP * size_m) {
            return Err(Error::input(format!(
                "`depth_m` {depth_m:?}: {} into a body of {}; give the depth in metres",
                length(depth_m),
                length(size_m)
            )));
        }
        let (touch_m, direction) = match (self.touch_m, direction) {
            (Some(touch), Some(direction)) => (touch.0, direction),
            (touch, direction) => {
                let place = place(model, contact, direction)?;
                (touch.map_or(place.touch_m, |touch| touch.0), place.direction)
            }
        };
        Ok(Press::new(touch_m, direction, depth_m, ticks)?.at_rate(hz).poses())
    }
}
