//! Detects a path that leads far beyond the body, such as one in millimetres that is read in metres.

use std::fmt;

use nalgebra::Vector3;

use super::motion::Pose;
use super::reach::size_m;
use super::{Contact, Engine};

/// Distance from the body's middle, in body lengths, from which on a tool is far.
const AWAY: f64 = 10.0;

/// Extent of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Far {
    /// Largest displacement of the held cells; for another tool, its smallest distance from the body's middle
    /// \[m\].
    way_m: f64,
    is_held: bool,
    /// Length of the body \[m\].
    size_m: f64,
}

impl Far {
    /// Checks the executed poses; `None` if they move held cells by no more than the body's length, or if
    /// another tool comes near the body.
    #[must_use]
    pub fn of(engine: &Engine<'_>, poses: &[Pose]) -> Option<Self> {
        let model = engine.network().model();
        let size_m = size_m(model);
        let is_held = matches!(engine.contact(), Contact::Cells(_));
        let (way_m, least_m) = if is_held {
            (farthest_m(poses)?, size_m)
        } else {
            (nearest_m(poses, model.centre_m())?, AWAY * size_m)
        };
        (way_m > least_m).then_some(Self { way_m, is_held, size_m })
    }
}

impl fmt::Display for Far {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { way_m, size_m, .. } = self;
        if self.is_held {
            write!(f, "the path moves the held cells by {way_m:.3} m")?;
        } else {
            write!(f, "the path comes no nearer to the middle of the body than {way_m:.3} m")?;
        }
        write!(f, ", and the body is {size_m:.3} m long")
    }
}

fn place(pose: &Pose) -> Option<Vector3<f64>> {
    let is_good = pose.position_m.iter().all(|x| x.is_finite());
    is_good.then(|| Vector3::from(pose.position_m.map(f64::from)))
}

/// Largest displacement of the tool from where it engaged; `None` if it never engaged.
fn farthest_m(poses: &[Pose]) -> Option<f64> {
    let (mut from, mut most) = (None, None::<f64>);
    for pose in poses {
        if pose.engaged != 1 {
            from = None;
        } else if let Some(at) = place(pose) {
            let way_m = (at - *from.get_or_insert(at)).norm();
            most = Some(most.unwrap_or(0.0).max(way_m));
        }
    }
    most
}

/// Smallest distance of the engaged tool from a point; `None` if it is never engaged.
fn nearest_m(poses: &[Pose], to_m: [f32; 3]) -> Option<f64> {
    let to = Vector3::from(to_m.map(f64::from));
    let engaged = poses.iter().filter(|pose| pose.engaged == 1);
    engaged.filter_map(place).map(|at| (at - to).norm()).reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_counts_from_where_the_tool_engaged() {
        let pose =
            |x: f32, engaged: u32| Pose { position_m: [x, 0.0, 0.0], engaged, ..Pose::default() };
        let poses = [
            pose(9.0, 0),
            pose(1.0, 1),
            pose(1.5, 1),
            pose(8.0, 0),
            pose(7.0, 1),
            pose(f32::NAN, 1),
        ];
        assert_eq!(farthest_m(&poses), Some(0.5));
        assert_eq!(nearest_m(&poses, [2.0, 0.0, 0.0]), Some(0.5));
        assert_eq!((farthest_m(&poses[..1]), nearest_m(&poses[..1], [0.0; 3])), (None, None));
        let far = Far { way_m: 12.0, is_held: true, size_m: 0.1 };
        assert_eq!(
            far.to_string(),
            "the path moves the held cells by 12.000 m, and the body is 0.100 m long"
        );
    }
}
