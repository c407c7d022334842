//! The report of `info --probe` about a sphere on a model.

use chaincell_kernel::Model;
use serde::Serialize;

use crate::engine::slow_press::slow_press;
use crate::error::{Error, Result};
use crate::terminal;

/// A sphere of one radius, pressed slowly into the model.
#[derive(Debug, Serialize)]
pub struct ProbeReport {
    radius_m: f32,
    /// Fewest and most samples along a side of a triangle.
    samples_per_side: [u16; 2],
    /// Least and largest stiffness of the samples of a triangle together.
    contact_stiffness_n_per_m: [f32; 2],
    /// Deepest that the slow press went, and the length of its steps.
    pressed_m: f64,
    step_m: f64,
    /// Depth at which the sphere first stays behind the tool, and the force there.
    behind_depth_m: Option<f64>,
    behind_force_n: Option<f32>,
    /// Smallest force from there on.
    behind_least_force_n: Option<f32>,
    /// `depth`, or `energy` where the largest energy that a tool may load holds it.
    behind_by: Option<&'static str>,
    /// Depth at which nothing touches the tool any more.
    lost_depth_m: Option<f64>,
}

impl ProbeReport {
    /// Presses slowly, for some seconds.
    ///
    /// # Errors
    /// A radius out of range; a model without a contact surface; no place for the press; Ctrl-C.
    pub fn new(model: &Model<'_>, radius_m: f32) -> Result<Self> {
        // Refuse a radius, or a model, without contact.
        let most_m = model.saturation() * model.unit_m();
        if !(radius_m > 0.0 && radius_m <= most_m) {
            return Err(Error::input(format!(
                "--probe {radius_m}: the radius must be above 0 and at most {most_m} m, the body's \
                 own bound (--k-m of bake)"
            )));
        }
        if !model.has_contact_surface() {
            return Err(Error::input(format!(
                "--probe {radius_m}: this model has no contact surface; bake it with \
                 --contact-surface yes"
            )));
        }
        // Press slowly, and take the figures of all triangles.
        let press = slow_press(model, radius_m)?;
        let (mut samples, mut stiffness) = ([u16::MAX, 0], [f32::INFINITY, 0.0_f32]);
        model.each_contact_triangle(radius_m, |parts, n_per_m| {
            samples = [samples[0].min(parts), samples[1].max(parts)];
            stiffness = [stiffness[0].min(n_per_m), stiffness[1].max(n_per_m)];
        });
        Ok(Self {
            radius_m,
            samples_per_side: samples,
            contact_stiffness_n_per_m: stiffness,
            pressed_m: press.pressed_m,
            step_m: press.step_m,
            behind_depth_m: press.behind.map(|behind| behind.depth_m),
            behind_force_n: press.behind.map(|behind| behind.force_n),
            behind_least_force_n: press.behind.map(|behind| behind.least_n),
            lost_depth_m: press.lost_m,
            behind_by: press.behind.map(|of| if of.by_energy { "energy" } else { "depth" }),
        })
    }

    /// A table on standard output.
    pub fn print(&self) -> Result<()> {
        let row = |name: &str, value: String| terminal::say(format_args!("  {name:<14}{value}"));
        let millimetres = |metres: f64| format!("{:.1} mm", 1e3 * metres);
        // Print the contact of a triangle.
        row("probe", millimetres(self.radius_m.into()))?;
        let [fewest, most] = self.samples_per_side;
        row("samples", format!("{fewest} to {most} along each side of a triangle"))?;
        let [least, largest] = self.contact_stiffness_n_per_m;
        row("contact", format!("{least:.1} to {largest:.1} N/m a triangle"))?;
        // Print the depth at which the sphere is held back.
        let pressed = millimetres(self.pressed_m);
        match (self.behind_depth_m, self.behind_force_n, self.behind_by) {
            (Some(depth_m), Some(force_n), Some("energy")) => row(
                "energy bound",
                format!(
                    "reached {} deep, at {force_n:.3} N (--energy-max-j)",
                    millimetres(depth_m)
                ),
            )?,
            (Some(depth_m), Some(force_n), _) => row(
                "never through",
                format!(
                    "first holds the sphere back at {}, at {force_n:.3} N",
                    millimetres(depth_m)
                ),
            )?,
            _ => row("never through", format!("not needed down to {pressed}"))?,
        }
        // Print the depth at which the sphere lost the body, or the least force.
        if let Some(depth_m) = self.lost_depth_m {
            return row(
                "lost",
                format!(
                    "from {} on nothing touches the sphere: it slid off the side of the body, or slack \
                     tissue let it by; a press there has no force",
                    millimetres(depth_m)
                ),
            );
        }
        self.behind_least_force_n.map_or(Ok(()), |least_n| {
            row("", format!("a slow press feels {least_n:.3} N or more from there to {pressed}"))
        })
    }
}
