//! Medit meshes, ASCII `.mesh` of versions 1 to 4.
//!
//! The reader takes vertices and tetrahedra; triangles and edges only for the groups. The groups are the
//! reference numbers: `N` of elements, `points:N` of vertices, 0 being none. Sections that the body does
//! not need are skipped. Layout: Frey, MEDIT: an interactive mesh visualization software (2001).

use std::path::Path;

use super::bytes::{Bytes, shown};
use super::format::{begins, first_line};
use super::groups::Groups;
use super::{MeshReader, RawMesh, has_extension};
use crate::error::Result;

/// Reader of `.mesh` files.
pub(super) struct Medit;

/// First word of every file.
const MAGIC: &str = "MeshVersionFormatted";
/// Sections of elements that are no first-order tetrahedra, with their names and the remedy.
const REFUSED: [(&str, &str); 8] = [
    ("hexahedra", "hexahedra; mesh it without recombination, or split them into tetrahedra"),
    ("hexaedra", "hexahedra; mesh it without recombination, or split them into tetrahedra"),
    ("prisms", "prisms; mesh it without recombination, or split them into tetrahedra"),
    ("wedges", "prisms; mesh it without recombination, or split them into tetrahedra"),
    ("pyramids", "pyramids; mesh it without recombination, or split them into tetrahedra"),
    ("tetrahedrap2", "10-node tetrahedra; save it with linear elements"),
    ("tetrahedrap3", "20-node tetrahedra; save it with linear elements"),
    ("trianglesp2", "6-node triangles; save it with linear elements"),
];

impl MeshReader for Medit {
    fn name(&self) -> &'static str {
        "Medit .mesh (ASCII)"
    }

    fn is_in(&self, head: &[u8]) -> bool {
        begins(first_line(head, b"#"), MAGIC.as_bytes()) || is_binary(head)
    }

    fn has_name(&self, path: &Path) -> bool {
        has_extension(path, "mesh") || has_extension(path, "meshb")
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
        let mut words = Words(Bytes::new(path, bytes, 0));
        if is_binary(bytes) {
            return Err(words.0.error_of_file(
                "a binary Medit file (.meshb); text is read: meshio convert IN.meshb OUT.mesh",
            ));
        }
        words.0.lines = true;
        words.0.enter("its header");
        let magic = words.next("MeshVersionFormatted")?;
        if !magic.eq_ignore_ascii_case(MAGIC) {
            return Err(words.0.error(format!(
                "'{}' where {MAGIC} should be; this is no Medit file: save the mesh again",
                shown(magic)
            )));
        }
        match words.whole("the version")? {
            1..=4 => {}
            version => {
                return Err(words.0.error(format!(
                    "version {version}; 1 to 4 are read: save the mesh in one of these"
                )));
            }
        }
        Content::new(unit_m).read(words)
    }
}

/// Returns true if a file is of the binary form, which begins with the number 1 in either byte order.
fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(&[1, 0, 0, 0]) || bytes.starts_with(&[0, 0, 0, 1])
}

/// Words of the file without comments.
struct Words<'a>(Bytes<'a>);

impl<'a> Words<'a> {
    fn any(&mut self) -> Option<&'a str> {
        loop {
            let word = self.0.word()?;
            let Some(comment) = word.find('#') else { return Some(word) };
            self.0.line();
            if comment > 0 {
                return word.get(..comment);
            }
        }
    }

    fn next(&mut self, what: &str) -> Result<&'a str> {
        self.any().ok_or_else(|| self.0.truncated(what))
    }

    fn whole(&mut self, what: &str) -> Result<u64> {
        let word = self.next(what)?;
        self.0.whole_of(word, what)
    }

    /// Reads the number of items that follow, and checks that the file is long enough for them.
    fn count(&mut self, columns: u64, what: &str) -> Result<u64> {
        let count = self.whole(&format!("the number of {what}"))?;
        // A column has at least a digit and a separator.
        self.0.fits(count, 2 * columns - 1, what)?;
        Ok(count)
    }

    fn reference(&mut self) -> Result<i64> {
        let word = self.next("a reference number")?;
        self.0.signed_of(word, "the reference number")
    }
}

/// Content read so far.
struct Content {
    unit_m: f64,
    nodes_m: Vec<[f64; 3]>,
    tetrahedra: Vec<[u32; 4]>,
    groups: Groups,
    others: u64,
}

impl Content {
    fn new(unit_m: f64) -> Self {
        let (nodes_m, tetrahedra, groups) = (Vec::new(), Vec::new(), Groups::default());
        Self { unit_m, nodes_m, tetrahedra, groups, others: 0 }
    }

