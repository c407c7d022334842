//! One `DataArray`: its type, and its numbers in any coding.

use roxmltree::Node;

use super::coding::Coding;
use crate::error::Result;
use crate::mesh::bytes::{Bytes, real_of, shown};
use crate::mesh::number::{Number, whole_of};

/// Requirement on a count, a position or a kind, for errors.
const WHOLE: &str = "a whole number from 0";

/// An array of numbers.
pub(super) struct Array<'a> {
    node: Node<'a, 'a>,
    name: &'a str,
    number: Number,
}

/// Returns the type with this name.
fn number_type(name: &str) -> Option<Number> {
    Some(match name {
        "Int8" => Number::I8,
        "UInt8" => Number::U8,
        "Int16" => Number::I16,
        "UInt16" => Number::U16,
        "Int32" => Number::I32,
        "UInt32" => Number::U32,
        "Int64" => Number::I64,
        "UInt64" => Number::U64,
        "Float32" => Number::F32,
        "Float64" => Number::F64,
        _ => return None,
    })
}

/// Reads the next number as a whole one; none if it has a fraction or is above the range of an `i64`.
fn whole_if_any(number: Number, bytes: &mut Bytes) -> Result<Option<i64>> {
    Ok(number.whole(bytes, "").ok().flatten())
}

impl<'a> Array<'a> {
    /// Returns the array of an element; errors name its line from now on.
    pub(super) fn of(node: Node<'a, 'a>, place: &mut Bytes) -> Result<Self> {
        place.return_to(node.range().start);
        let kind = node.attribute("type").unwrap_or("");
        let name = node.attribute("Name").unwrap_or("Points");
        let number = number_type(kind).ok_or_else(|| {
            place.error(format!(
                "array '{}' of type '{}'; whole numbers and Float32 or Float64 are read: save the mesh \
                 again",
                shown(name),
                shown(kind)
            ))
        })?;
        Ok(Self { node, name, number })
    }

    /// Returns its name.
    pub(super) fn name(&self) -> &'a str {
        self.name
    }

    /// Returns the number of components, as the file gives it.
    pub(super) fn components(&self) -> &'a str {
        self.node.attribute("NumberOfComponents").unwrap_or("1")
    }

    /// Returns the whole numbers, which must be `count`.
    pub(super) fn whole(&self, count: u64, coding: &Coding, place: &Bytes) -> Result<Vec<u64>> {
        if self.number.is_real() {
            return Err(place.error(format!(
                "array '{}' has real numbers where whole ones are needed; save the mesh again",
                shown(self.name)
            )));
        }
        if self.is_ascii() {
            return self.words(count, WHOLE, place, |word| word.parse().ok());
        }
        let negative = || self.no_number("a negative number", WHOLE, place);
        let from_0 = |number: Option<i64>| number.and_then(|number| u64::try_from(number).ok());
        let numbers = self.decoded(count, coding, place, whole_if_any)?;
        numbers.into_iter().map(|number| from_0(number).ok_or_else(negative)).collect()
    }

    /// Returns the numbers of any type, which must be `count`; none if one is no whole number.
    pub(super) fn references(
        &self,
        count: u64,
        coding: &Coding,
        place: &Bytes,
    ) -> Result<Option<Vec<i64>>> {
        if !self.is_ascii() {
            let numbers = self.decoded(count, coding, place, whole_if_any)?;
            return Ok(numbers.into_iter().collect());
        }
        if self.number.is_real() {
            return Ok(self.real(count, coding, place)?.into_iter().map(whole_of).collect());
        }
        self.words(count, "a whole number", place, |word| word.parse().ok()).map(Some)
    }

    /// Returns the real numbers, which must be `count`.
    pub(super) fn real(&self, count: u64, coding: &Coding, place: &Bytes) -> Result<Vec<f64>> {
        if self.is_ascii() {
            return self.words(count, "a number", place, real_of);
        }
        if !self.number.is_real() {
            return Err(place.error(format!(
                "array '{}' has whole numbers where Float32 or Float64 is needed; save the mesh again",
                shown(self.name)
            )));
        }
        self.decoded(count, coding, place, |number, bytes| number.real(bytes, ""))
    }

    /// Decodes the numbers, which must be `count`, and reads each.
    fn decoded<T>(
        &self,
        count: u64,
        coding: &Coding,
        place: &Bytes,
        read: impl Fn(Number, &mut Bytes) -> Result<T>,
    ) -> Result<Vec<T>> {
        let bytes = coding.decode(self.node, self.name, count, self.number.size(), place)?;
        let mut bytes = place.part(&bytes, coding.little);
        (0..count).map(|_| read(self.number, &mut bytes)).collect()
    }

    fn is_ascii(&self) -> bool {
        self.node.attribute("format").is_none_or(|format| format == "ascii")
    }

    /// Parses the numbers of a text.
    fn words<T>(
        &self,
        count: u64,
        wanted: &str,
        place: &Bytes,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Vec<T>> {
        let mut values = Vec::new();
        for word in self.node.text().unwrap_or("").split_ascii_whitespace() {
            let value = parse(word).ok_or_else(|| self.no_number(word, wanted, place))?;
            values.push(value);
        }
        if values.len() as u64 == count {
            return Ok(values);
        }
        Err(place.error(format!(
            "array '{}' has {} numbers where {count} are needed; the file is cut off or a count is \
             wrong: save or copy the mesh again",
            shown(self.name),
            values.len()
        )))
    }

    fn no_number(&self, word: &str, wanted: &str, place: &Bytes) -> crate::error::Error {
        place.no_number(&format!("a value of array '{}'", shown(self.name)), word, wanted)
    }
}
