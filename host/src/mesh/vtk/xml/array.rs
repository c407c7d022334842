//! One `DataArray`: its type, and its numbers in any coding.

use roxmltree::Node;

use super::coding::Coding;
use crate::error::Result;
use crate::mesh::bytes::{Bytes, real_of, shown};
use crate::mesh::number::whole_of;

/// Requirement on a count, a position or a kind, for errors.
const WHOLE: &str = "a whole number from 0";

/// An array of numbers.
pub(super) struct Array<'a> {
    node: Node<'a, 'a>,
    name: &'a str,
    number: Number,
}

/// Type of the numbers: size in bytes, true if they are real, true if they are signed.
#[derive(Clone, Copy)]
struct Number {
    size: usize,
    real: bool,
    signed: bool,
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        let (size, real, signed) = match name {
            "Int8" => (1, false, true),
            "UInt8" => (1, false, false),
            "Int16" => (2, false, true),
            "UInt16" => (2, false, false),
            "Int32" => (4, false, true),
            "UInt32" => (4, false, false),
            "Int64" => (8, false, true),
            "UInt64" => (8, false, false),
            "Float32" => (4, true, true),
            "Float64" => (8, true, true),
            _ => return None,
        };
        Some(Self { size, real, signed })
    }

    /// Returns a whole number from its bytes, lowest first; none if it is negative.
    fn whole(self, bytes: [u8; 8]) -> Option<u64> {
        let value = u64::from_le_bytes(bytes);
        let is_negative = self.signed && value >> (8 * self.size - 1) & 1 == 1;
        (!is_negative).then_some(value)
    }

    /// Returns a whole number of either sign from its bytes, lowest first; none above the range of an `i64`.
    fn reference(self, bytes: [u8; 8]) -> Option<i64> {
        // The shift removes bits above the number's bytes, and extends the sign.
        let unused = 64 - 8 * self.size;
        if self.signed {
            return Some(i64::from_le_bytes(bytes) << unused >> unused);
        }
        i64::try_from(u64::from_le_bytes(bytes)).ok()
    }

    fn float(self, bytes: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = bytes;
        if self.size == 4 {
            f32::from_le_bytes([a, b, c, d]).into()
        } else {
            f64::from_le_bytes(bytes)
        }
    }
}

impl<'a> Array<'a> {
    /// Returns the array of an element; errors name its line from now on.
    pub(super) fn of(node: Node<'a, 'a>, place: &mut Bytes) -> Result<Self> {
        place.return_to(node.range().start);
        let kind = node.attribute("type").unwrap_or("");
        let name = node.attribute("Name").unwrap_or("Points");
        let number = Number::named(kind).ok_or_else(|| {
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
        if self.number.real {
            return Err(place.error(format!(
                "array '{}' has real numbers where whole ones are needed; save the mesh again",
                shown(self.name)
            )));
        }
        let negative = || self.no_number("a negative number", WHOLE, place);
        if self.is_ascii() {
            return self.words(count, WHOLE, place, |word| word.parse().ok());
        }
        let bytes = coding.decode(self.node, self.name, count, self.number.size, place)?;
        let numbers = bytes.chunks_exact(self.number.size);
        numbers.map(|bytes| self.number.whole(coding.widened(bytes)).ok_or_else(negative)).collect()
    }

    /// Returns the numbers of any type, which must be `count`; none if one is no whole number.
    pub(super) fn references(
        &self,
        count: u64,
        coding: &Coding,
        place: &Bytes,
    ) -> Result<Option<Vec<i64>>> {
        if self.number.real {
            return Ok(self.real(count, coding, place)?.into_iter().map(whole_of).collect());
        }
        if self.is_ascii() {
            return self.words(count, "a whole number", place, |word| word.parse().ok()).map(Some);
        }
        let bytes = coding.decode(self.node, self.name, count, self.number.size, place)?;
        let numbers = bytes.chunks_exact(self.number.size);
        Ok(numbers.map(|bytes| self.number.reference(coding.widened(bytes))).collect())
    }

    /// Returns the real numbers, which must be `count`.
    pub(super) fn real(&self, count: u64, coding: &Coding, place: &Bytes) -> Result<Vec<f64>> {
        if self.is_ascii() {
            return self.words(count, "a number", place, real_of);
        }
        let bytes = coding.decode(self.node, self.name, count, self.number.size, place)?;
        let numbers = bytes.chunks_exact(self.number.size).map(|bytes| coding.widened(bytes));
        if !self.number.real {
            return Err(place.error(format!(
                "array '{}' has whole numbers where Float32 or Float64 is needed; save the mesh again",
                shown(self.name)
            )));
        }
        Ok(numbers.map(|bytes| self.number.float(bytes)).collect())
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
