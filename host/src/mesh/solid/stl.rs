//! STL surfaces, ASCII and binary; the normals of the file are ignored.

use std::path::Path;

use super::{Faces, SurfaceReader};
use crate::error::{Error, Result};
use crate::mesh::bytes::{Bytes, shown};
use crate::mesh::format::begins;

/// Reader of `.stl` files.
pub(super) struct Stl;

/// Bytes of the head of a binary file, which the number of triangles follows.
const HEAD: usize = 80;
/// First bytes of a file, which are checked for zeros: text has none.
const FRONT: usize = 1000;
/// Bytes of a triangle: a normal, three corners, two unused bytes.
const TRIANGLE: u64 = 50;

impl SurfaceReader for Stl {
    fn name(&self) -> &'static str {
        "STL .stl"
    }

    fn extension(&self) -> &'static str {
        "stl"
    }

    fn is_in(&self, bytes: &[u8]) -> bool {
        begins(bytes.trim_ascii_start(), b"solid") || is_binary(bytes)
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<Faces> {
        // Some binary files begin with "solid" too.
        let front = bytes.get(..FRONT).unwrap_or(bytes);
        if is_binary(bytes) {
            binary(Bytes::new(path, bytes, HEAD), unit_m)
        } else if begins(front.trim_ascii_start(), b"solid") && !front.contains(&0) {
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

/// Returns true if its length matches its number of triangles.
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
        if !open && word.eq_ignore_ascii_case("solid") {
            open = true;
            bytes.rest_of_line();
        } else if open && word.eq_ignore_ascii_case("facet") {
            facet(&mut bytes, unit_m, &mut faces)?;
        } else if open && is_end(word, "solid", &mut bytes) {
            open = false;
            bytes.rest_of_line();
        } else {
            return Err(bytes.error(format!(
                "'{}' where {} should be; save or copy it again",
                shown(word),
                if open { "facet or endsolid" } else { "solid" }
            )));
        }
    }
    if open { Err(bytes.truncated("endsolid")) } else { Ok(faces) }
}

/// Reads the words after facet: a normal, which may be missing, a loop of three corners or more, and the
/// ends of both.
fn facet(bytes: &mut Bytes, unit_m: f64, faces: &mut Faces) -> Result<()> {
    let mut word = next(bytes, "outer")?;
    if word.eq_ignore_ascii_case("normal") {
        for _ in 0..=3 {
            word = next(bytes, "outer")?;
            if word.eq_ignore_ascii_case("outer") {
                break;
            }
        }
    }
    expect(word, "outer", bytes)?;
    let word = next(bytes, "loop")?;
    expect(word, "loop", bytes)?;
    let first = faces.points_m.len();
    for number in 0.. {
        let word = next(bytes, "vertex")?;
        if number >= 3 && is_end(word, "loop", bytes) {
            break;
        }
        expect(word, if number < 3 { "vertex" } else { "endloop" }, bytes)?;
        let mut corner = [0.0; 3];
        for (value, name) in corner.iter_mut().zip(["x", "y", "z"]) {
            let word = next(bytes, name)?;
            *value = bytes.metres_of(word, unit_m, name)?;
        }
        faces.points_m.push(corner);
    }
    let corners: Vec<u32> = (first as u32..faces.points_m.len() as u32).collect();
    faces.polygon(&corners, bytes)?;
    let word = next(bytes, "endfacet")?;
    if is_end(word, "facet", bytes) { Ok(()) } else { Err(unexpected(word, "endfacet", bytes)) }
}

/// Returns true if a word, or it and the next, end the block named `what`; the next is skipped then.
fn is_end(word: &str, what: &str, bytes: &mut Bytes) -> bool {
    let Some(rest) = word.get(3..).filter(|_| word[..3].eq_ignore_ascii_case("end")) else {
        return false;
    };
    if !rest.is_empty() {
        return rest.eq_ignore_ascii_case(what);
    }
    let next = bytes.peek();
    let is_end = next.is_some_and(|next| next.eq_ignore_ascii_case(what));
    if is_end {
        bytes.word();
    }
    is_end
}

fn next<'a>(bytes: &mut Bytes<'a>, what: &str) -> Result<&'a str> {
    bytes.word().ok_or_else(|| bytes.truncated(what))
}

fn expect(word: &str, wanted: &str, bytes: &Bytes) -> Result<()> {
    if word.eq_ignore_ascii_case(wanted) { Ok(()) } else { Err(unexpected(word, wanted, bytes)) }
}

fn unexpected(word: &str, wanted: &str, bytes: &Bytes) -> Error {
    bytes.error(format!("'{}' where {wanted} should be; save or copy it again", shown(word)))
}
