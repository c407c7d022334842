//! The numbers of a file: words of text, or binary with the highest byte first.

use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};

/// What an array holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    /// The type of a name, in letters of either case.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "signed_char" => Self::I8,
            "unsigned_char" => Self::U8,
            "short" => Self::I16,
            "unsigned_short" => Self::U16,
            "unsigned_int" => Self::U32,
            "unsigned_long" | "vtktypeuint64" => Self::U64,
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
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether it is a real number.
    fn is_real(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// A real number that is a whole one; none where it has a fraction, or is too large to have one.
pub(super) fn whole_of(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() < 1e15).then_some(value as i64)
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

    /// The next number of an array, as a whole one from 0.
    pub(super) fn whole(&mut self, number: Number, what: &str) -> Result<u64> {
        let wanted = "a whole number from 0";
        if !self.binary {
            let word = self.text(what)?;
            return word.parse().map_err(|_| self.bytes.no_number(what, word, wanted));
        }
        let value = self.signed(number, what)?;
        u64::try_from(value).map_err(|_| self.bytes.no_number(what, &value.to_string(), wanted))
    }

    /// The next number of an array of whole ones, of either sign.
    fn signed(&mut self, number: Number, what: &str) -> Result<i64> {
        if !self.binary {
            let word = self.text(what)?;
            return self.bytes.signed_of(word, what);
        }
        Ok(match number {
            Number::I8 => i8::from_le_bytes(self.bytes.take(what)?).into(),
            Number::U8 => u8::from_le_bytes(self.bytes.take(what)?).into(),
            Number::I16 => i16::from_le_bytes(self.bytes.take(what)?).into(),
            Number::U16 => u16::from_le_bytes(self.bytes.take(what)?).into(),
            Number::U32 => u32::from_le_bytes(self.bytes.take(what)?).into(),
            Number::I64 => self.bytes.i64(what)?,
            Number::U64 => {
                let value = self.bytes.u64(what)?;
                i64::try_from(value).map_err(|_| {
                    self.bytes.no_number(what, &value.to_string(), "at most 9223372036854775807")
                })?
            }
            _ => self.bytes.i32(what)?.into(),
        })
    }

    /// The next number of an array of any type; none where it is no whole one.
    pub(super) fn reference(&mut self, number: Number, what: &str) -> Result<Option<i64>> {
        if number.is_real() {
            self.real(number, what).map(whole_of)
        } else {
            self.signed(number, what).map(Some)
        }
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
