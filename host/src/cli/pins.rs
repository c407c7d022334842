//! Pins that a run or a session begins with.

use chaincell_kernel::PinError;
use chaincell_kernel::trace::Command;

use serde::{Deserialize, Serialize};

use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::files::output::{PinCourse, PinRows};
use crate::terminal;

/// Pins of the first tick.
#[derive(Debug, Clone, Default, Serialize, Deserialize, clap::Args)]
pub struct PinArgs {
    /// Pin the surface within RADIUS of a point where it is at rest: held in the world, rigidly or with a stiffness
    /// [N/m] in all; metres, once for each pin, which count from 0. Needs tools (--contact probe:RADIUS or --tool)
    #[arg(long = "pin", value_name = "X,Y,Z,RADIUS[,N_PER_M]", allow_hyphen_values = true, value_parser = place)]
    pins: Vec<Place>,
}

/// A place at which the surface is pinned.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Place {
    point_m: [f32; 3],
    radius_m: f32,
    /// `None` for a rigid one [N/m].
    stiffness_n_per_m: Option<f32>,
}

impl Place {
    /// Returns the command that pins the surface there.
    pub fn command(&self) -> Command {
        let Self { point_m, radius_m, .. } = *self;
        Command::PinAt { point_m, radius_m, stiffness_n_per_m: self.stiffness_n_per_m() }
    }

    /// Infinite for a rigid pin.
    fn stiffness_n_per_m(&self) -> f32 {
        self.stiffness_n_per_m.unwrap_or(f32::INFINITY)
    }
}

/// Adds the output of each pin after a tick.
pub fn add_pins(rows: &mut PinRows, tick: u64, engine: &mut Engine<'_>) {
    for pin in engine.pins() {
        if let Some(output) = engine.pin_output(pin) {
            rows.add(tick, pin, &output);
        }
    }
}

/// Prints the largest force of each pin; names have this width.
///
/// # Errors
/// Standard output that cannot be written.
pub fn tell_pins(width: usize, courses: &[PinCourse]) -> Result<()> {
    for course in courses {
        let (given_mm, force_n) = (1e3 * course.largest_given_m, course.largest_force_n);
        terminal::say(format_args!(
            "  {:<width$}{force_n:.4} N, largest; gives {given_mm:.4} mm",
            format!("pin {}", course.pin)
        ))?;
    }
    Ok(())
}

/// A pin that was set, and the hash of the state after it.
pub type Pinned = (Command, u64);

impl PinArgs {
    /// Returns true without a pin.
    pub fn is_empty(&self) -> bool {
        self.pins.is_empty()
    }

    /// Sets the pins on a body at rest. Returns the commands for a trace.
    ///
    /// # Errors
    /// A pin that the tissue refuses, with the remedy.
    pub fn set(&self, engine: &mut Engine<'_>) -> Result<Vec<Pinned>> {
        let each = self.pins.iter().map(|place| {
            let &Place { point_m, radius_m, .. } = place;
            engine.pin_at(point_m, radius_m, place.stiffness_n_per_m()).map_err(|why| {
                let [x, y, z] = point_m;
                let remedy = match why {
                    PinError::NoTools => "; pass --contact probe:RADIUS or --tool",
                    _ => "",
                };
                Error::input(format!("--pin {x},{y},{z},{radius_m}: {why}{remedy}"))
            })?;
            Ok((place.command(), engine.state_hash()))
        });
        each.collect()
    }
}

/// Reads a stiffness \[N/m\].
pub fn stiffness(text: &str) -> std::result::Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|x| *x >= 1e-6);
    number
        .ok_or_else(|| "give a stiffness of at least 1e-6 N/m, or none for a rigid pin".to_owned())
}

/// Reads a place.
pub fn place(text: &str) -> std::result::Result<Place, String> {
    let wrong = || {
        "give the point and the radius in metres, as in 0,0,0.04,0.006, and a stiffness in N/m behind them if the \
         pin is not to be rigid"
            .to_owned()
    };
    let numbers: Vec<&str> = text.split(',').map(str::trim).collect();
    let (first, last) = match numbers.len() {
        4 => (&numbers[..], None),
        5 => (&numbers[..4], Some(numbers[4])),
        _ => return Err(wrong()),
    };
    let mut values = [0.0_f32; 4];
    for (value, number) in values.iter_mut().zip(first) {
        *value = number.parse().ok().filter(|x: &f32| x.is_finite()).ok_or_else(wrong)?;
    }
    let [x, y, z, radius_m] = values;
    if radius_m <= 0.0 {
        return Err("the radius of a pin must be above 0".to_owned());
    }
    let stiffness_n_per_m = last.map(stiffness).transpose()?;
    Ok(Place { point_m: [x, y, z], radius_m, stiffness_n_per_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_are_read_or_name_the_remedy() {
        let stiffness_n_per_m = None;
        let rigid = Place { point_m: [-0.01, 0.0, 0.04], radius_m: 0.006, stiffness_n_per_m };
        assert_eq!(place("-0.01, 0,0.04,0.006"), Ok(rigid));
        assert_eq!(
            place("-0.01,0,0.04,6e-3,20"),
            Ok(Place { stiffness_n_per_m: Some(20.0), ..rigid })
        );
        for (bad, part) in [
            ("0,0,0.04", "as in 0,0,0.04,0.006"),
            ("0,0,x,0.006", "as in 0,0,0.04,0.006"),
            ("0,0,nan,0.006", "as in 0,0,0.04,0.006"),
            ("0,0,0.04,0", "above 0"),
            ("0,0,0.04,0.006,0", "at least 1e-6 N/m"),
            ("0,0,0.04,0.006,1e-9", "at least 1e-6 N/m"),
            ("0,0,0.04,0.006,nan", "at least 1e-6 N/m"),
            ("0,0,0.04,0.006,2,3", "as in 0,0,0.04,0.006"),
        ] {
            let why = place(bad).unwrap_err();
            assert!(why.contains(part), "{bad}: {why}");
        }
    }
}
