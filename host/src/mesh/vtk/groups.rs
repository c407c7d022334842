//! Groups of nodes from the cells' data: arrays of a known name with one whole number a cell.

use std::collections::BTreeMap;

use super::cells::Cells;
use super::values::{Values, number_type};
use crate::error::Result;
use crate::mesh::groups::Groups;
use crate::mesh::number::Number;

/// Array names of physical groups, materials and regions: Gmsh's export, meshio's from Gmsh, Medit and
/// TetGen, and those of other programs.
const NAMES: [&str; 9] = [
    OF_GMSH,
    "gmsh:physical",
    "medit:ref",
    "tetgen:ref",
    "PhysicalIds",
    "MaterialIds",
    "material",
    "region",
    "group",
];
/// Gmsh gives -1 to cells without a group.
const OF_GMSH: &str = "CellEntityIds";

/// Components of the arrays that have a separate section.
const TUPLES: [(&str, u64); 5] =
    [("VECTORS", 3), ("NORMALS", 3), ("TENSORS", 9), ("GLOBAL_IDS", 1), ("PEDIGREE_IDS", 1)];
/// Bytes of a colour in a table.
const COLOUR: u64 = 4;

/// Reads the data after the mesh, which begins with the word `begun`, up to the first array of such a
/// name with only whole numbers; groups are named by their numbers, 0 is none. Other data is skipped;
/// data that cannot be skipped ends the search.
pub(super) fn read<'a>(
    values: &mut Values<'a>,
    cells: &Cells,
    begun: &'a str,
) -> Result<BTreeMap<String, Vec<u32>>> {
    let mut attached = Attached { cells: cells.count(), of_cells: false, tuples: 0, left: 0 };
    let mut begun = Some(begun);
    while let Some((name, number)) = attached.next(values, begun.take()) {
        values.bytes.enter("the groups of the cells");
        values.begin_data(cells.count(), 1, number, "groups of the cells")?;
        // Read it to its end even if it holds no groups: the next array follows.
        let mut numbers = Some(Vec::new());
        for _ in 0..cells.count() {
            let number = values.reference(number, "the group of a cell")?;
            numbers = numbers.zip(number).map(|(mut all, number)| {
                all.push(number);
                all
            });
        }
        if let Some(numbers) = numbers {
            return Ok(named(cells, name, &numbers));
        }
    }
    Ok(BTreeMap::new())
}

/// Returns the groups of an array of this name with one number a cell.
pub(super) fn named(cells: &Cells, name: &str, numbers: &[i64]) -> BTreeMap<String, Vec<u32>> {
    let mut groups = Groups::default();
    let is_of_gmsh = name.eq_ignore_ascii_case(OF_GMSH);
    for (cell, &number) in numbers.iter().enumerate() {
        if !(is_of_gmsh && number == -1) {
            groups.of_element(number, cells.nodes_of(cell));
        }
    }
    groups.finish()
}

/// State of reading the data after the mesh.
struct Attached {
    cells: u64,
    of_cells: bool,
    tuples: u64,
    /// Arrays of a field that are not read yet.
    left: u64,
}

impl Attached {
    /// Goes to the next array of groups, from the word `begun` if it was read already; returns its name
    /// and the type of its numbers.
    fn next<'a>(
        &mut self,
        values: &mut Values<'a>,
        begun: Option<&'a str>,
    ) -> Option<(&'a str, Number)> {
        let mut begun = begun;
        loop {
            let found = if self.left > 0 {
                self.array(values)?
            } else {
                let word = begun.take().or_else(|| values.bytes.word())?;
                self.section(values, word)?
            };
            if found.is_some() {
                return found;
            }
        }
    }

    /// Reads the head of a section, and skips it unless it holds groups. None if it is unknown or invalid.
    fn section<'a>(
        &mut self,
        values: &mut Values<'a>,
        word: &str,
    ) -> Option<Option<(&'a str, Number)>> {
        let word = word.to_ascii_uppercase();
        match word.as_str() {
            "POINT_DATA" | "CELL_DATA" => {
                self.of_cells = word == "CELL_DATA";
                self.tuples = values.count("a number of values").ok()?;
                if self.of_cells && self.tuples != self.cells {
                    return None;
                }
            }
            "SCALARS" => return self.scalars(values),
            "LOOKUP_TABLE" => {
                values.text("the name of the table").ok()?;
                let colours = values.count("a number of colours").ok()?;
                values.skip_array(colours, COLOUR, Number::U8).ok()?;
            }
            "FIELD" => {
                values.text("the field's name").ok()?;
                self.left = values.count("the number of arrays").ok()?;
            }
            "METADATA" => values.skip_metadata(),
            _ => {
                let (_, components) = TUPLES.iter().find(|(name, _)| *name == word)?;
                values.text("a name").ok()?;
                let number = number_type(values.text("a type").ok()?)?;
                values.skip_array(self.tuples, *components, number).ok()?;
            }
        }
        Some(None)
    }

    /// `SCALARS name type components`, `LOOKUP_TABLE name`, then the numbers.
    fn scalars<'a>(&mut self, values: &mut Values<'a>) -> Option<Option<(&'a str, Number)>> {
        let name = values.text("a name").ok()?;
        let number = number_type(values.text("a type").ok()?)?;
        let word = values.text("LOOKUP_TABLE").ok()?;
        let components = word.parse().ok();
        if components.is_some() {
            values.keyword("LOOKUP_TABLE").ok()?;
        }
        values.text("the name of the table").ok()?;
        let components = components.unwrap_or(1);
        if self.of_cells && components == 1 && is_known(name) {
            return Some(Some((name, number)));
        }
        values.skip_array(self.tuples, components, number).ok()?;
        Some(None)
    }

    /// Reads an array of a field, or the remarks after one.
    fn array<'a>(&mut self, values: &mut Values<'a>) -> Option<Option<(&'a str, Number)>> {
        let Some(array) = values.array_of_field().ok()? else { return Some(None) };
        self.left -= 1;
        let is_one_a_cell = self.of_cells && array.tuples == self.cells && array.components == 1;
        if is_one_a_cell && is_known(array.name) {
            return Some(Some((array.name, array.number)));
        }
        values.skip_array(array.tuples, array.components, array.number).ok()?;
        Some(None)
    }
}

/// Returns true if an array of this name may hold groups.
pub(super) fn is_known(name: &str) -> bool {
    NAMES.iter().any(|known| known.eq_ignore_ascii_case(name))
}
