//! Wavefront OBJ surfaces: vertices and faces; everything else is skipped.

use std::path::Path;

use super::{Faces, SurfaceReader};
use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};
use crate::mesh::format::begins;

/// Bytes that are examined for the format.
const HEAD: usize = 64 << 10;
/// Words with which a file may begin.
const FRONT: [&[u8]; 8] = [b"v", b"vn", b"vt", b"o", b"g", b"s", b"mtllib", b"usemtl"];

/// Reader of `.obj` files.
pub(super) struct Obj;

impl SurfaceReader for Obj {
    fn name(&self) -> &'static str {
        "OBJ .obj"
    }

    fn extension(&self) -> &'static str {
        "obj"
    }

    fn is_in(&self, bytes: &[u8]) -> bool {
        let head = bytes.get(..HEAD).unwrap_or(bytes);
        let lines = head.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
        let mut lines = lines.filter(|line| !line.is_empty() && !line.starts_with(b"#"));
        let is_known = |line: &[u8]| FRONT.iter().any(|word| begins(line, word));
        let is_vertex = |line: &[u8]| line.starts_with(b"v ") || line.starts_with(b"v\t");
        lines
            .next()
            .is_some_and(|first| is_known(first) && (is_vertex(first) || lines.any(is_vertex)))
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<Faces> {
        let mut bytes = Bytes::new(path, bytes, 0);
        bytes.lines = true;
        let mut faces = Faces::default();
        while let Some(line) = bytes.raw_line("#") {
            let kind = line.trim_ascii_start().split(u8::is_ascii_whitespace).next();
            let kind = kind.unwrap_or_default();
            // Names of materials and objects may be in any encoding.
            if !matches!(kind, b"v" | b"f") {
                continue;
            }
            let line = bytes.text_of(line)?;
            let mut words = line.split_ascii_whitespace().skip(1);
            if line.ends_with('\\') {
                return Err(bytes.error(
                    "a line that goes on in the next; write each vertex and face on one line",
                ));
            }
            match kind {
                b"v" => {
                    let mut place_m = [0.0; 3];
                    for (value, name) in place_m.iter_mut().zip(["x", "y", "z"]) {
                        let word = words.next().unwrap_or("");
                        *value = bytes.metres_of(word, unit_m, name)?;
                    }
                    faces.points_m.push(place_m);
                }
                _ => {
                    let mut corners = Vec::new();
                    for word in words.take_while(|word| !word.starts_with('#')) {
                        corners.push(corner(word, faces.points_m.len(), &bytes)?);
                    }
                    faces.polygon(&corners, &bytes)?;
                }
            }
        }
        Ok(faces)
    }
}

/// Returns the vertex of `vertex/texture/normal`: it counts from 1, or from the end if it is negative.
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
