//! Single arguments in: numbers, texts and objects of the package, each refused by its name.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use pyo3::exceptions::{PyTypeError, PyUnicodeEncodeError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBool, PyComplex, PyFloat, PyInt, PyString};

use crate::errors::Class;

/// Longest number that a text shows whole.
const DIGITS_SHOWN: usize = 24;

/// An argument as it was given, to be checked under its name, or its default.
#[derive(Debug, Clone)]
pub(crate) enum Arg<'py, T> {
    Default(T),
    Given(Bound<'py, PyAny>),
}

impl<'a, 'py, T> FromPyObject<'a, 'py> for Arg<'py, T> {
    type Error = std::convert::Infallible;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> Result<Self, Self::Error> {
        Ok(Self::Given(given.to_owned()))
    }
}

impl<T> Arg<'_, T> {
    /// A whole number in this range.
    pub(crate) fn whole(self, name: &str, range: RangeInclusive<T>) -> PyResult<T>
    where
        T: Copy + Into<u64> + TryFrom<u64>,
    {
        match self {
            Self::Default(value) => Ok(value),
            Self::Given(value) => whole(name, &value, range),
        }
    }
}

impl Arg<'_, f64> {
    /// A real number.
    pub(crate) fn real(self, name: &str) -> PyResult<f64> {
        match self {
            Self::Default(value) => Ok(value),
            Self::Given(value) => real(name, &value),
        }
    }
}

impl Arg<'_, &'static str> {
    /// A text.
    pub(crate) fn text(self, name: &str) -> PyResult<String> {
        match self {
            Self::Default(value) => Ok(value.to_owned()),
            Self::Given(value) => text(name, &value),
        }
    }
}

/// An argument of another type than the one wanted.
pub(crate) fn wrong_type(name: &str, wanted: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let found = value.get_type().name().map_or_else(|_| "this".into(), |name| name.to_string());
    PyTypeError::new_err(format!("`{name}`: give {wanted}, not {found}"))
}

/// A number as a text shows it; Python itself writes none of thousands of digits.
pub(crate) fn shown(value: &Bound<'_, PyAny>) -> String {
    let text =
        value.str().map_or_else(|_| "of thousands of digits".into(), |text| text.to_string());
    match text.char_indices().nth(DIGITS_SHOWN) {
        Some((end, _)) => format!("{}..", &text[..end]),
        None => text,
    }
}

/// A number as a text shows it: in short, where it has many digits.
pub(crate) fn brief(number: f64) -> String {
    let text = number.to_string();
    if text.len() > DIGITS_SHOWN { format!("{number:e}") } else { text }
}

/// Whether it is True or False, of Python or of numpy.
pub(crate) fn is_truth(value: &Bound<'_, PyAny>) -> bool {
    value.is_instance_of::<PyBool>() || numpy_kind(value) == Some('b')
}

/// The kind of a numpy scalar or of an array without dimensions.
fn numpy_kind(value: &Bound<'_, PyAny>) -> Option<char> {
    if value.getattr_opt("ndim").ok()??.extract::<usize>().ok()? != 0 {
        return None;
    }
    value.getattr_opt("dtype").ok()??.getattr_opt("kind").ok()??.extract().ok()
}

/// Whether it is one number, of whatever kind, and no array of them.
pub(crate) fn is_one(value: &Bound<'_, PyAny>) -> bool {
    value.is_instance_of::<PyFloat>()
        || value.is_instance_of::<PyInt>()
        || value.is_instance_of::<PyComplex>()
        || numpy_kind(value).is_some()
        || value.hasattr("__float__").is_ok_and(|has| has)
            && !value.hasattr("__len__").is_ok_and(|has| has)
}

/// A real number; whole ones are real too.
pub(crate) fn real(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    real_or(name, "a number", value)
}

/// The same, where something else is wanted too.
pub(crate) fn real_or(name: &str, wanted: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    if let Ok(float) = value.cast::<PyFloat>() {
        return float.extract();
    }
    let is_real = matches!(numpy_kind(value), None | Some('f' | 'i' | 'u'));
    if !is_one(value) || !is_real || is_truth(value) || value.is_instance_of::<PyComplex>() {
        return Err(wrong_type(name, wanted, value));
    }
    value.extract().map_err(|why: PyErr| {
        if why.is_instance_of::<pyo3::exceptions::PyOverflowError>(value.py()) {
            let text = format!("`{name}` {}: must be below 1.8e308", shown(value));
            return Class::Argument.error(text);
        }
        wrong_type(name, wanted, value)
    })
}

/// A whole number in a range.
pub(crate) fn whole<T>(
    name: &str,
    value: &Bound<'_, PyAny>,
    range: RangeInclusive<T>,
) -> PyResult<T>
where
    T: Copy + Into<u64> + TryFrom<u64>,
{
    let found = integer(name, value)?;
    let (least, most): (u64, u64) = ((*range.start()).into(), (*range.end()).into());
    let in_range = found.extract::<u64>().ok().filter(|found| (least..=most).contains(found));
    in_range.and_then(|found| T::try_from(found).ok()).ok_or_else(|| {
        Class::Argument.error(format!("`{name}` {}: must be from {least} to {most}", shown(&found)))
    })
}

/// A whole number of any size.
pub(crate) fn integer<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if !is_truth(value) {
        if value.is_instance_of::<PyInt>() {
            return Ok(value.clone());
        }
        if let Ok(index) = value.py().import("operator")?.call_method1("index", (value,)) {
            return Ok(index);
        }
    }
    Err(wrong_type(name, "a whole number", value))
}

/// A text.
pub(crate) fn text(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    let text = value.cast::<PyString>().map_err(|_| wrong_type(name, "a text", value))?;
    text.extract().map_err(|why: PyErr| {
        Class::Argument.error(format!("`{name}`: it is no Unicode text: {}", why.value(value.py())))
    })
}

/// A path.
pub(crate) fn path(name: &str, value: &Bound<'_, PyAny>) -> PyResult<PathBuf> {
    value.extract().map_err(|why: PyErr| {
        if why.is_instance_of::<PyUnicodeEncodeError>(value.py()) {
            let text = format!("`{name}`: it is no path: {}", why.value(value.py()));
            return Class::Argument.error(text);
        }
        wrong_type(name, "a path, a text or an object of pathlib", value)
    })
}

/// Bytes.
pub(crate) fn bytes(name: &str, value: &Bound<'_, PyAny>) -> PyResult<PyBackedBytes> {
    value.extract().map_err(|_| wrong_type(name, "bytes or a bytearray", value))
}

/// An object of the package.
pub(crate) fn object<'a, 'py, T: pyo3::PyClass>(
    name: &str,
    class: &str,
    value: &'a Bound<'py, PyAny>,
) -> PyResult<&'a Bound<'py, T>> {
    value.cast().map_err(|_| wrong_type(name, class, value))
}
