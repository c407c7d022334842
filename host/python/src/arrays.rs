//! Arrays in: what numpy makes of an argument, with the kind and the shape that are wanted.

use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};

use crate::errors::Class;
use crate::numbers::{is_truth, shown};

/// Most values of an array: a pose for each millisecond of a day.
const VALUES_MAX: usize = 300_000_000;

/// The values of an array, in C order, and its shape.
pub(crate) struct Values<T> {
    pub(crate) values: Vec<T>,
    pub(crate) shape: Vec<usize>,
}

/// The argument as an array, of whatever kind.
fn untyped<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = given.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (given,)).map_err(|why| {
        if why.is_instance_of::<PyValueError>(py) || why.is_instance_of::<PyTypeError>(py) {
            return Class::Argument.error(format!("`{name}`: it is no array: {}", why.value(py)));
        }
        why
    })?;
    // An array of numpy itself is passed through; only others can have a mask.
    if !array.is(given) && numpy.getattr("ma")?.call_method1("is_masked", (given,))?.extract()? {
        let text = format!("`{name}`: it has masked values: fill them, or leave them out");
        return Err(Class::Argument.error(text));
    }
    let array = array.cast_into::<PyUntypedArray>()?;
    if array.len() > VALUES_MAX {
        let text = format!("`{name}`: {} values, the limit is {VALUES_MAX}", array.len());
        return Err(Class::Argument.error(text));
    }
    Ok(array)
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

/// Refuses lists that have True or False among their numbers, of which numpy makes 1 and 0; `depth` is
/// how many lists lie within each other.
fn refuse_truths(name: &str, wanted: &str, given: &Bound<'_, PyAny>, depth: usize) -> PyResult<()> {
    let refuse = |item: Bound<'_, PyAny>| match depth {
        2.. => refuse_truths(name, wanted, &item, depth - 1),
        _ if item.is_exact_instance_of::<PyFloat>() || item.is_exact_instance_of::<PyInt>() => {
            Ok(())
        }
        _ if is_truth(&item) => {
            Err(PyTypeError::new_err(format!("`{name}`: give {wanted}, not True or False")))
        }
        _ => Ok(()),
    };
    if depth == 0 {
        return Ok(());
    }
    if let Ok(list) = given.cast::<PyList>() {
        return list.iter().try_for_each(refuse);
    }
    given.cast::<PyTuple>().map_or(Ok(()), |tuple| tuple.iter().try_for_each(refuse))
}

/// Real numbers; whole ones are real too.
pub(crate) fn reals(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Values<f64>> {
    let array = untyped(name, given)?;
    if !matches!(kind(&array), b'f' | b'i' | b'u') {
        return Err(wrong_type(name, "real numbers", &array));
    }
    refuse_truths(name, "real numbers", given, array.ndim())?;
    values(&array, "float64")
}

/// Whole numbers from 0 up, as ids are; an empty list of any kind has none.
pub(crate) fn ids(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Values<u32>> {
    wholes(name, given, u32::MAX, &|id| format!("`{name}`: {id} is no id; ids count from 0"))
}

/// Whole numbers from 0 to `most`.
pub(crate) fn up_to(name: &str, given: &Bound<'_, PyAny>, most: u32) -> PyResult<Values<u32>> {
    wholes(name, given, most, &|found| format!("`{name}` {found}: must be from 0 to {most}"))
}

/// Whole numbers from 0 to `most`; `refusal` says what another one is.
fn wholes(
    name: &str,
    given: &Bound<'_, PyAny>,
    most: u32,
    refusal: &dyn Fn(&str) -> String,
) -> PyResult<Values<u32>> {
    let array = untyped(name, given)?;
    let shape = array.shape().to_vec();
    if array.is_empty() {
        return Ok(Values { values: Vec::new(), shape });
    }
    refuse_truths(name, "whole numbers", given, array.ndim())?;
    let values = match kind(&array) {
        b'i' => in_range(&values::<i64>(&array, "int64")?.values, most, i64::to_string),
        b'u' => in_range(&values::<u64>(&array, "uint64")?.values, most, u64::to_string),
        // Numbers too large for numpy stay objects of Python, or become floats beside others.
        b'O' | b'f' if kind(&array) == b'O' || !array.is(given) => {
            let numpy = given.py().import("numpy")?;
            let objects = numpy.call_method1("asarray", (given, "O"))?.call_method0("ravel")?;
            let items = objects.try_iter()?.collect::<PyResult<Vec<_>>>()?;
            if items.iter().any(|item| !item.is_instance_of::<PyInt>() || is_truth(item)) {
                return Err(wrong_type(name, "whole numbers", &array));
            }
            let id = |of: &Bound<'_, PyAny>| of.extract::<u32>().ok().filter(|is| *is <= most);
            items.iter().map(|of| id(of).ok_or_else(|| shown(of))).collect()
        }
        _ => return Err(wrong_type(name, "whole numbers", &array)),
    };
    let values = values.map_err(|found| Class::Argument.error(refusal(&found)))?;
    Ok(Values { values, shape })
}

/// The numbers from 0 to `most`, or the first that is none.
fn in_range<T: Copy>(found: &[T], most: u32, shown: fn(&T) -> String) -> Result<Vec<u32>, String>
where
    u32: TryFrom<T>,
{
    let whole = |of: &T| u32::try_from(*of).ok().filter(|is| *is <= most).ok_or_else(|| shown(of));
    found.iter().map(whole).collect()
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
