//! Forces of pins as CSV, and the course of each.

use std::fmt::Write as _;

use chaincell_kernel::PinOutput;
use serde::Serialize;

use super::Folder;
use crate::error::Result;

/// Columns, as the contract defines them.
const HEADER: &str = "tick,pin,fx_n,fy_n,fz_n,given_m\n";

/// The course of a pin in a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PinCourse {
    /// Number of the pin.
    pub pin: u16,
    /// Number of samples of the surface that it holds.
    pub samples: u32,
    /// Its stiffness [N/m].
    pub stiffness_n_per_m: f32,
    /// Where it is \[m\].
    pub position_m: [f32; 3],
    /// Largest force of the tissue on it \[N\].
    pub largest_force_n: f32,
    /// Largest way that the tissue moved from it \[m\].
    pub largest_given_m: f32,
}

/// Rows of pins, tick by tick.
#[derive(Debug, Default)]
pub struct PinRows {
    text: String,
    courses: Vec<PinCourse>,
}

impl PinRows {
    /// Adds the output of a pin in a tick; decimals read back as the same numbers.
    pub fn add(&mut self, tick: u64, pin: u16, output: &PinOutput) {
        let [x, y, z]: [f32; 3] = output.force_n.into();
        let length = |[x, y, z]: [f32; 3]| x.hypot(y).hypot(z);
        let (force_n, given_m) = (length([x, y, z]), length(output.given_m));
        let _ = writeln!(self.text, "{tick},{pin},{x:e},{y:e},{z:e},{given_m:e}");
        // A number that was released may be that of another pin.
        let is_same =
            |course: &PinCourse| course.pin == pin && course.position_m == output.position_m;
        let place = self.courses.iter().rposition(is_same);
        let place = place.unwrap_or_else(|| {
            let &PinOutput { samples, stiffness_n_per_m, position_m, .. } = output;
            let (largest_force_n, largest_given_m) = (0.0, 0.0);
            self.courses.push(PinCourse {
                pin,
                samples,
                stiffness_n_per_m,
                position_m,
                largest_force_n,
                largest_given_m,
            });
            self.courses.len() - 1
        });
        let course = &mut self.courses[place];
        course.largest_force_n = course.largest_force_n.max(force_n);
        course.largest_given_m = course.largest_given_m.max(given_m);
    }

    /// The course of each pin, in the order in which they were set.
    #[must_use]
    pub fn courses(&self) -> &[PinCourse] {
        &self.courses
    }

    /// Writes `pins.csv`, if there were pins.
    ///
    /// # Errors
    /// As [`Folder::write`].
    pub fn write(&self, folder: &Folder) -> Result<()> {
        if self.courses.is_empty() {
            return Ok(());
        }
        folder.write("pins.csv", self.table().as_bytes())
    }

    /// The whole table, with its heading.
    #[must_use]
    pub fn table(&self) -> String {
        format!("{HEADER}{}", self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_value_for_each_column_and_the_course_the_largest() {
        let output = |force: f32| PinOutput {
            force_n: [0.0, 0.6 * force, 0.8 * force].into(),
            position_m: [0.0; 3],
            given_m: [0.0, 0.0, 0.001 * force],
            stiffness_n_per_m: 1000.0,
            energy_j: 0.0,
            samples: 7,
        };
        let mut rows = PinRows::default();
        for (tick, force) in [(1, 0.0), (2, 2.0), (3, 1.0)] {
            rows.add(tick, 4, &output(force));
        }
        assert_eq!(rows.text.lines().next(), Some("1,4,0e0,0e0,0e0,0e0"));
        assert!(rows.text.lines().all(|row| row.split(',').count() == HEADER.split(',').count()));
        let [course] = rows.courses() else { panic!("one pin") };
        assert_eq!((course.pin, course.samples), (4, 7));
        assert!((course.largest_force_n - 2.0).abs() < 1e-6, "{course:?}");
        assert!((course.largest_given_m - 0.002).abs() < 1e-9, "{course:?}");
    }
}
