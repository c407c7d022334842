//! What a bake may choose, from keyword arguments.

use std::sync::Arc;

use chaincell_host::bake::tissue::{
    self, Band, Branch, KnownTissue, Relaxation, STRETCH_MIN, Tissue,
};
use chaincell_host::bake::{
    self, BakeOptions, BasisSpacing, ContactSurface, Cuttable, ImageBytes, PerCell,
};
use chaincell_host::cli::values::{Material, per_cell, toughness_with_materials, with_materials};
use chaincell_host::mesh::{self, CELLS_MAX, Filling, Mesh, MeshOptions, NODES_MAX};
use chaincell_kernel::{Loose, TearLimit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::arrays;
use crate::errors::Class;
use crate::given::Given;
use crate::numbers::{is_one, real, real_or, wrong_type};
use crate::signals::aside;

/// Poisson's ratio of soft tissue, where none is given.
const POISSON: f64 = 0.45;
/// What `materials` is, for errors.
const MATERIALS: &str = "{\"GROUP\": {\"young_pa\": E, \"poisson\": NU, \"toughness_j_per_m2\": J}}, one of \
                         these at least";

/// How a mesh is read.
pub(crate) fn mesh_options(given: &Given<'_, '_>) -> PyResult<MeshOptions> {
    Ok(MeshOptions {
        unit_m: given.real("unit_m")?.unwrap_or(1.0),
        filling: filling(given)?,
        diagonals: given.truth("diagonals")?,
        drop_unused: given.truth("drop_unused")?,
        allow_parts: given.truth("allow_parts")?,
        rings: given.whole("rings", 1..=u32::MAX)?.unwrap_or(1),
        nodes_max: if cells(given)?.is_some() { NODES_MAX } else { CELLS_MAX },
    })
}

/// A size, or what the command line would be told.
fn filling(given: &Given<'_, '_>) -> PyResult<Option<Filling>> {
    match given.any("fill_m")? {
        Some(value) if value.is_instance_of::<PyString>() => {
            let text: String = value.extract()?;
            let wrong = |why| Class::Model.error(format!("`fill_m` {text}: {why}"));
            text.parse().map(Some).map_err(wrong)
        }
        _ => Ok(given.real("fill_m")?.map(Filling::even)),
    }
}

/// Groups of nodes that become cells.
fn cells(given: &Given<'_, '_>) -> PyResult<Option<usize>> {
    Ok(given.whole("cells", 2..=CELLS_MAX as u32)?.map(|count| count as usize))
}

/// Bakes a mesh; Python may run meanwhile.
pub(crate) fn bake(py: Python<'_>, mesh: Arc<Mesh>, given: &Given<'_, '_>) -> PyResult<ImageBytes> {
    let (fixed, options) = (fixed(&mesh, given)?, options(&mesh, given)?);
    let image = aside(py, move || bake::bake(&mesh, &fixed, &options))?;
    image.map_err(|why| Class::Model.host(why))
}

fn options(mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<BakeOptions> {
    let tissue = tissue(mesh, given)?;
    let defaults = BakeOptions::default();
    let lean = given.truth("lean")?;
    let link_relaxation = match tissue {
        None => relaxation(given, None, false)?,
        Some(_) => None,
    };
    Ok(BakeOptions {
        alpha: per_node("alpha", mesh, given)?.unwrap_or(defaults.alpha),
        stiffness_n_per_m: per_node("stiffness_n_per_m", mesh, given)?
            .unwrap_or(defaults.stiffness_n_per_m),
        link_relaxation,
        tissue,
        saturation_m: given.real("k_m")?,
        resistance: given.real("r_x")?.unwrap_or(defaults.resistance),
        capacitance: given.real("capacitance")?.unwrap_or(defaults.capacitance),
        energy_max_j: given.real("energy_max_j")?,
        coarse_basis: coarse_functions(given)?,
        lean,
        contact_surface: match word(given, "contact_surface", &["auto", "yes", "no"])? {
            Some("yes") => ContactSurface::Yes,
            Some("no") => ContactSurface::No,
            _ => ContactSurface::Auto,
        },
        cuttable: cuttable(mesh, given)?,
        cells: cells(given)?,
    })
}

/// Preparations for cuts, of a body that can be cut.
fn cuttable(mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<Option<Cuttable>> {
    let groups = GroupMaterial::all(given)?;
    if !given.truth("cuttable")? {
        for name in ["cut_spare", "toughness_j_per_m2", "tears", "tear_stretch", "loose"] {
            if given.any(name)?.is_some() {
                let text =
                    format!("`{name}` goes with `cuttable=True`: give it, or leave this out");
                return Err(Class::Model.error(text));
            }
        }
        if let Some(group) = groups.iter().find(|group| group.toughness_j_per_m2.is_some()) {
            let text = format!(
                "`materials: {}: toughness_j_per_m2` goes with `cuttable=True`: give it, or leave this out",
                group.name
            );
            return Err(Class::Model.error(text));
        }
        return Ok(None);
    }
    let defaults = Cuttable::default();
    let of_known = known(given)?.and_then(|tissue| tissue.toughness_j_per_m2);
    let toughness = per_node("toughness_j_per_m2", mesh, given)?;
    let toughness =
        toughness.or(of_known.map(PerCell::Uniform)).unwrap_or(defaults.toughness_j_per_m2);
    let materials: Vec<Material<'_>> = groups.iter().map(GroupMaterial::material).collect();
    let toughness_j_per_m2 = toughness_with_materials(toughness, &materials, mesh)
        .map_err(|why| Class::Model.host(why))?;
    let spare_share = given.real("cut_spare")?.unwrap_or(defaults.spare_share);
    let loose = match word(given, "loose", &["leave", "freeze", "drop"])? {
        Some("freeze") => Loose::Freeze,
        Some("drop") => Loose::Drop,
        _ => Loose::Leave,
    };
    Ok(Some(Cuttable { toughness_j_per_m2, spare_share, tear_limit: tear_limit(given)?, loose }))
}

/// The limit at which a body tears by itself.
fn tear_limit(given: &Given<'_, '_>) -> PyResult<Option<TearLimit>> {
    let by_toughness = given.truth("tears")?.then_some(TearLimit::Toughness);
    match (given.real("tear_stretch")?, by_toughness) {
        (Some(_), Some(_)) => {
            let text = "`tears`, `tear_stretch`: a body tears by one of them: leave the other out";
            Err(Class::Model.error(text))
        }
        (Some(stretch), None) => Ok(Some(TearLimit::Stretch(stretch as f32))),
        (None, limit) => Ok(limit),
    }
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

/// Nodal shapes, where the tissue has a stiffness.
fn tissue(mesh: &Mesh, given: &Given<'_, '_>) -> PyResult<Option<Tissue>> {
    let (young_pa, groups) = (per_node("young_pa", mesh, given)?, GroupMaterial::all(given)?);
    let known = known(given)?;
    if young_pa.is_none() && groups.is_empty() && known.is_none() {
        let options = ["poisson", "stretch_min", "stiffening"];
        for name in options {
            if given.any(name)?.is_some() {
                let text = format!(
                    "`{name}` goes with `young_pa`, `materials` or `tissue`: give one of them, or leave it out"
                );
                return Err(Class::Model.error(text));
            }
        }
        return Ok(None);
    }
    for name in ["alpha", "stiffness_n_per_m"] {
        if given.any(name)?.is_some() {
            let text = format!(
                "`{name}` is for links: leave it out, or leave `young_pa`, `materials` and `tissue` out"
            );
            return Err(Class::Model.error(text));
        }
    }
    // What is given goes before what the table has.
    let is_modulus_given = young_pa.is_some();
    let of_known = |value: fn(&KnownTissue) -> f64| known.as_ref().map(value);
    let young_pa = young_pa.or(of_known(|of| of.young_pa).map(PerCell::Uniform));
    let poisson = per_node("poisson", mesh, given)?;
    let poisson =
        poisson.unwrap_or_else(|| PerCell::Uniform(of_known(|of| of.poisson).unwrap_or(POISSON)));
    let (young_pa, poisson) = match young_pa {
        Some(young_pa) if groups.is_empty() => (young_pa, poisson),
        young_pa => {
            let materials: Vec<Material<'_>> = groups.iter().map(GroupMaterial::material).collect();
            let found = with_materials(young_pa, poisson, &materials, mesh);
            found.map_err(|why| Class::Model.host(why))?
        }
    };
    let stretch_min = number_or(given, "stretch_min", &["none"])?;
    let stretch_min = match stretch_min {
        None => Some(STRETCH_MIN),
        Some(Ok(stretch)) => Some(stretch),
        Some(Err(_)) => None,
    };
    let of_known = known.as_ref().map(|tissue| tissue.stiffening.clone());
    let stiffening = stiffening(given)?.or(of_known).unwrap_or_default();
    let relaxation = relaxation(given, known.as_ref(), is_modulus_given)?;
    let mut options = Vec::new();
    for name in ["young_pa", "poisson", "stiffening", "branches", "toughness_j_per_m2"] {
        if given.any(name)?.is_some() {
            options.push(name);
        }
    }
    if !groups.is_empty() {
        options.extend(["young_pa", "poisson", "toughness_j_per_m2"]);
    }
    let row = known.as_ref().and_then(|tissue| tissue.row(|option| options.contains(&option)));
    Ok(Some(Tissue { young_pa, poisson, stretch_min, stiffening, relaxation, row }))
}

/// Branches of stress that relaxes.
fn relaxation(
    given: &Given<'_, '_>,
    known: Option<&KnownTissue>,
    is_modulus_given: bool,
) -> PyResult<Option<Relaxation>> {
    let wanted = "pairs of a modulus over the long-term one and a time [s], as [(2.0, 0.1)]";
    let branches = given.get::<Vec<(f64, f64)>>("branches", wanted)?;
    let branch = |(ratio, time_s)| Branch { ratio, time_s };
    let branches = branches.map(|pairs| pairs.into_iter().map(branch).collect());
    let device_hz = given.whole("device_hz", 10..=100_000)?;
    let is_instant = given.truth("instant")?;
    let found = tissue::relaxation(known, branches, is_modulus_given, is_instant, device_hz);
    found.map_err(|why| Class::Model.host(why))
}

/// The tissue of the table that is asked for.
fn known(given: &Given<'_, '_>) -> PyResult<Option<KnownTissue>> {
    let Some(name) = given.get::<String>("tissue", "the name of a tissue")? else {
        return Ok(None);
    };
    KnownTissue::find(&name).map(Some).map_err(|why| Class::Model.host(why))
}

/// The material of a group.
struct GroupMaterial {
    name: String,
    young_pa: Option<f64>,
    poisson: Option<f64>,
    toughness_j_per_m2: Option<f64>,
}

impl GroupMaterial {
    /// All of `materials`, in their order; none where it is not given.
    fn all(given: &Given<'_, '_>) -> PyResult<Vec<Self>> {
        let Some(materials) = given.any("materials")? else { return Ok(Vec::new()) };
        let wrong = |value: &Bound<'_, PyAny>| wrong_type("materials", MATERIALS, value);
        let mut groups = Vec::new();
        for (group, values) in dict(&materials, &wrong)? {
            let name: String = group.extract().map_err(|_| wrong(&group))?;
            let mut of_group =
                Self { name, young_pa: None, poisson: None, toughness_j_per_m2: None };
            for (key, value) in dict(&values, &wrong)? {
                let key: String = key.extract().map_err(|_| wrong(&key))?;
                let name = format!("materials: {}: {key}", of_group.name);
                let slot = match key.as_str() {
                    "young_pa" => &mut of_group.young_pa,
                    "poisson" => &mut of_group.poisson,
                    "toughness_j_per_m2" => &mut of_group.toughness_j_per_m2,
                    _ => {
                        let there = "there are young_pa, poisson and toughness_j_per_m2";
                        return Err(Class::Model.error(format!("`{name}`: {there}")));
                    }
                };
                *slot = Some(finite(&name, &value)?);
            }
            let Self { young_pa, poisson, toughness_j_per_m2, .. } = of_group;
            if [young_pa, poisson, toughness_j_per_m2] == [None; 3] {
                let text = format!("`materials: {}` is empty: give {MATERIALS}", of_group.name);
                return Err(Class::Model.error(text));
            }
            groups.push(of_group);
        }
        if groups.is_empty() {
            return Err(Class::Model.error(format!("`materials` is empty: give {MATERIALS}")));
        }
        Ok(groups)
    }

    /// The same as the command line has it.
    fn material(&self) -> Material<'_> {
        let Self { name, young_pa, poisson, toughness_j_per_m2 } = self;
        Material {
            name,
            young_pa: *young_pa,
            poisson: *poisson,
            toughness_j_per_m2: *toughness_j_per_m2,
        }
    }
}

/// Keys and values of a dictionary.
fn dict<'py>(
    given: &Bound<'py, PyAny>,
    wrong: &dyn Fn(&Bound<'py, PyAny>) -> PyErr,
) -> PyResult<Vec<(Bound<'py, PyAny>, Bound<'py, PyAny>)>> {
    Ok(given.cast::<PyDict>().map_err(|_| wrong(given))?.iter().collect())
}

/// A finite number.
fn finite(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let number = real(name, value)?;
    if number.is_finite() {
        return Ok(number);
    }
    Err(Class::Model.error(format!("`{name}` {number}: must be finite")))
}

/// Half-widths with their moduli \[Pa\].
fn stiffening(given: &Given<'_, '_>) -> PyResult<Option<Vec<Band>>> {
    let wanted = "a dict of half-widths and moduli, as {0.15: 1700.0} or {'short:0.035': 22000.0}";
    let Some(bands) = given.get::<Bound<'_, PyDict>>("stiffening", wanted)? else {
        return Ok(None);
    };
    let band = |(half_width, modulus_pa): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let number = |of: &Bound<'_, PyAny>| real_or("stiffening", "numbers", of);
        let modulus_pa = number(&modulus_pa)?;
        // A half-width with its side is text.
        match half_width.extract::<String>() {
            Ok(text) => format!("{text}={modulus_pa}").parse().map_err(|_| {
                let remedy =
                    "give a half-width as 0.1, or as 'short:0.1' or 'long:0.1' for one side";
                Class::Model.error(format!("`stiffening` {text}: {remedy}"))
            }),
            Err(_) => Ok(Band::new(number(&half_width)?, modulus_pa)),
        }
    };
    bands.iter().map(band).collect::<PyResult<_>>().map(Some)
}

fn coarse_functions(given: &Given<'_, '_>) -> PyResult<BasisSpacing> {
    Ok(match number_or(given, "coarse", &["auto", "none"])? {
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
    if is_one(&value) {
        return real(name, &value).map(PerCell::Uniform).map(Some);
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
