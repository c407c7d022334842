//! Reads and checks closed surfaces, and fills them with tetrahedra by the stuffing of the organ.
//!
//! A new format is one file with a `SurfaceReader` and one row in `READERS`.

mod closed;
mod creases;
mod distance;
mod fill;
mod grading;
mod meet;
mod near;
mod obj;
mod ply;
mod polygon;
mod shells;
mod stl;
pub(super) mod tree;

use std::path::Path;

use super::bytes::Bytes;
use super::has_extension;
use crate::error::{Error, Result};
use crate::words::counted;

pub use fill::Filled;
pub(super) use fill::fill_faces;

/// Most triangles of a surface.
const TRIANGLES_MAX: usize = 5_000_000;

/// Triangles as given in a file.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// `[point][axis]` in metres.
    points_m: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Faces {
    /// Makes them of a program's numbers, checked; errors call them `name`.
    pub(super) fn new(
        name: &str,
        points: &[[f64; 3]],
        triangles: Vec<[u32; 3]>,
        unit_m: f64,
    ) -> Result<Self> {
        let refuse = |why: String| Err(Error::input(format!("{name}: {why}")));
        let points_m: Vec<[f64; 3]> = points.iter().map(|at| at.map(|x| x * unit_m)).collect();
        let is_place = |place: &[f64; 3]| place.iter().all(|x| (*x as f32).is_finite());
        if let Some(point) = points_m.iter().position(|place| !is_place(place)) {
            return refuse(format!(
                "point {point} is at {:?}; every coordinate must be a finite number of metres",
                points_m[point]
            ));
        }
        for (at, corners) in triangles.iter().enumerate() {
            if let Some(id) = corners.iter().find(|id| **id as usize >= points.len()) {
                return refuse(format!(
                    "triangle {at} has point {id}, and there are {}: ids count from 0",
                    counted(points.len(), "point")
                ));
            }
        }
        let faces = Self { points_m, triangles };
        faces.check_count(name)?;
        Ok(faces)
    }

    /// Refuses no triangles, and too many.
    fn check_count(&self, name: &str) -> Result<()> {
        let refuse = |why: String| Err(Error::input(format!("{name}: {why}")));
        match self.triangles.len() {
            0 => refuse("it has no triangles; save the surface of the body".into()),
            count if count > TRIANGLES_MAX => refuse(format!(
                "{count} triangles, the limit is {TRIANGLES_MAX}; save a coarser surface"
            )),
            _ => Ok(()),
        }
    }

    /// Adds a triangle with three new points.
    fn triangle(&mut self, corners_m: [[f64; 3]; 3]) {
        let first = self.points_m.len() as u32;
        self.points_m.extend(corners_m);
        self.triangles.push([first, first + 1, first + 2]);
    }

    /// Adds a polygon, cut into triangles.
    fn polygon(&mut self, corners: &[u32], bytes: &Bytes) -> Result<()> {
        if let [a, b, c] = corners {
            self.triangles.push([*a, *b, *c]);
            return Ok(());
        }
        if corners.len() < 3 {
            return Err(bytes.error(format!(
                "a face of {} corners; it needs 3 or more: save it again",
                corners.len()
            )));
        }
        let at = corners.iter().map(|corner| self.points_m.get(*corner as usize).copied());
        let Some(at) = at.collect::<Option<Vec<_>>>() else {
            return Err(bytes.error("a face before its points; save the points first"));
        };
        let Some(triangles) = polygon::cut(corners, &at) else {
            return Err(bytes.error(format!(
                "a face of {} corners that is not flat and convex, the limit is {}; triangulate faces \
                 when you save it",
                corners.len(),
                polygon::CORNERS_MAX
            )));
        };
        self.triangles.extend(triangles);
        Ok(())
    }
}

/// One format of surfaces.
pub(super) trait SurfaceReader: Sync {
    /// The format in words, for error texts.
    fn name(&self) -> &'static str;
    /// Extension of its files' names.
    fn extension(&self) -> &'static str;
    /// Returns true if a file's bytes show that it is of the format.
    fn is_in(&self, bytes: &[u8]) -> bool;
    /// Reads the whole file; `unit_m` is metres per unit of its coordinates.
    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<Faces>;
}

/// The formats, tried in this order.
const READERS: &[&dyn SurfaceReader] = &[&stl::Stl, &ply::Ply, &obj::Obj];

/// The formats in words.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    READERS.iter().map(|reader| reader.name())
}

/// Returns the reader that recognizes a file's content.
pub(super) fn by_content(bytes: &[u8]) -> Option<&'static dyn SurfaceReader> {
    READERS.iter().find(|reader| reader.is_in(bytes)).copied()
}

/// Returns the reader for the extension of a path.
pub(super) fn by_name(path: &Path) -> Option<&'static dyn SurfaceReader> {
    READERS.iter().find(|reader| has_extension(path, reader.extension())).copied()
}

/// Reads the triangles of a surface file.
pub(super) fn read(
    reader: &dyn SurfaceReader,
    path: &Path,
    bytes: &[u8],
    unit_m: f64,
) -> Result<Faces> {
    let faces = reader.read(path, bytes, unit_m)?;
    faces.check_count(&path.display().to_string())?;
    Ok(faces)
}
