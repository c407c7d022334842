//! What a bake may choose, from keyword arguments.

use chaincell_host::bake::tissue::{Band, STRETCH_MIN, Tissue, VolumeLaw};
use chaincell_host::bake::{self, BakeOptions, BasisSpacing, ImageBytes, PerCell, ProbeContact};
use chaincell_host::cli::values::per_cell;
use chaincell_host::mesh::{self, CELLS_MAX, Mesh, MeshOptions, NODES_MAX};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::arrays;
use crate::errors::Class;
use crate::given::{Given, wrong_type};

/// Poisson's ratio of soft tissue, where none is given.
const POISSON: f64 = 0.45;

/// How a mesh is read.
pub(crate) fn mesh_options(given: &Given<'_, '_>) -> PyResult<MeshOptions> {
    let cells: Option<usize> = given.get("cells", "a whole number")?;
    Ok(MeshOptions {
        unit_m: given.real("unit_m")?.unwrap_or(1.0),
        fill_m: given.real("fill_m")?,
        diagonals: given.truth("diagonals")?,
        drop_unused: given.truth("drop_unused")?,
        allow_parts: given.truth("allow_parts")?,
        rings: given.get("rings", "a whole number")?.unwrap_or(1),
        nodes_max: if cells.is_some() { NODES_MAX } else { CELLS_MAX },
    })
}

/// Bakes a mesh; Python may run meanwhile.
pub(crate) fn bake(py: Python<'_>, mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<ImageBytes> {
    let (fixed, options) = (fixed(mesh, given)?, options(mesh, given)?);
    let image = py.detach(|| bake::bake(mesh, &fixed, &options));
    image.map_err(|why| Class::Model.host(why))
}

fn options(mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<BakeOptions> {
    let tissue = tissue(mesh, given)?;
    let defaults = BakeOptions::default();
    let lean = given.truth("lean")?;
    let takes_surface = tissue.is_some() && !mesh.triangles.is_empty() && !lean;
    let surface = if takes_surface { "surface" } else { "cells" };
    Ok(BakeOptions {
        alpha: per_node("alpha", mesh, given)?.unwrap_or(defaults.alpha),
        stiffness_n_per_m: per_node("stiffness_n_per_m", mesh, given)?
            .unwrap_or(defaults.stiffness_n_per_m),
        tissue,
        saturation_m: given.real("k_m")?,
        resistance: given.real("r_x")?.unwrap_or(defaults.resistance),
        capacitance: given.real("capacitance")?.unwrap_or(defaults.capacitance),
        energy_max_j: given.real("energy_max_j")?,
        coarse_basis: hats(given)?,
        colours: given.truth("colours")?,
        lean,
        probe_contact: match word(given, "probe_contact", &["surface", "cells"])?.unwrap_or(surface)
        {
            "surface" => ProbeContact::Surface,
            _ => ProbeContact::Cells,
        },
        cells: given.get("cells", "a whole number")?,
    })
}

/// One of some words.
fn word(
    given: &Given<'_, '_>,
    name: &str,
    words: &[&'static str],
) -> PyResult<Option<&'static str>> {
    let Some(text) = given.get::<String>(name, "a word")? else { return Ok(None) };
    let found = words.iter().find(|word| **word == text).copied();
    found.map(Some).ok_or_else(|| {
        Class::Model.error(format!("`{name}` \"{text}\": give {}", words.join(" or ")))
    })
}

/// Nodal shapes, where Young's modulus is given.
fn tissue(mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<Option<Tissue>> {
    let Some(young_pa) = per_node("young_pa", mesh, given)? else {
        for name in ["poisson", "law", "stretch_min", "stiffening"] {
            if given.any(name)?.is_some() {
                let text = format!("`{name}` goes with `young_pa`: give both, or leave it out");
                return Err(Class::Model.error(text));
            }
        }
        return Ok(None);
    };
    for name in ["alpha", "stiffness_n_per_m"] {
        if given.any(name)?.is_some() {
            let text = format!("`{name}` is for links: leave it out, or leave `young_pa` out");
            return Err(Class::Model.error(text));
        }
    }
    let poisson = per_node("poisson", mesh, given)?.unwrap_or(PerCell::Uniform(POISSON));
    let law = match word(given, "law", &["det1", "trace"])? {
        Some("trace") => VolumeLaw::Trace,
        _ => VolumeLaw::Det1,
    };
    let stretch_min = number_or(given, "stretch_min", &["none"])?;
    let stretch_min = match stretch_min {
        None => Some(STRETCH_MIN),
        Some(Ok(stretch)) => Some(stretch),
        Some(Err(_)) => None,
    };
    Ok(Some(Tissue { young_pa, poisson, law, stretch_min, stiffening: stiffening(given)? }))
}

/// Half-widths with their moduli \[Pa\].
fn stiffening(given: &Given<'_, '_>) -> PyResult<Vec<Band>> {
    let wanted = "a dict of half-widths and moduli, as {0.15: 1700.0}";
    let Some(bands) = given.get::<Bound<'_, PyDict>>("stiffening", wanted)? else {
        return Ok(Vec::new());
    };
    let band = |(half_width, modulus_pa): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let number = |of: &Bound<'_, PyAny>| {
            of.extract().map_err(|_| wrong_type("stiffening", "numbers", of))
        };
        Ok(Band { half_width: number(&half_width)?, modulus_pa: number(&modulus_pa)? })
    };
    bands.iter().map(band).collect()
}

