//! Meshes in: arrays, objects like meshio's, and what the command reads.

use std::collections::BTreeMap;

use chaincell_host::mesh::{self, Mesh, MeshOptions, RawMesh};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyString};

use crate::arrays;
use crate::errors::Class;
use crate::numbers::{path, wrong_type};
use crate::signals::aside;

/// Cells of meshio that have a volume and are no first-order tetrahedra.
const OTHER_VOLUMES: [&str; 4] = ["hexahedron", "wedge", "pyramid", "tetra"];
/// Nodes of each named group.
type Groups = BTreeMap<String, Vec<u32>>;

/// The body of two arrays: of tetrahedra, or of the triangles of a surface that is filled.
pub(crate) fn of_arrays(
    py: Python<'_>,
    points: &Bound<'_, PyAny>,
    tets: Option<&Bound<'_, PyAny>>,
    triangles: Option<&Bound<'_, PyAny>>,
    options: MeshOptions,
) -> PyResult<Mesh> {
    let points = arrays::reals("points", points)?.rows("points")?;
    match (tets, triangles) {
        (Some(tets), None) => {
            let tets = arrays::ids("tets", tets)?;
            if matches!(tets.shape[..], [_, 3]) {
                let wanted = "(n, 4); give a closed surface as `triangles`, with `fill_m`";
                return Err(tets.wrong_shape("tets", wanted));
            }
            solid(py, "arrays", points, tets.rows("tets")?, Groups::new(), options)
        }
        (None, Some(triangles)) => {
            let triangles = arrays::ids("triangles", triangles)?.rows("triangles")?;
            surface(py, "arrays", points, triangles, options)
        }
        _ => Err(Class::Argument.error(
            "`tets` and `triangles`: give one of both, tetrahedra or a closed surface to fill",
        )),
    }
}

/// The body that a path, a generator or an object with points and cells stands for.
pub(crate) fn of_any(given: &Bound<'_, PyAny>, options: MeshOptions) -> PyResult<Mesh> {
    if given.is_instance_of::<PyString>() || given.hasattr("__fspath__")? {
        let spec = path("mesh", given)?;
        let Some(spec) = spec.to_str().map(str::to_owned) else {
            let text = format!("`mesh` {}: a path must be UTF-8", spec.display());
            return Err(Class::Model.error(text));
        };
        let mesh = aside(given.py(), move || mesh::load(&spec, &options))?;
        return mesh.map_err(|why| Class::Model.host(why));
    }
    of_object(given, options)
}

/// What the reader of files would refuse too.
fn check(options: &MeshOptions) -> PyResult<()> {
    if !(options.unit_m.is_finite() && options.unit_m > 0.0) {
        let text = format!("`unit_m` {}: must be above 0 and finite [m]", options.unit_m);
        return Err(Class::Model.error(text));
    }
    if options.diagonals {
        return Err(Class::Model.error("`diagonals` is for a plane: leave it out"));
    }
    Ok(())
}

/// The body of tetrahedra.
fn solid(
    py: Python<'_>,
    name: &'static str,
    mut nodes_m: Vec<[f64; 3]>,
    tetrahedra: Vec<[u32; 4]>,
    groups: Groups,
    options: MeshOptions,
) -> PyResult<Mesh> {
    check(&options)?;
    nodes_m.as_flattened_mut().iter_mut().for_each(|x| *x *= options.unit_m);
    let raw = RawMesh { nodes_m, tetrahedra, groups };
    let mesh = aside(py, move || mesh::from_raw(name, raw, &options))?;
    mesh.map_err(|why| Class::Model.host(why))
}

/// The body that fills a closed surface.
fn surface(
    py: Python<'_>,
    name: &'static str,
    points: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    options: MeshOptions,
) -> PyResult<Mesh> {
    check(&options)?;
    let mesh = aside(py, move || mesh::from_surface(name, &points, triangles, &options))?;
    mesh.map_err(|why| Class::Model.host(why))
}

/// Cells of one type in an object like meshio's.
struct Block<'py> {
    kind: String,
    data: Bound<'py, PyAny>,
}

