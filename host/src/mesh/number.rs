//! Types of numbers in binary files; each format has its own names for them.

use super::bytes::Bytes;
use crate::error::Result;

/// Type of an array's numbers.
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
    /// Returns the size of a number \[bytes\].
    pub(super) fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Returns true if it is a real number.
    pub(super) fn is_real(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Reads the next number of a file as a real one; `what` describes it in errors.
    pub(super) fn real(self, bytes: &mut Bytes, what: &str) -> Result<f64> {
        Ok(match self {
            Self::I8 => i8::from_le_bytes(bytes.take(what)?).into(),
            Self::U8 => u8::from_le_bytes(bytes.take(what)?).into(),
            Self::I16 => i16::from_le_bytes(bytes.take(what)?).into(),
            Self::U16 => u16::from_le_bytes(bytes.take(what)?).into(),
            Self::I32 => bytes.i32(what)?.into(),
            Self::U32 => u32::from_le_bytes(bytes.take(what)?).into(),
            Self::I64 => bytes.i64(what)? as f64,
            Self::U64 => bytes.u64(what)? as f64,
            Self::F32 => bytes.f32(what)?.into(),
            Self::F64 => bytes.f64(what)?,
        })
    }

    /// Reads the next number of a file as a whole one of either sign; none if it has a fraction.
    pub(super) fn whole(self, bytes: &mut Bytes, what: &str) -> Result<Option<i64>> {
        match self {
            Self::I64 => bytes.i64(what).map(Some),
            Self::U64 => {
                let value = bytes.u64(what)?;
                i64::try_from(value).map(Some).map_err(|_| {
                    bytes.no_number(what, &value.to_string(), "at most 9223372036854775807")
                })
            }
            _ => self.real(bytes, what).map(whole_of),
        }
    }
}

/// Converts a real number to a whole one; none if it has a fraction, or is too large to have one.
pub(super) fn whole_of(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() < 1e15).then_some(value as i64)
}
