//! The numbers of a file: words of text, or binary with the highest byte first.

use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};

/// What an array holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    /// Anything of this many bytes that is only passed over.
    Other(u64),
    I32,
    I64,
    F32,
    F64,
}

impl Number {
    /// The type of a name, in letters of either case.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "signed_char" | "unsigned_char" => Self::Other(1),
            "short" | "unsigned_short" => Self::Other(2),
            "unsigned_int" => Self::Other(4),
            "unsigned_long" | "vtktypeuint64" => Self::Other(8),
            // Of the old vtkIdType 32 bits are written whatever the machine has.
            "int" | "vtktypeint32" | "vtkidtype" => Self::I32,
            "long" | "vtktypeint64" => Self::I64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> u64 {
        match self {
            Self::Other(size) => size,
            Self::I32 | Self::F32 => 4,
            Self::I64 | Self::F64 => 8,
        }
    }
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

    /// The next word; `what` it is, for errors.
    pub(super) fn text(&mut self, what: &str) -> Result<&'a str> {
        match self.bytes.word() {
            Some(word) => Ok(word),
            None => Err(self.bytes.truncated(what)),
        }
    }

    /// A word that must be this one.
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

    /// A count in text.
    pub(super) fn count(&mut self, what: &str) -> Result<u64> {
        let word = self.text(what)?;
        self.bytes.whole_of(word, what)
    }

    /// Begins an array of `count` times `each` numbers, which the file must have room for.
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

    /// The next number of an array, as a real one.
    pub(super) fn real(&mut self, number: Number, what: &str) -> Result<f64> {
        if self.binary {
            return match number {
                Number::F32 => self.bytes.f32(what).map(f64::from),
                _ => self.bytes.f64(what),
            };
        }
        let word = self.text(what)?;
        word.parse().map_err(|_| self.bytes.no_number(what, word, "a number"))
    }

    /// The next number of an array, as a whole one.
    pub(super) fn whole(&mut self, number: Number, what: &str) -> Result<u64> {
        let value = if self.binary {
            match number {
                Number::I64 => self.bytes.i64(what)?,
                _ => i64::from(self.bytes.i32(what)?),
            }
        } else {
            let word = self.text(what)?;
            word.parse().map_err(|_| self.bytes.no_number(what, word, "a whole number from 0"))?
        };
        u64::try_from(value)
            .map_err(|_| self.bytes.no_number(what, &value.to_string(), "a whole number from 0"))
    }

    /// Passes over `FIELD name n` and its arrays.
    pub(super) fn skip_field(&mut self) -> Result<()> {
        self.text("the field's name")?;
        let arrays = self.count("the number of arrays")?;
        let mut left = arrays;
        while left > 0 {
            let name = self.text("an array's name")?;
            if name.eq_ignore_ascii_case("METADATA") {
                self.skip_metadata();
                continue;
            }
            let components = self.count("the number of components")?;
            let tuples = self.count("the number of tuples")?;
            let kind = self.text("the array's type")?;
            let Some(number) = Number::named(kind) else {
                return Err(self.bytes.error(format!(
                    "a field of type '{}', whose length is not known here; save the mesh without \
                     field data",
                    shown(kind)
                )));
            };
            self.skip_array(tuples, components, number)?;
            left -= 1;
        }
        Ok(())
    }

    /// Passes over so many tuples of an array.
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

    /// Passes over lines up to a blank one.
    pub(super) fn skip_metadata(&mut self) {
        self.bytes.line();
        while self.bytes.line().is_some_and(|line| !line.trim_ascii().is_empty()) {}
    }
}
