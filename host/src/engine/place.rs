//! Place of the built-in press on a body.

use chaincell_kernel::{Model, ToolPart};
use nalgebra::Vector3;

use super::contact::{farthest, inward};
use super::reach::Reach;
use super::{Contact, rest_m};
use crate::error::{Error, Result};

/// Point of touch and direction of a press.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Position of the tool at the touch \[m\]; all of a tool is then outside of the body.
    pub touch_m: [f64; 3],
    /// Unit vector of the press.
    pub direction: [f64; 3],
}

/// The middle of the held cells; with a tool the position of its first touch on the way to the middle cell
/// of `--contact auto`. The direction is into the body along the mean normal there, unless a direction is
/// given.
///
/// # Errors
/// A direction of zero length, a model without a free cell, a tool that would miss the body, a half space as
/// the first tool.
pub fn place(model: &Model<'_>, contact: &Contact, along: Option<[f64; 3]>) -> Result<Place> {
    if contact.first_tool().is_some_and(|parts| parts.iter().any(ToolPart::is_half_space)) {
        return Err(Error::input(
            "`tool` half-space: the built-in press needs a first tool of finite size; put another tool \
             first, or give run or control a `path`",
        ));
    }
    // The cells to press, and the direction.
    let cells = match contact {
        Contact::Cells(cells) => cells.clone(),
        _ => vec![farthest(model)?],
    };
    let direction = Vector3::from(along.unwrap_or_else(|| inward(model, &cells)));
    let length = direction.norm();
    if !(length.is_finite() && length > 0.0) {
        return Err(Error::input("`direction`: its length must be finite and above 0"));
    }
    let direction = direction / length;
    // Their mean position.
    let mut touch_m = [0.0; 3];
    for &cell in &cells {
        let at = rest_m(model, cell.into());
        for axis in 0..3 {
            touch_m[axis] += at[axis] / cells.len() as f64;
        }
    }
    // A tool begins where it first touches.
    if let Some(parts) = contact.first_tool() {
        let way_m = Reach::of(model).first_touch_m(touch_m, (-direction).into(), parts);
        let way_m = way_m.ok_or_else(|| {
            Error::input(
                "the built-in press would pass by the body: give run or control `touch_m` and \
                 `direction`",
            )
        })?;
        touch_m = (Vector3::from(touch_m) - direction * way_m).into();
    }
    Ok(Place { touch_m, direction: direction.into() })
}