    fn read(mut self, mut words: Words) -> Result<RawMesh> {
        let (mut unknown, mut dimension) = (false, 0);
        while let Some(word) = words.any() {
            let section = word.to_ascii_lowercase();
            let known = !unknown;
            unknown = false;
            match section.as_str() {
                "dimension" => dimension = words.whole("the dimension")?,
                "vertices" if dimension == 3 => self.vertices(&mut words)?,
                "vertices" => {
                    return Err(words.0.error(format!(
                        "vertices of dimension {dimension}; a volume mesh is needed, with the line \
                         'Dimension 3' in front"
                    )));
                }
                "tetrahedra" => self.tetrahedra(&mut words)?,
                "triangles" => self.elements::<3>(&mut words, "triangles")?,
                "edges" => self.elements::<2>(&mut words, "edges")?,
                "end" => break,
                _ if word.starts_with(|first: char| first.is_ascii_alphabetic()) => {
                    refuse(&mut words, &section)?;
                    unknown = true;
                }
                // Numbers of an unknown section are skipped.
                _ if !known => unknown = true,
                _ => {
                    return Err(words.0.error(format!(
                        "'{}' where a section should begin: the one before has more numbers than it \
                         says; save or copy the mesh again",
                        shown(word)
                    )));
                }
            }
        }
        self.finish(&words.0)
    }

    fn vertices(&mut self, words: &mut Words) -> Result<()> {
        words.0.enter("section Vertices");
        if !self.nodes_m.is_empty() {
            return Err(words.0.error("a second section Vertices; save the mesh as one"));
        }
        for node in 0..words.count(4, "vertices")? {
            let mut position = [0.0; 3];
            for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
                let word = words.next(name)?;
                *value = words.0.metres_of(word, self.unit_m, name)?;
            }
            self.nodes_m.push(position);
            self.groups.of_point(words.reference()?, node as u32);
        }
        Ok(())
    }

    fn tetrahedra(&mut self, words: &mut Words) -> Result<()> {
        words.0.enter("section Tetrahedra");
        for _ in 0..words.count(5, "tetrahedra")? {
            let ids = self.corners::<4>(words)?;
            if (1..4).any(|corner| ids[..corner].contains(&ids[corner])) {
                return Err(words
                    .0
                    .error("a tetrahedron that has a vertex twice; delete it or mesh again"));
            }
            self.tetrahedra.push(ids);
            self.groups.of_element(words.reference()?, ids);
        }
        Ok(())
    }

    /// Reads elements that only the groups need.
    fn elements<const N: usize>(&mut self, words: &mut Words, what: &str) -> Result<()> {
        words.0.enter("a section of elements");
        for _ in 0..words.count(N as u64 + 1, what)? {
            let ids = self.corners::<N>(words)?;
            self.groups.of_element(words.reference()?, ids);
            self.others += 1;
        }
        Ok(())
    }

    /// Reads the positions of vertices, which the file counts from 1.
    fn corners<const N: usize>(&self, words: &mut Words) -> Result<[u32; N]> {
        let mut ids = [0; N];
        for id in &mut ids {
            let number = words.whole("the number of a vertex")?;
            *id = match number.checked_sub(1) {
                Some(place) if place < self.nodes_m.len() as u64 => place as u32,
                _ => {
                    return Err(words.0.error(format!(
                        "vertex {number}; the vertices in front are 1 to {}: save the mesh again",
                        self.nodes_m.len()
                    )));
                }
            };
        }
        Ok(ids)
    }

    fn finish(self, bytes: &Bytes) -> Result<RawMesh> {
        if self.nodes_m.is_empty() {
            return Err(bytes.error_of_file("it has no Vertices; save the mesh with its nodes"));
        }
        if self.tetrahedra.is_empty() {
            return Err(bytes.error_of_file(format!(
                "it has {} triangles and edges but no Tetrahedra; a volume mesh is needed: mesh the \
                 volume inside and save all elements",
                self.others
            )));
        }
        let groups = self.groups.finish();
        Ok(RawMesh { nodes_m: self.nodes_m, tetrahedra: self.tetrahedra, groups })
    }
}

/// Refuses a section of elements that are not read, unless it is empty.
fn refuse(words: &mut Words, section: &str) -> Result<()> {
    let Some((_, what)) = REFUSED.iter().find(|(name, _)| *name == section) else {
        return Ok(());
    };
    match words.whole("a number of elements")? {
        0 => Ok(()),
        count => Err(words.0.error(format!("{count} elements are {what}"))),
    }
}
