//! Keyword arguments: which there are, and options of the command made of them.

use std::ops::RangeInclusive;

use chaincell_host::cli::offline::Offline;
use chaincell_kernel::parts::PARTS;
use chaincell_kernel::stage::DELAY_MAX;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::arrays;
use crate::errors::Class;
use crate::numbers::{real, real_or, text, whole, wrong_type};

/// Arguments of a bake beside the mesh.
const BAKE: [&str; 32] = [
    "allow_parts",
    "alpha",
    "branches",
    "capacitance",
    "cells",
    "device_hz",
    "diagonals",
    "drop_unused",
    "energy_max_j",
    "fill_m",
    "fixed",
    "instant",
    "coarse",
    "k_m",
    "lean",
    "materials",
    "poisson",
    "contact_surface",
    "cuttable",
    "loose",
    "cut_spare",
    "toughness_j_per_m2",
    "tears",
    "tear_stretch",
    "tissue",
    "r_x",
    "rings",
    "stiffening",
    "stiffness_n_per_m",
    "stretch_min",
    "unit_m",
    "young_pa",
];

/// Arguments of a tissue that are whole numbers, with the ranges that the command has for them.
const WHOLE: [(&str, RangeInclusive<u32>); 5] = [
    ("delay_ticks", 0..=DELAY_MAX as u32),
    ("device_hz", 10..=100_000),
    ("engage_ramp_ms", 0..=60_000),
    ("sweeps", 1..=u16::MAX as u32),
    ("threads", 1..=PARTS as u32),
];

/// Names of the keyword arguments of `Model.bake`.
#[pyfunction]
pub(crate) fn bake_options() -> Vec<&'static str> {
    BAKE.to_vec()
}

/// Names of the keyword arguments of `Tissue`: the options of `chaincell run`.
#[pyfunction]
pub(crate) fn tissue_options() -> Vec<String> {
    let argument = |option: String| if option == "tool" { "tools".into() } else { option };
    Offline::names().into_iter().map(|name| argument(name).replace('-', "_")).collect()
}

/// Keyword arguments of a call.
pub(crate) struct Given<'a, 'py>(Option<&'a Bound<'py, PyDict>>);

impl<'a, 'py> Given<'a, 'py> {
    /// Those of a function that has only these.
    pub(crate) fn new<N: AsRef<str>>(
        function: &str,
        given: Option<&'a Bound<'py, PyDict>>,
        known: &[N],
    ) -> PyResult<Self> {
        for name in given.iter().flat_map(|given| given.keys()) {
            let name: String = name.extract()?;
            if !known.iter().any(|known| known.as_ref() == name) {
                let known: Vec<&str> = known.iter().map(N::as_ref).collect();
                return Err(PyTypeError::new_err(format!(
                    "{function}() got an unexpected keyword argument '{name}'; there are {}",
                    known.join(", ")
                )));
            }
        }
        Ok(Self(given))
    }

    /// Those of a bake.
    pub(crate) fn of_bake(given: Option<&'a Bound<'py, PyDict>>) -> PyResult<Self> {
        Self::new("bake", given, &BAKE)
    }

    /// An argument, if it was given and is not `None`.
    pub(crate) fn any(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.0.map(|given| given.get_item(name)).transpose()?.flatten();
        Ok(value.filter(|value| !value.is_none()))
    }

    /// An argument of a type that `wanted` says in words.
    pub(crate) fn get<T>(&self, name: &str, wanted: &str) -> PyResult<Option<T>>
    where
        T: for<'b> FromPyObject<'b, 'py>,
    {
        let Some(value) = self.any(name)? else { return Ok(None) };
        let found = value.extract::<T>();
        found.map(Some).map_err(|_| wrong_type(name, wanted, &value))
    }

    /// A real number.
    pub(crate) fn real(&self, name: &str) -> PyResult<Option<f64>> {
        self.any(name)?.map(|value| real(name, &value)).transpose()
    }

    /// A whole number in a range.
    pub(crate) fn whole(&self, name: &str, range: RangeInclusive<u32>) -> PyResult<Option<u32>> {
        self.any(name)?.map(|value| whole(name, &value, range)).transpose()
    }

    /// True or False.
    pub(crate) fn truth(&self, name: &str) -> PyResult<bool> {
        Ok(self.get(name, "True or False")?.unwrap_or_default())
    }
}

/// The tissue that keyword arguments ask for.
pub(crate) fn offline(given: Option<&Bound<'_, PyDict>>) -> PyResult<Offline> {
    let known = tissue_options();
    let given = Given::new("Tissue", given, &known)?;
    let mut options = Vec::new();
    for name in &known {
        let Some(value) = given.any(name)? else { continue };
        match name.as_str() {
            "tools" => options.extend(tools(&value)?.iter().map(|tool| format!("--tool={tool}"))),
            "contact" => options.push(format!("--contact={}", contact(&value)?)),
            _ => options.push(format!("--{}={}", name.replace('_', "-"), word(name, &value)?)),
        }
    }
    Offline::parse(options).map_err(|why| Class::Argument.host(why))
}

/// A number or a word, as the command line has it.
fn word(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    if value.is_instance_of::<PyString>() {
        return text(name, value);
    }
    if let Some((_, range)) = WHOLE.iter().find(|(of, _)| *of == name) {
        return Ok(whole(name, value, range.clone())?.to_string());
    }
    Ok(format!("{:?}", real_or(name, "a number or a word", value)?))
}

/// Tools by their parts.
fn tools(value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let wrong = || wrong_type("tools", "a list of texts, as [\"sphere:0.01\"]", value);
    if value.is_instance_of::<PyString>() {
        return Err(wrong());
    }
    let texts = value.extract::<Vec<String>>().map_err(|_| wrong())?;
    if texts.is_empty() {
        return Err(Class::Argument.error("`tools` is empty: give at least one tool, or None"));
    }
    Ok(texts)
}

/// A contact in words, or the nodes that are held.
fn contact(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if value.is_instance_of::<PyString>() {
        return value.extract();
    }
    let ids = arrays::ids("contact", value)?;
    if ids.shape.len() > 1 || ids.values.is_empty() {
        return Err(ids.wrong_shape("contact", "(n,): ids of the nodes that the tool holds"));
    }
    let ids: Vec<String> = ids.values.iter().map(u32::to_string).collect();
    Ok(format!("cells:nodes:{}", ids.join(",")))
}
