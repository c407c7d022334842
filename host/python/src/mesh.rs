//! Meshes in: arrays, objects like meshio's, and what the command reads.

use std::collections::BTreeMap;
use std::path::PathBuf;

use chaincell_host::mesh::{self, Mesh, MeshOptions, RawMesh};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::arrays;
use crate::errors::Class;

/// Cells of meshio that have a volume and are no first-order tetrahedra.
const OTHER_VOLUMES: [&str; 4] = ["hexahedron", "wedge", "pyramid", "tetra"];
/// Nodes of each named group.
type Groups = BTreeMap<String, Vec<u32>>;

/// The body of two arrays.
pub(crate) fn of_arrays(
    points: &Bound<'_, PyAny>,
    tets: &Bound<'_, PyAny>,
    options: &MeshOptions,
) -> PyResult<Mesh> {
    let nodes_m = arrays::reals("points", points)?.rows("points")?;
    let tetrahedra = arrays::ids("tets", tets)?.rows("tets")?;
    finish("arrays", nodes_m, tetrahedra, Groups::new(), options)
}

/// The body that a path, a generator or an object with points and cells stands for.
pub(crate) fn of_any(given: &Bound<'_, PyAny>, options: &MeshOptions) -> PyResult<Mesh> {
    if given.is_instance_of::<PyString>() || given.hasattr("__fspath__")? {
        let spec: PathBuf = given.extract()?;
        let spec = spec.to_str().ok_or_else(|| {
            Class::Model.error(format!("{}: a path must be UTF-8", spec.display()))
        })?;
        return mesh::load(spec, options).map_err(|why| Class::Model.host(why));
    }
    of_object(given, options)
}

fn finish(
    name: &str,
    mut nodes_m: Vec<[f64; 3]>,
    tetrahedra: Vec<[u32; 4]>,
    groups: Groups,
    options: &MeshOptions,
) -> PyResult<Mesh> {
    if !(options.unit_m.is_finite() && options.unit_m > 0.0) {
        let text = format!("`unit_m` {}: must be above 0 and finite [m]", options.unit_m);
        return Err(Class::Model.error(text));
    }
    if options.diagonals {
        return Err(Class::Model.error("`diagonals` is for a plane: leave it out"));
    }
    nodes_m.as_flattened_mut().iter_mut().for_each(|x| *x *= options.unit_m);
    let raw = RawMesh { nodes_m, tetrahedra, groups };
    mesh::from_raw(name, raw, options).map_err(|why| Class::Model.host(why))
}

/// Cells of one type in an object like meshio's.
struct Block<'py> {
    kind: String,
    data: Bound<'py, PyAny>,
}

fn of_object(given: &Bound<'_, PyAny>, options: &MeshOptions) -> PyResult<Mesh> {
    let points = given.getattr_opt("points")?.ok_or_else(|| no_mesh(given))?;
    let blocks = blocks(given)?;
    let nodes_m = arrays::reals("mesh.points", &points)?.rows("mesh.points")?;
    let mut tetrahedra = Vec::new();
    for Block { kind, data } in &blocks {
        if kind == "tetra" {
            tetrahedra.extend(arrays::ids("mesh.cells", data)?.rows::<4>("mesh.cells")?);
        } else if OTHER_VOLUMES.iter().any(|other| kind.starts_with(other)) {
            return Err(Class::Model.error(format!(
                "the mesh has cells of type {kind}: only first-order tetrahedra are read; mesh it \
                 without recombination, in first order"
            )));
        }
    }
    let mut groups = Groups::new();
    point_sets(given, &mut groups)?;
    cell_sets(given, &blocks, &mut groups)?;
    physical_groups(given, &blocks, &mut groups)?;
    for ids in groups.values_mut() {
        ids.sort_unstable();
        ids.dedup();
    }
    groups.retain(|_, ids| !ids.is_empty());
    finish("object", nodes_m, tetrahedra, groups, options)
}

fn no_mesh(given: &Bound<'_, PyAny>) -> PyErr {
    let found = given.get_type().name().map_or_else(|_| "this".into(), |name| name.to_string());
    PyTypeError::new_err(format!(
        "`mesh`: give a path, a generator as \"organ:1000\", or an object with points and cells as \
         meshio has them, not {found}"
    ))
}