fn of_object(given: &Bound<'_, PyAny>, options: MeshOptions) -> PyResult<Mesh> {
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
    let is_surface = |kind: &str| kind.starts_with("triangle") || kind.starts_with("quad");
    if tetrahedra.is_empty() && blocks.iter().any(|block| is_surface(&block.kind)) {
        return surface(given.py(), "object", nodes_m, triangles(&blocks)?, options);
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
    solid(given.py(), "object", nodes_m, tetrahedra, groups, options)
}

/// The triangles of a surface.
fn triangles(blocks: &[Block<'_>]) -> PyResult<Vec<[u32; 3]>> {
    let mut all = Vec::new();
    for Block { kind, data } in blocks {
        match kind.as_str() {
            "triangle" => all.extend(arrays::ids("mesh.cells", data)?.rows::<3>("mesh.cells")?),
            "vertex" | "line" => {}
            _ => {
                return Err(Class::Model.error(format!(
                    "the mesh has cells of type {kind}: a surface to fill is of first-order triangles; \
                     triangulate it"
                )));
            }
        }
    }
    Ok(all)
}

fn no_mesh(given: &Bound<'_, PyAny>) -> PyErr {
    let wanted = "a path, a generator as \"organ:1000\", or an object with points and cells as \
                  meshio has them";
    wrong_type("mesh", wanted, given)
}

/// The blocks of `cells`, or of `cells_dict`.
fn blocks<'py>(given: &Bound<'py, PyAny>) -> PyResult<Vec<Block<'py>>> {
    let cells = given.getattr_opt("cells")?;
    let of_kinds = match cells.as_ref().filter(|cells| !cells.is_instance_of::<PyDict>()) {
        Some(cells) => {
            let blocks = cells.try_iter().map_err(|_| no_cells("a list"))?;
            return blocks.map(|block| self::block(&block?)).collect();
        }
        None => given.getattr_opt("cells_dict")?.or(cells).ok_or_else(|| no_mesh(given))?,
    };
    let of_kinds = of_kinds.cast_into::<PyDict>().map_err(|_| no_mesh(given))?;
    of_kinds.iter().map(|(kind, data)| Ok(Block { kind: self::kind(&kind)?, data })).collect()
}

/// An item of `cells`: an object with type and data, or a pair of both.
fn block<'py>(item: &Bound<'py, PyAny>) -> PyResult<Block<'py>> {
    let (kind, data) = match (item.getattr_opt("type")?, item.getattr_opt("data")?) {
        (Some(kind), Some(data)) => (kind, data),
        _ => item.extract().map_err(|_| no_cells("pairs"))?,
    };
    Ok(Block { kind: self::kind(&kind)?, data })
}

/// The name of a type of cells.
fn kind(given: &Bound<'_, PyAny>) -> PyResult<String> {
    given.extract().map_err(|_| no_cells("types by their names"))
}

fn no_cells(wanted: &str) -> PyErr {
    PyTypeError::new_err(format!(
        "`mesh.cells`: give {wanted} as meshio has them, [(\"tetra\", ids)]; of other libraries give the \
         points and tetrahedra to Model.bake"
    ))
}

/// A dictionary of the object, where it has one of this name.
fn dict<'py>(given: &Bound<'py, PyAny>, name: &str) -> PyResult<Option<Bound<'py, PyDict>>> {
    let found = given.getattr_opt(name)?;
    Ok(found.and_then(|found| found.cast_into::<PyDict>().ok()))
}

fn point_sets(given: &Bound<'_, PyAny>, groups: &mut Groups) -> PyResult<()> {
    for (name, ids) in dict(given, "point_sets")?.iter().flat_map(|sets| sets.iter()) {
        let ids = arrays::ids("mesh.point_sets", &ids)?;
        let name = name.extract().map_err(|_| wrong_type("mesh.point_sets", "names", &name))?;
        groups.entry(name).or_default().extend(ids.values);
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

/// What an object has for each block of cells.
fn each_block<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyIterator>> {
    given.try_iter().map_err(|_| wrong_type(name, "a list with an array for each block", given))
}

/// Sets of cells: for each block the positions of its cells.
fn cell_sets(given: &Bound<'_, PyAny>, blocks: &[Block<'_>], groups: &mut Groups) -> PyResult<()> {
    for (name, of_blocks) in dict(given, "cell_sets")?.iter().flat_map(|sets| sets.iter()) {
        let name: String =
            name.extract().map_err(|_| wrong_type("mesh.cell_sets", "names", &name))?;
        // Gmsh's bookkeeping, which are no cells.
        if name.starts_with("gmsh:") {
            continue;
        }
        for (block, cells) in blocks.iter().zip(each_block("mesh.cell_sets", &of_blocks)?) {
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
    for (block, tags) in blocks.iter().zip(each_block("mesh.cell_data", &physical)?) {
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
