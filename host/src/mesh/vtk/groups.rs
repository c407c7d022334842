//! Groups of nodes from what is attached to the cells: whole numbers of a known name, one a cell.

use std::collections::BTreeMap;

use super::cells::Cells;
use super::values::{Number, Values};
use crate::error::Result;
use crate::mesh::groups::Groups;

/// Names that programs give the numbers of physical groups, materials and regions: Gmsh's own export,
/// meshio's from Gmsh and from Medit, and what others write.
const NAMES: [&str; 8] = [
    "CellEntityIds",
    "gmsh:physical",
    "medit:ref",
    "PhysicalIds",
    "MaterialIds",
    "material",
    "region",
    "group",
];

/// Reads what is attached behind the mesh, begun by the word `begun`, up to the first array of such a
/// name; groups are named by their numbers, 0 is none. Anything else is passed over, and what cannot
/// be passed over ends it.
pub(super) fn read(
    values: &mut Values,
    cells: &Cells,
    begun: &str,
) -> Result<BTreeMap<String, Vec<u32>>> {
    let Some(number) = find(values, cells.count(), begun) else { return Ok(BTreeMap::new()) };
    values.bytes.enter("the groups of the cells");
    values.begin_data(cells.count(), 1, number, "groups of the cells")?;
    let mut groups = Groups::default();
    for cell in 0..cells.count() {
        groups.of_cell(cells, cell as usize, values.whole(number, "the group of a cell")?);
    }
    Ok(groups.finish())
}

impl Groups {
    /// Adds a cell's nodes to the group of a number, unless that is 0.
    pub(super) fn of_cell(&mut self, cells: &Cells, cell: usize, number: u64) {
        if number > 0 {
            self.add(number, cells.nodes_of(cell));
        }
    }
}

/// Goes to the first array of groups; the type of its numbers.
fn find(values: &mut Values, cells: u64, begun: &str) -> Option<Number> {
    let (mut next, mut of_cells, mut tuples) = (Some(begun), false, 0);
    while let Some(word) = next {
        match word.to_ascii_uppercase().as_str() {
            kind @ ("POINT_DATA" | "CELL_DATA") => {
                of_cells = kind == "CELL_DATA";
                tuples = values.count("a number of values").ok()?;
                if of_cells && tuples != cells {
                    return None;
                }
            }
            "SCALARS" => {
                let name = values.text("a name").ok()?;
                let kind = values.text("a type").ok()?;
                let number = Number::named(kind)?;
                let word = values.text("LOOKUP_TABLE").ok()?;
                let components = word.parse().ok();
                if components.is_some() {
                    values.keyword("LOOKUP_TABLE").ok()?;
                }
                values.text("the name of the table").ok()?;
                let components = components.unwrap_or(1);
                if of_cells && is_group(name, number, components) {
                    return Some(number);
                }
                values.skip_array(tuples, components, number).ok()?;
            }
            "FIELD" => {
                values.text("the field's name").ok()?;
                let mut left = values.count("the number of arrays").ok()?;
                while left > 0 {
                    let name = values.text("an array's name").ok()?;
                    if name.eq_ignore_ascii_case("METADATA") {
                        values.skip_metadata();
                        continue;
                    }
                    let components = values.count("the number of components").ok()?;
                    let tuples = values.count("the number of tuples").ok()?;
                    let number = Number::named(values.text("the array's type").ok()?)?;
                    if of_cells && tuples == cells && is_group(name, number, components) {
                        return Some(number);
                    }
                    values.skip_array(tuples, components, number).ok()?;
                    left -= 1;
                }
            }
            "METADATA" => values.skip_metadata(),
            _ => return None,
        }
        next = values.bytes.word();
    }
    None
}

fn is_group(name: &str, number: Number, components: u64) -> bool {
    is_known(name) && components == 1 && matches!(number, Number::I32 | Number::I64)
}

/// Whether an array of whole numbers of this name holds groups.
pub(super) fn is_known(name: &str) -> bool {
    NAMES.iter().any(|known| known.eq_ignore_ascii_case(name))
}
