//! The course of a run for each tool: whether it touched the body, its largest force, and the depth at which
//! the tissue held it back.
//!
//! **Bounded cost.** Each tick compares two moments per tool, and allocates nothing.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// A tick of a tool.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Moment {
    force_n: [f32; 3],
    /// Pose of the tool \[m\].
    asked_m: [f32; 3],
    /// Pose at which the tissue meets it \[m\].
    reached_m: [f32; 3],
}

/// Collects what one tool does, tick by tick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Course {
    has_touched: bool,
    /// True from its first tick without a contact on: one that begins in a press has no first contact yet.
    was_free: bool,
    touch_m: Option<[f32; 3]>,
    largest_force_n: f32,
    /// The moment of the largest force.
    loaded: Option<Moment>,
    /// The moment at which the tissue was farthest behind the tool.
    behind: Option<Moment>,
}

/// Result of a tool's course.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ToolCourse {
    /// True if it had a contact.
    pub has_touched: bool,
    /// Largest force on it \[N\].
    pub largest_force_n: f32,
    /// Its position at the first contact \[m\]; `None` if that is unknown.
    pub touch_m: Option<[f32; 3]>,
    /// Depth below the first contact along the force, where the tool was farthest ahead of the tissue, or
    /// else where the force was largest \[m\]; `None` if that is unknown.
    pub asked_m: Option<f64>,
    /// Depth at which the tissue met the tool then \[m\].
    pub reached_m: Option<f64>,
}

impl Course {
    /// Adds a tick: force on the tool \[N\], its contacts, and its position with that at which the tissue
    /// meets it \[m\], if they are known.
    pub fn add(&mut self, force_n: [f32; 3], contacts: u32, places_m: Option<[[f32; 3]; 2]>) {
        let size_n = size(force_n);
        let is_largest = size_n > self.largest_force_n;
        self.largest_force_n = self.largest_force_n.max(size_n);
        if contacts == 0 {
            self.was_free = true;
            return;
        }
        self.has_touched = true;
        if !self.was_free {
            return;
        }
        let Some([asked_m, reached_m]) = places_m else { return };
        if !asked_m.iter().chain(&reached_m).all(|x| x.is_finite()) {
            return;
        }
        self.touch_m.get_or_insert(asked_m);
        let moment = Moment { force_n, asked_m, reached_m };
        if is_largest {
            self.loaded = Some(moment);
        }
        if self.behind.is_none_or(|behind| moment.gap_m() > behind.gap_m()) {
            self.behind = Some(moment);
        }
    }

    /// The result so far.
    #[must_use]
    pub fn result(&self) -> ToolCourse {
        let depths_m = self.depths_m();
        ToolCourse {
            has_touched: self.has_touched,
            largest_force_n: self.largest_force_n,
            touch_m: self.touch_m,
            asked_m: depths_m.map(|[asked_m, _]| asked_m),
            reached_m: depths_m.map(|[_, reached_m]| reached_m),
        }
    }

    /// Depths asked for and reached.
    fn depths_m(&self) -> Option<[f64; 2]> {
        let (touch_m, loaded) = (vector(self.touch_m?), self.loaded?);
        let outward = vector(loaded.force_n).try_normalize(0.0)?;
        let moment = self.behind.filter(|behind| behind.gap_m() > ROUNDING_M).unwrap_or(loaded);
        let depth_m = |at_m| (touch_m - vector(at_m)).dot(&outward);
        Some([moment.asked_m, moment.reached_m].map(depth_m))
    }
}

/// Largest force on any of the tools \[N\].
#[must_use]
pub fn largest_n(courses: &[ToolCourse]) -> f32 {
    courses.iter().map(|of| of.largest_force_n).fold(0.0, f32::max)
}

/// Gaps up to this one are rounding \[m\].
const ROUNDING_M: f32 = 1e-6;

impl Moment {
    /// Distance of the tissue behind the tool.
    fn gap_m(&self) -> f32 {
        let [asked, reached] = [self.asked_m, self.reached_m];
        size(std::array::from_fn(|axis| asked[axis] - reached[axis]))
    }
}

fn size([x, y, z]: [f32; 3]) -> f32 {
    x.hypot(y).hypot(z)
}

fn vector(of: [f32; 3]) -> Vector3<f64> {
    Vector3::from(of.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Down along z by 1 mm a tick to 10 mm; the tissue follows to `held_m`.
    fn press(held_m: f32) -> ToolCourse {
        let mut course = Course::default();
        for tick in 0..=12_u8 {
            let depth_m = 1e-3 * (f32::from(tick) - 2.0);
            let contacts = u32::from(depth_m >= 0.0);
            let reached_m = depth_m.min(held_m);
            let force_n = [0.0, 0.0, 10.0 * reached_m.max(0.0)];
            course.add(force_n, contacts, Some([[0.0, 0.0, -depth_m], [0.0, 0.0, -reached_m]]));
        }
        course.result()
    }

    #[test]
    fn depths_are_those_at_which_the_tissue_is_farthest_behind() {
        let held = press(0.0073);
        assert!(held.has_touched && held.touch_m == Some([0.0; 3]));
        assert!((held.asked_m.unwrap() - 0.01).abs() < 1e-6, "{held:?}");
        assert!((held.reached_m.unwrap() - 0.0073).abs() < 1e-6, "{held:?}");
        assert!((held.largest_force_n - 0.073).abs() < 1e-6, "{held:?}");
        let free = press(1.0);
        assert_eq!(free.asked_m, free.reached_m);
        assert!((free.asked_m.unwrap() - 0.01).abs() < 1e-6, "{free:?}");
    }

    /// A body that goes on from a snapshot may be in a press: the place of that is no first contact.
    #[test]
    fn one_that_begins_in_a_press_first_touches_after_it() {
        let mut course = Course::default();
        let at = |depth_m: f32| Some([[0.0, 0.0, -depth_m]; 2]);
        course.add([0.0, 0.0, 0.05], 1, at(0.005));
        let of = course.result();
        assert!(of.has_touched && of.touch_m.is_none() && of.asked_m.is_none());
        course.add([0.0; 3], 0, at(-0.001));
        course.add([0.0, 0.0, 0.01], 1, at(0.001));
        course.add([0.0, 0.0, 0.1], 1, at(0.01));
        let of = course.result();
        assert_eq!(of.touch_m, Some([0.0, 0.0, -0.001]));
        assert!((of.asked_m.unwrap() - 0.009).abs() < 1e-6, "{of:?}");
    }

    #[test]
    fn without_contact_or_places_there_is_no_depth() {
        let mut course = Course::default();
        course.add([0.0; 3], 0, Some([[0.0; 3]; 2]));
        assert_eq!(course.result(), ToolCourse::default());
        course.add([0.0, 3.0, 4.0], 1, None);
        let of = course.result();
        assert!(of.has_touched && of.touch_m.is_none() && of.asked_m.is_none());
        assert_eq!(of.largest_force_n, 5.0);
        course.add([0.0, 3.0, 4.0], 1, Some([[f32::NAN; 3], [0.0; 3]]));
        assert!(course.result().touch_m.is_none());
    }
}