fn hats(given: &Given<'_, '_>) -> PyResult<BasisSpacing> {
    Ok(match number_or(given, "hats", &["auto", "none"])? {
        None | Some(Err("auto")) => BasisSpacing::BySize,
        Some(Ok(links)) => BasisSpacing::Links(links),
        Some(Err(_)) => BasisSpacing::None,
    })
}

/// A number, or one of some words.
fn number_or(
    given: &Given<'_, '_>,
    name: &str,
    words: &[&'static str],
) -> PyResult<Option<Result<f64, &'static str>>> {
    match given.any(name)? {
        Some(value) if value.is_instance_of::<PyString>() => Ok(word(given, name, words)?.map(Err)),
        _ => Ok(given.real(name)?.map(Ok)),
    }
}

/// A value for all nodes, one for each, or what the command line would be told.
fn per_node(name: &str, mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<Option<PerCell>> {
    let Some(value) = given.any(name)? else { return Ok(None) };
    if let Ok(text) = value.cast::<PyString>() {
        let text: String = text.extract()?;
        let option = format!("`{name}`");
        return per_cell(&option, &text, mesh).map(Some).map_err(|why| Class::Model.host(why));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(Some(PerCell::Uniform(number)));
    }
    let values = arrays::reals(name, &value)?;
    values.one_each(name, mesh.nodes_m.len(), "node").map(PerCell::Each).map(Some)
}

/// Nodes held for ever: ids, a mask of the nodes, or a selector.
fn fixed(mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<Vec<u32>> {
    let Some(value) = given.any("fixed")? else { return Ok(mesh.default_fixed.clone()) };
    let nodes = mesh.nodes_m.len();
    if let Ok(text) = value.cast::<PyString>() {
        let text: String = text.extract()?;
        if text == "none" {
            return Ok(Vec::new());
        }
        let (places, groups) = (&mesh.nodes_m, &mesh.groups);
        let found = mesh::select(&text, places, groups, &mesh.border, "`fixed`");
        return found.map_err(|why| Class::Model.host(why));
    }
    if arrays::is_mask(&value) {
        let mask = arrays::flags("fixed", &value)?.one_each("fixed", nodes, "node")?;
        return Ok((0..).zip(mask).filter(|(_, is)| *is).map(|(id, _)| id).collect());
    }
    let ids = arrays::ids("fixed", &value)?;
    if ids.shape.len() != 1 {
        return Err(ids.wrong_shape("fixed", "(n,): ids of nodes, or a mask of all nodes"));
    }
    if let Some(id) = ids.values.iter().find(|id| **id as usize >= nodes) {
        let text = format!("`fixed`: node {id}, and there are {nodes} nodes: ids count from 0");
        return Err(Class::Model.error(text));
    }
    Ok(ids.values)
}
