//! Detects the format of a file by its content, else by its name.

use std::path::Path;

use super::solid::{self, SurfaceReader};
use super::{MeshReader, READERS};
use crate::error::{Error, Result};

/// Bytes of a file that are examined.
const HEAD: usize = 64 << 10;

/// Reader of a file.
pub(super) enum Format {
    Volume(&'static dyn MeshReader),
    Surface(&'static dyn SurfaceReader),
}

/// Formats that are not read: the first bytes of their files, the name, and the remedy. Letters match in
/// either case.
const OTHERS: [(&[u8], &str, &str); 20] = [
    (b"\xff\xfe", "text in UTF-16", UTF_8),
    (b"\xfe\xff", "text in UTF-16", UTF_8),
    (b"BZh91AY&SY", "compressed by bzip2", "unpack it first with bunzip2"),
    (b"\xfd7zXZ", "compressed by xz", "unpack it first with unxz"),
    (b"\x28\xb5\x2f\xfd", "compressed by zstd", "unpack it first with unzstd"),
    (b"PK\x03\x04", "a ZIP archive", "unpack it first; of a .3mf save the surface as .stl"),
    (b"\x89HDF", "an HDF5 file (.med, .cgns, .h5)", CONVERT),
    (b"CDF", "a NetCDF file (Exodus)", CONVERT),
    (b"glTF", "a glTF scene", SURFACE),
    (b"OFF", "an OFF surface", SURFACE),
    (b"COFF", "an OFF surface", SURFACE),
    (b"NOFF", "an OFF surface", SURFACE),
    (b"-1\n", "an I-DEAS universal file (.unv)", GMSH),
    (b"-1\r", "an I-DEAS universal file (.unv)", GMSH),
    (b"mesh3d", "a Netgen mesh (.vol)", CONVERT),
    (b"(", "a Fluent mesh", CONVERT),
    (b"*KEYWORD", "an LS-DYNA keyword file", "save the mesh as Abaqus .inp or Gmsh .msh"),
    (b"$", "a Nastran or LS-DYNA file", "save the mesh as Abaqus .inp or Gmsh .msh"),
    (b"TITLE", "a Tecplot file", CONVERT),
    (b"\x07", "a binary UCD file", "save it as text"),
];
const UTF_8: &str = "save it as UTF-8";
const SURFACE: &str = "save it as .stl, .ply or .obj";
const CONVERT: &str = "convert it with meshio convert IN OUT.vtu";
const GMSH: &str = "convert it with gmsh -save -format msh41 -o OUT.msh IN.unv";

/// Returns the format of a file; none if it is unknown.
///
/// # Errors
/// A format that is not read, with the remedy.
pub(super) fn of(path: &Path, bytes: &[u8]) -> Result<Option<Format>> {
    let head = &bytes[..bytes.len().min(HEAD)];
    let volume = |reader: &&'static dyn MeshReader| Format::Volume(*reader);
    if let Some(reader) = READERS.iter().find(|reader| reader.is_in(head)) {
        return Ok(Some(volume(reader)));
    }
    if let Some(reader) = solid::by_content(bytes) {
        return Ok(Some(Format::Surface(reader)));
    }
    let front = head.trim_ascii_start();
    let line = first_line(head, b"#");
    let is_other = |sign: &[u8]| begins(front, sign) || begins(line, sign);
    if let Some((_, what, remedy)) = OTHERS.iter().find(|(sign, ..)| is_other(sign)) {
        return Err(Error::file("read mesh", path, format!("it is {what}: {remedy}")));
    }
    let by_name = READERS.iter().find(|reader| reader.has_name(path)).map(volume);
    Ok(by_name.or_else(|| solid::by_name(path).map(Format::Surface)))
}

/// Returns the first line that is neither blank nor begins with `comment`, trimmed.
pub(super) fn first_line<'a>(head: &'a [u8], comment: &[u8]) -> &'a [u8] {
    let lines = head.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let mut lines = lines.filter(|line| !line.is_empty() && !line.starts_with(comment));
    lines.next().unwrap_or_default()
}

/// Returns true if a file begins with this sign, in letters of either case; a sign that is a word must be
/// the whole word.
pub(super) fn begins(bytes: &[u8], sign: &[u8]) -> bool {
    let is_word = sign.last().is_some_and(u8::is_ascii_alphanumeric);
    let goes_on = bytes.get(sign.len()).is_some_and(u8::is_ascii_alphanumeric);
    bytes.get(..sign.len()).is_some_and(|front| front.eq_ignore_ascii_case(sign))
        && !(is_word && goes_on)
}
