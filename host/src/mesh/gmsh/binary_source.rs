//! Numbers and lines of a binary file.

use super::Version;
use super::source::{Place, Source};
use crate::error::{Error, Result};
use crate::mesh::bytes::{Bytes, shown};

/// A binary file and the width of its node tags.
pub(super) struct Binary<'a> {
    pub(super) bytes: Bytes<'a>,
    pub(super) version: Version,
}

impl Place for Binary<'_> {
    fn refuse(&self, why: &str) -> Error {
        self.bytes.error(why)
    }
}

impl Source for Binary<'_> {
    fn node_tag(&mut self) -> Result<u64> {
        match self.version {
            Version::V2 => self.whole("node tag"),
            Version::V4 => self.bytes.u64("a node tag"),
        }
    }

    fn position_m(&mut self, unit_m: f64) -> Result<[f64; 3]> {
        let mut position = [0.0; 3];
        for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
            let coordinate = self.bytes.f64(name)?;
            *value = self.bytes.metres(coordinate, unit_m, name)?;
        }
        Ok(position)
    }
}

impl Binary<'_> {
    /// Reads a number of 32 bits that is not negative: a count, a type or a tag.
    pub(super) fn whole(&mut self, name: &str) -> Result<u64> {
        let value = self.bytes.i32(name)?;
        u64::try_from(value).map_err(|_| {
            self.bytes.error(format!(
                "the {name} is {value}; it must be a whole number from 0; save the mesh again"
            ))
        })
    }

    /// Reads the whole number of a line of text.
    pub(super) fn count_line(&mut self, name: &str) -> Result<u64> {
        let Some(line) = self.bytes.line() else { return Err(self.bytes.truncated(name)) };
        let text = String::from_utf8_lossy(line);
        text.trim().parse().map_err(|_| {
            self.bytes.error(format!(
                "the {name} is '{}'; it must be a whole number from 0; save the mesh again",
                shown(&text)
            ))
        })
    }

    /// Reads the number 1, which shows the byte order.
    pub(super) fn probe(&mut self) -> Result<()> {
        match self.bytes.take("the number 1 that tells the byte order")? {
            [1, 0, 0, 0] => Ok(()),
            [0, 0, 0, 1] => {
                self.bytes.little = false;
                Ok(())
            }
            other => Err(self.bytes.error(format!(
                "the bytes {other:?} where the number 1 should tell the byte order; the file was \
                 changed on its way, as by a transfer in text mode: copy it again"
            ))),
        }
    }

    /// Reads the line that ends a section.
    pub(super) fn end(&mut self, section: &str) -> Result<()> {
        self.bytes.skip_blank();
        let Some(line) = self.bytes.line() else { return Err(self.bytes.truncated("its end")) };
        let text = String::from_utf8_lossy(line);
        if text.trim().strip_prefix("$End") == Some(section) {
            return Ok(());
        }
        Err(self.bytes.error(format!(
            "'{}' where $End{} should be: the section has another length than it says; save or \
             copy the mesh again",
            shown(&text),
            shown(section)
        )))
    }

    /// Skips a section of unknown length up to the text that ends it.
    pub(super) fn skip_section(&mut self, section: &str) -> Result<()> {
        let end = [b"$End", section.as_bytes()].concat();
        match self.bytes.rest().windows(end.len()).position(|bytes| bytes == end) {
            Some(at) => {
                self.bytes.skip(at);
                self.end(section)
            }
            None => Err(self.bytes.truncated("its end")),
        }
    }
}
