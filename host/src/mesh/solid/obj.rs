//! Wavefront OBJ surfaces: vertices and faces; everything else is passed over.

use std::path::Path;

use super::{Faces, SurfaceReader};
use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};

/// Reader of `.obj` files.
pub(super) struct Obj;

impl SurfaceReader for Obj {
    fn name(&self) -> &'static str {
        "OBJ .obj"
    }

    fn extension(&self) -> &'static str {
        "obj"
    }

    fn is_in(&self, _: &[u8]) -> bool {
        false
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<Faces> {
        let mut bytes = Bytes::new(path, bytes, 0);
        bytes.lines = true;
        let mut faces = Faces::default();
        while let Some(line) = bytes.text_line("#")? {
            let mut words = line.split_ascii_whitespace();
            let kind = words.next().unwrap_or_default();
            if line.ends_with('\\') && matches!(kind, "v" | "f") {
                return Err(bytes.error(
                    "a line that goes on in the next; write each vertex and face on one line",
                ));
            }
            match kind {
                "v" => {
                    let mut place_m = [0.0; 3];
                    for (value, name) in place_m.iter_mut().zip(["x", "y", "z"]) {
                        let word = words.next().unwrap_or("");
                        *value = bytes.metres_of(word, unit_m, name)?;
                    }
                    faces.points_m.push(place_m);
                }
                "f" => {
                    let mut corners = Vec::new();
                    for word in words.take_while(|word| !word.starts_with('#')) {
                        corners.push(corner(word, faces.points_m.len(), &bytes)?);
                    }
                    faces.polygon(&corners, &bytes)?;
                }
                _ => {}
            }
        }
        Ok(faces)
    }
}

/// The vertex of `vertex/texture/normal`: from 1, or from the end where it is negative.
fn corner(word: &str, points: usize, bytes: &Bytes) -> Result<u32> {
    let number = word.split('/').next().and_then(|number| number.parse::<i64>().ok());
    let place = match number {
        Some(number @ 1..) => number.checked_sub(1),
        Some(number @ ..=-1) => number.checked_add(points as i64),
        _ => None,
    };
    match place.and_then(|place| u32::try_from(place).ok()) {
        Some(place) if (place as usize) < points => Ok(place),
        _ => Err(bytes.error(format!(
            "'{}' where the number of a vertex should be; the vertices in front are 1 to {points}: save \
             or copy it again",
            shown(word)
        ))),
    }
}
