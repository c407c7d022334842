//! Arrays in: what numpy makes of an argument, with the kind and the shape that are wanted.

use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::errors::Class;

/// The values of an array, in C order, and its shape.
pub(crate) struct Values<T> {
    pub(crate) values: Vec<T>,
    pub(crate) shape: Vec<usize>,
}

/// The argument as an array, of whatever kind.
fn untyped<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    let numpy = given.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (given,)).map_err(|why| {
        Class::Argument.error(format!("`{name}`: it is no array: {}", why.value(given.py())))
    })?;
    Ok(array.cast_into::<PyUntypedArray>()?)
}

/// The kind of an array's elements, as numpy has it: `f`, `i`, `u`, `b` and so on.
fn kind(array: &Bound<'_, PyUntypedArray>) -> u8 {
    array.dtype().kind()
}

/// The elements as another type, in C order.
fn values<'py, T: numpy::Element + Clone>(
    array: &Bound<'py, PyUntypedArray>,
    as_type: &str,
) -> PyResult<Values<T>> {
    let cast = array.call_method1("astype", (as_type, "C"))?;
    let cast = cast.cast_into::<PyArrayDyn<T>>()?;
    let shape = cast.shape().to_vec();
    Ok(Values { values: cast.to_vec()?, shape })
}

fn wrong_type(name: &str, wanted: &str, array: &Bound<'_, PyUntypedArray>) -> PyErr {
    PyTypeError::new_err(format!("`{name}`: give {wanted}, not an array of {}", array.dtype()))
}

/// Real numbers; whole ones are real too.
pub(crate) fn reals(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Values<f64>> {
    let array = untyped(name, given)?;
    match kind(&array) {
        b'f' | b'i' | b'u' => values(&array, "float64"),
        _ => Err(wrong_type(name, "real numbers", &array)),
    }
}

/// Whole numbers from 0 up, as ids are; an empty list of any kind has none.
pub(crate) fn ids(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Values<u32>> {
    let array = untyped(name, given)?;
    if !matches!(kind(&array), b'i' | b'u') && !array.is_empty() {
        return Err(wrong_type(name, "whole numbers", &array));
    }
    let Values { values, shape } = values::<i64>(&array, "int64")?;
    let whole = values.iter().map(|&id| {
        u32::try_from(id).map_err(|_| {
            Class::Argument.error(format!("`{name}`: {id} is no id; ids count from 0"))
        })
    });
    Ok(Values { values: whole.collect::<PyResult<_>>()?, shape })
}

/// Truth values: of a boolean array alone.
pub(crate) fn flags(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Values<bool>> {
    let array = untyped(name, given)?;
    match kind(&array) {
        b'b' => values(&array, "bool"),
        _ => Err(wrong_type(name, "True and False", &array)),
    }
}

/// Whether an argument is an array of truth values.
pub(crate) fn is_mask(given: &Bound<'_, PyAny>) -> bool {
    untyped("", given).is_ok_and(|array| kind(&array) == b'b')
}

impl<T: Copy> Values<T> {
    /// Rows of so many.
    pub(crate) fn rows<const N: usize>(&self, name: &str) -> PyResult<Vec<[T; N]>> {
        if self.shape.len() != 2 || self.shape[1] != N {
            return Err(self.wrong_shape(name, &format!("(n, {N})")));
        }
        Ok(self.values.as_chunks::<N>().0.to_vec())
    }

    /// One value each for so many things.
    pub(crate) fn one_each(self, name: &str, count: usize, what: &str) -> PyResult<Vec<T>> {
        if self.shape == [count] {
            return Ok(self.values);
        }
        Err(self.wrong_shape(name, &format!("({count},): one for each {what}")))
    }

    /// An array of another shape than the one wanted.
    pub(crate) fn wrong_shape(&self, name: &str, wanted: &str) -> PyErr {
        let shape: Vec<String> = self.shape.iter().map(usize::to_string).collect();
        let comma = if shape.len() == 1 { "," } else { "" };
        let shape = shape.join(", ");
        Class::Argument
            .error(format!("`{name}`: its shape is ({shape}{comma}), it must be {wanted}"))
    }
}
