//! The numbers of a file: words of text, or binary numbers with the highest byte first.

use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};
use crate::mesh::number::{Number, whole_of};

/// Returns the type of a name, in letters of either case.
pub(super) fn number_type(name: &str) -> Option<Number> {
    Some(match name.to_ascii_lowercase().as_str() {
        "char" | "signed_char" => Number::I8,
        "unsigned_char" => Number::U8,
        "short" => Number::I16,
        "unsigned_short" => Number::U16,
        "unsigned_int" => Number::U32,
        "unsigned_long" | "vtktypeuint64" => Number::U64,
        // The old vtkIdType is written with 32 bits on every machine.
        "int" | "vtktypeint32" | "vtkidtype" => Number::I32,
        "long" | "vtktypeint64" => Number::I64,
        "float" => Number::F32,
        "double" => Number::F64,
        _ => return None,
    })
}

/// The head of an array of a field.
pub(super) struct FieldArray<'a> {
    pub(super) name: &'a str,
    pub(super) components: u64,
    pub(super) tuples: u64,
    pub(super) number: Number,
}

/// A file's numbers and words.
pub(super) struct Values<'a> {
    pub(super) bytes: Bytes<'a>,
    binary: bool,
}

impl<'a> Values<'a> {
    pub(super) fn new(mut bytes: Bytes<'a>, binary: bool) -> Self {
        bytes.lines = !binary;
        Self { bytes, binary }
    }

    /// Reads the next word; `what` describes it in errors.
    pub(super) fn text(&mut self, what: &str) -> Result<&'a str> {
        match self.bytes.word() {
            Some(word) => Ok(word),
            None => Err(self.bytes.truncated(what)),
        }
    }

    /// Reads a word that must be `keyword`.
    pub(super) fn keyword(&mut self, keyword: &str) -> Result<()> {
        let word = self.text(keyword)?;
        if word.eq_ignore_ascii_case(keyword) {
            return Ok(());
        }
        Err(self.bytes.error(format!(
            "'{}' where {keyword} should be; save or copy the mesh again",
            shown(word)
        )))
    }

    /// Reads a count in text.
    pub(super) fn count(&mut self, what: &str) -> Result<u64> {
        let word = self.text(what)?;
        self.bytes.whole_of(word, what)
    }

    /// Begins an array of `count` times `each` numbers, and checks that the file is long enough for them.
    pub(super) fn begin_data(
        &mut self,
        count: u64,
        each: u64,
        number: Number,
        what: &str,
    ) -> Result<()> {
        let room = if self.binary {
            self.bytes.line();
            number.size()
        } else {
            1
        };
        self.bytes.fits(count, each.saturating_mul(room), what)
    }

    /// Reads the next number of an array as a real one.
    pub(super) fn real(&mut self, number: Number, what: &str) -> Result<f64> {
        if self.binary {
            return number.real(&mut self.bytes, what);
        }
        let word = self.text(what)?;
        self.bytes.real_of(word, what)
    }

    /// Reads the next number of an array as a whole one from 0.
    pub(super) fn whole(&mut self, number: Number, what: &str) -> Result<u64> {
        let wanted = "a whole number from 0";
        if !self.binary {
            let word = self.text(what)?;
            return word.parse().map_err(|_| self.bytes.no_number(what, word, wanted));
        }
        let value = number.whole(&mut self.bytes, what)?.unwrap_or(-1);
        u64::try_from(value).map_err(|_| self.bytes.no_number(what, &value.to_string(), wanted))
    }

    /// Reads the next number of an array of any type; none if it is no whole one.
    pub(super) fn reference(&mut self, number: Number, what: &str) -> Result<Option<i64>> {
        if self.binary {
            number.whole(&mut self.bytes, what)
        } else if number.is_real() {
            self.real(number, what).map(whole_of)
        } else {
            let word = self.text(what)?;
            self.bytes.signed_of(word, what).map(Some)
        }
    }

    /// Skips `FIELD name n` and its arrays.
    pub(super) fn skip_field(&mut self) -> Result<()> {
        self.text("the field's name")?;
        let mut left = self.count("the number of arrays")?;
        while left > 0 {
            if let Some(array) = self.array_of_field()? {
                self.skip_array(array.tuples, array.components, array.number)?;
                left -= 1;
            }
        }
        Ok(())
    }

    /// Reads the head of the next array of a field; none if remarks after the last one were skipped.
    pub(super) fn array_of_field(&mut self) -> Result<Option<FieldArray<'a>>> {
        let name = self.text("an array's name")?;
        if name.eq_ignore_ascii_case("METADATA") {
            self.skip_metadata();
            return Ok(None);
        }
        let components = self.count("the number of components")?;
        let tuples = self.count("the number of tuples")?;
        let kind = self.text("the array's type")?;
        let number = number_type(kind).ok_or_else(|| {
            self.bytes.error(format!(
                "a field of type '{}', whose length is not known here; save the mesh without field data",
                shown(kind)
            ))
        })?;
        Ok(Some(FieldArray { name, components, tuples, number }))
    }

    /// Skips `tuples` tuples of an array.
    pub(super) fn skip_array(
        &mut self,
        tuples: u64,
        components: u64,
        number: Number,
    ) -> Result<()> {
        self.begin_data(tuples, components, number, "tuples")?;
        let count = tuples.saturating_mul(components);
        if self.binary {
            let bytes = count.saturating_mul(number.size());
            self.bytes.skip(usize::try_from(bytes).unwrap_or(usize::MAX));
        } else {
            for _ in 0..count {
                self.text("a value of the field")?;
            }
        }
        Ok(())
    }

    /// Skips lines up to a blank one.
    pub(super) fn skip_metadata(&mut self) {
        self.bytes.line();
        while self.bytes.line().is_some_and(|line| !line.trim_ascii().is_empty()) {}
    }
}
