//! PLY surfaces, ASCII and binary of either byte order: vertices and faces; other elements and
//! properties are skipped.

use std::path::Path;

use super::{Faces, SurfaceReader};
use crate::error::Result;
use crate::mesh::bytes::{Bytes, first_line, shown};
use crate::mesh::number::Number;

/// Reader of `.ply` files.
pub(super) struct Ply;

impl SurfaceReader for Ply {
    fn name(&self) -> &'static str {
        "PLY .ply"
    }

    fn extension(&self) -> &'static str {
        "ply"
    }

    fn is_in(&self, bytes: &[u8]) -> bool {
        first_line(bytes).0.trim_ascii_end() == b"ply"
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<Faces> {
        let mut bytes = Bytes::new(path, bytes, 0);
        bytes.lines = true;
        let (elements, text) = head(&mut bytes)?;
        bytes.lines = text;
        let mut faces = Faces::default();
        for element in &elements {
            bytes.enter(if element.name == "vertex" { "the vertices" } else { "the faces" });
            let least = element.properties.iter().map(|property| property.least_bytes(text));
            bytes.fits(element.count, least.sum::<u64>().max(1), "rows")?;
            for _ in 0..element.count {
                row(&mut bytes, element, text, unit_m, &mut faces)?;
            }
        }
        Ok(faces)
    }
}

/// A kind of rows.
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    number: Number,
    /// Type of the length of a list.
    length: Option<Number>,
}

impl Property {
    fn least_bytes(&self, text: bool) -> u64 {
        match (text, self.length) {
            (true, _) => 2,
            (false, Some(length)) => length.size(),
            (false, None) => self.number.size(),
        }
    }
}

/// Returns the type with this name.
fn number_type(name: &str) -> Option<Number> {
    Some(match name {
        "char" | "int8" => Number::I8,
        "uchar" | "uint8" => Number::U8,
        "short" | "int16" => Number::I16,
        "ushort" | "uint16" => Number::U16,
        "int" | "int32" => Number::I32,
        "uint" | "uint32" => Number::U32,
        "int64" => Number::I64,
        "uint64" => Number::U64,
        "float" | "float32" => Number::F32,
        "double" | "float64" => Number::F64,
        _ => return None,
    })
}

/// Reads the next number of a type.
fn real(number: Number, bytes: &mut Bytes, text: bool, what: &str) -> Result<f64> {
    if text {
        let word = bytes.word().ok_or_else(|| bytes.truncated(what))?;
        return bytes.real_of(word, what);
    }
    number.real(bytes, what)
}

/// Reads a whole number from 0 that fits 32 bits.
fn whole(number: Number, bytes: &mut Bytes, text: bool, what: &str) -> Result<u32> {
    let value = real(number, bytes, text, what)?;
    let is_whole = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    is_whole
        .then_some(value as u32)
        .ok_or_else(|| bytes.no_number(what, &value.to_string(), "a whole number from 0"))
}

/// Reads the head: returns the elements in their order, and true if the rows are text.
fn head(bytes: &mut Bytes) -> Result<(Vec<Element>, bool)> {
    bytes.enter("its head");
    let (mut elements, mut text, mut first) = (Vec::<Element>::new(), None, true);
    loop {
        let Some(line) = bytes.text_line("comment")? else {
            return Err(bytes.truncated("end_header"));
        };
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match (words.as_slice(), std::mem::take(&mut first)) {
            (["ply"], true) => {}
            (_, true) => {
                return Err(
                    bytes.error("its first line is not 'ply'; this is no PLY file: save it again")
                );
            }
            (["format", coding, "1.0"], _) => {
                bytes.little = *coding != "binary_big_endian";
                text = match *coding {
                    "ascii" => Some(true),
                    "binary_little_endian" | "binary_big_endian" => Some(false),
                    _ => return Err(unknown(bytes, line)),
                };
            }
            (["element", name, count], _) => elements.push(Element {
                name: (*name).into(),
                count: bytes.whole_of(count, "the number of rows")?,
                properties: Vec::new(),
            }),
            (["property", "list", length, number, name], _) => {
                let (length, number) = number_type(length)
                    .zip(number_type(number))
                    .ok_or_else(|| unknown(bytes, line))?;
                let Some(element) = elements.last_mut() else { return Err(unknown(bytes, line)) };
                element.properties.push(Property {
                    name: (*name).into(),
                    number,
                    length: Some(length),
                });
            }
            (["property", number, name], _) => {
                let number = number_type(number).ok_or_else(|| unknown(bytes, line))?;
                let Some(element) = elements.last_mut() else { return Err(unknown(bytes, line)) };
                element.properties.push(Property { name: (*name).into(), number, length: None });
            }
            (["obj_info", ..], _) => {}
            (["end_header"], _) => break,
            _ => return Err(unknown(bytes, line)),
        }
    }
    // The format must be known, and the faces must be no strips.
    let text = text.ok_or_else(|| bytes.error("there is no format in the head; save it again"))?;
    if elements.iter().any(|element| element.name == "tristrips" && element.count > 0) {
        return Err(bytes.error("strips of triangles; save it with faces"));
    }
    Ok((elements, text))
}

fn unknown(bytes: &Bytes, line: &str) -> crate::error::Error {
    bytes.error(format!(
        "'{}' in the head; read are format, element and property: save it again",
        shown(line)
    ))
}

/// Reads one row of an element.
fn row(
    bytes: &mut Bytes,
    element: &Element,
    text: bool,
    unit_m: f64,
    faces: &mut Faces,
) -> Result<()> {
    let mut place_m = [None; 3];
    for property in &element.properties {
        let Some(length) = property.length else {
            let axis = ["x", "y", "z"].iter().position(|axis| *axis == property.name);
            let value = real(property.number, bytes, text, &property.name)?;
            if let Some(axis) = axis.filter(|_| element.name == "vertex") {
                place_m[axis] = Some(bytes.metres(value, unit_m, &property.name)?);
            }
            continue;
        };
        // A list: the corners of a face, or one that is skipped.
        let count = whole(length, bytes, text, "the length of a list")?;
        let each = if text { 1 } else { property.number.size() };
        bytes.fits(count.into(), each, "numbers of a list")?;
        let is_face = element.name == "face"
            && matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
        let mut corners = Vec::new();
        for _ in 0..count {
            if is_face {
                let corner = whole(property.number, bytes, text, "a vertex of a face")?;
                if corner as usize >= faces.points_m.len() {
                    return Err(bytes.error(format!(
                        "vertex {corner} of a face; the vertices in front are 0 to {}: save it again",
                        faces.points_m.len().saturating_sub(1)
                    )));
                }
                corners.push(corner);
            } else {
                real(property.number, bytes, text, "a number of a list")?;
            }
        }
        if is_face {
            faces.polygon(&corners, bytes)?;
        }
    }
    if element.name == "vertex" {
        match place_m {
            [Some(x), Some(y), Some(z)] => faces.points_m.push([x, y, z]),
            _ => return Err(bytes.error("vertices without x, y or z; save it with coordinates")),
        }
    }
    Ok(())
}
