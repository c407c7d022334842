//! STL surfaces, ASCII and binary; the normals of the file are not looked at.

use std::path::Path;

use super::{Faces, SurfaceReader};
use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};

/// Reader of `.stl` files.
pub(super) struct Stl;

/// Bytes of the head of a binary file, which the number of triangles follows.
const HEAD: usize = 80;
/// Bytes of a triangle: a normal, three corners, two bytes that mean nothing.
const TRIANGLE: u64 = 50;

impl SurfaceReader for Stl {
    fn name(&self) -> &'static str {
        "STL .stl"
    }

    fn extension(&self) -> &'static str {
        "stl"
    }

    fn is_in(&self, bytes: &[u8]) -> bool {
        bytes.starts_with(b"solid ") || is_binary(bytes)
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<Faces> {
        let front = bytes.trim_ascii_start();
        // Some binary files begin with "solid" too.
        if is_binary(bytes) {
            binary(Bytes::new(path, bytes, HEAD), unit_m)
        } else if front.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
            text(Bytes::new(path, bytes, 0), unit_m)
        } else if std::str::from_utf8(bytes).is_ok_and(|text| !text.contains('\0')) {
            Err(Bytes::new(path, bytes, 0).error_of_file(
                "a text that does not begin with 'solid', so no STL file; where it is another surface, \
                 name it .obj or .ply",
            ))
        } else {
            binary(Bytes::new(path, bytes, HEAD), unit_m)
        }
    }
}

/// Whether it is as long as its number of triangles says.
fn is_binary(bytes: &[u8]) -> bool {
    let count =
        bytes.get(HEAD..).and_then(|rest| rest.first_chunk()).map(|n| u32::from_le_bytes(*n));
    let length = count.map(|count| HEAD as u64 + 4 + TRIANGLE * u64::from(count));
    length == Some(bytes.len() as u64)
}

fn binary(mut bytes: Bytes, unit_m: f64) -> Result<Faces> {
    bytes.enter("the head");
    let count = u32::from_le_bytes(bytes.take("the number of triangles")?);
    bytes.enter("the triangles");
    bytes.fits(count.into(), TRIANGLE, "triangles")?;
    let mut faces = Faces::default();
    for _ in 0..count {
        bytes.skip(12);
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            for (value, name) in corner.iter_mut().zip(["x", "y", "z"]) {
                let coordinate = f64::from(bytes.f32(name)?);
                *value = bytes.metres(coordinate, unit_m, name)?;
            }
        }
        bytes.skip(2);
        faces.triangle(corners);
    }
    if bytes.rest().is_empty() {
        return Ok(faces);
    }
    Err(bytes.error(format!(
        "{} bytes behind the last of {count} triangles; the count is wrong: save or copy it again",
        bytes.rest().len()
    )))
}

fn text(mut bytes: Bytes, unit_m: f64) -> Result<Faces> {
    bytes.lines = true;
    bytes.enter("the triangles");
    let (mut faces, mut open) = (Faces::default(), false);
    while let Some(word) = bytes.word() {
        match (word.to_ascii_lowercase().as_str(), open) {
            ("solid", false) => {
                open = true;
                name(&mut bytes);
            }
            ("endsolid", true) => {
                open = false;
                name(&mut bytes);
            }
            ("facet", true) => {
                keyword(&mut bytes, "normal")?;
                for _ in 0..3 {
                    next(&mut bytes, "a normal")?;
                }
                keyword(&mut bytes, "outer")?;
                keyword(&mut bytes, "loop")?;
                let mut corners = [[0.0; 3]; 3];
                for corner in &mut corners {
                    keyword(&mut bytes, "vertex")?;
                    for (value, name) in corner.iter_mut().zip(["x", "y", "z"]) {
                        let word = next(&mut bytes, name)?;
                        *value = bytes.metres_of(word, unit_m, name)?;
                    }
                }
                faces.triangle(corners);
                keyword(&mut bytes, "endloop")?;
                keyword(&mut bytes, "endfacet")?;
            }
            _ => {
                return Err(bytes.error(format!(
                    "'{}' where {} should be; save or copy it again",
                    shown(word),
                    if open { "facet or endsolid" } else { "solid" }
                )));
            }
        }
    }
    if open { Err(bytes.truncated("endsolid")) } else { Ok(faces) }
}

/// Passes over the name of a solid, which may be left out.
fn name(bytes: &mut Bytes) {
    if !bytes.rest().starts_with(b"\n") {
        bytes.line();
    }
}

fn next<'a>(bytes: &mut Bytes<'a>, what: &str) -> Result<&'a str> {
    bytes.word().ok_or_else(|| bytes.truncated(what))
}

fn keyword(bytes: &mut Bytes, wanted: &str) -> Result<()> {
    let word = next(bytes, wanted)?;
    if word.eq_ignore_ascii_case(wanted) {
        return Ok(());
    }
    Err(bytes.error(format!("'{}' where {wanted} should be; save or copy it again", shown(word))))
}