/// The blocks of `cells`, or of `cells_dict`.
fn blocks<'py>(given: &Bound<'py, PyAny>) -> PyResult<Vec<Block<'py>>> {
    if let Some(cells) = given.getattr_opt("cells")?
        && !cells.is_instance_of::<PyDict>()
    {
        let blocks = cells.try_iter()?.map(|block| {
            let block = block?;
            let (kind, data) = match block.getattr_opt("type")? {
                Some(kind) => (kind, block.getattr("data")?),
                None => (block.get_item(0)?, block.get_item(1)?),
            };
            Ok(Block { kind: kind.extract()?, data })
        });
        return blocks.collect();
    }
    let cells = match given.getattr_opt("cells_dict")? {
        Some(cells) => cells,
        None => given.getattr_opt("cells")?.ok_or_else(|| no_mesh(given))?,
    };
    let cells = cells.cast_into::<PyDict>().map_err(|_| no_mesh(given))?;
    cells.iter().map(|(kind, data)| Ok(Block { kind: kind.extract()?, data })).collect()
}

/// A dictionary of the object, where it has one of this name.
fn dict<'py>(given: &Bound<'py, PyAny>, name: &str) -> PyResult<Option<Bound<'py, PyDict>>> {
    let found = given.getattr_opt(name)?;
    Ok(found.and_then(|found| found.cast_into::<PyDict>().ok()))
}

fn point_sets(given: &Bound<'_, PyAny>, groups: &mut Groups) -> PyResult<()> {
    for (name, ids) in dict(given, "point_sets")?.iter().flat_map(|sets| sets.iter()) {
        let ids = arrays::ids("mesh.point_sets", &ids)?;
        groups.entry(name.extract()?).or_default().extend(ids.values);
    }
    Ok(())
}

/// The nodes of some cells of a block.
fn nodes_of(block: &Block<'_>, cells: impl Iterator<Item = usize>) -> PyResult<Vec<u32>> {
    let nodes = arrays::ids("mesh.cells", &block.data)?;
    let [_, width] = nodes.shape[..] else {
        return Err(nodes.wrong_shape("mesh.cells", "(n, nodes of a cell)"));
    };
    let mut found = Vec::new();
    for cell in cells {
        let of_cell = cell.checked_mul(width).and_then(|at| nodes.values.get(at..at + width));
        let of_cell = of_cell.ok_or_else(|| {
            Class::Model.error(format!("a set of cells has cell {cell} of type {}", block.kind))
        })?;
        found.extend_from_slice(of_cell);
    }
    Ok(found)
}

/// Sets of cells: for each block the positions of its cells.
fn cell_sets(given: &Bound<'_, PyAny>, blocks: &[Block<'_>], groups: &mut Groups) -> PyResult<()> {
    for (name, of_blocks) in dict(given, "cell_sets")?.iter().flat_map(|sets| sets.iter()) {
        let name: String = name.extract()?;
        // Gmsh's bookkeeping, which are no cells.
        if name.starts_with("gmsh:") {
            continue;
        }
        for (block, cells) in blocks.iter().zip(of_blocks.try_iter()?) {
            let cells = cells?;
            if cells.is_none() {
                continue;
            }
            let cells = arrays::ids("mesh.cell_sets", &cells)?;
            let nodes = nodes_of(block, cells.values.iter().map(|&cell| cell as usize))?;
            groups.entry(name.clone()).or_default().extend(nodes);
        }
    }
    Ok(())
}

/// Gmsh's physical groups, by name, or by number without one.
fn physical_groups(
    given: &Bound<'_, PyAny>,
    blocks: &[Block<'_>],
    groups: &mut Groups,
) -> PyResult<()> {
    let data = dict(given, "cell_data")?;
    let physical = data.map(|data| data.get_item("gmsh:physical")).transpose()?.flatten();
    let Some(physical) = physical else { return Ok(()) };
    let mut names: BTreeMap<(u32, u32), String> = BTreeMap::new();
    for (name, of) in dict(given, "field_data")?.iter().flat_map(|data| data.iter()) {
        if let Ok(found) = arrays::ids("mesh.field_data", &of)
            && let [tag, dimension] = found.values[..]
        {
            names.insert((tag, dimension), name.extract()?);
        }
    }
    for (block, tags) in blocks.iter().zip(physical.try_iter()?) {
        let dimension = match block.kind.as_str() {
            "vertex" => 0,
            "line" => 1,
            "triangle" => 2,
            _ => 3,
        };
        let mut cells: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (cell, tag) in arrays::ids("mesh.cell_data", &tags?)?.values.into_iter().enumerate() {
            cells.entry(tag).or_default().push(cell);
        }
        for (tag, cells) in cells.into_iter().filter(|(tag, _)| *tag != 0) {
            let name = names.get(&(tag, dimension)).cloned().unwrap_or_else(|| tag.to_string());
            groups.entry(name).or_default().extend(nodes_of(block, cells.into_iter())?);
        }
    }
    Ok(())
}
