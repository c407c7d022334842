//! Files of rows of numbers, whose first line gives the number of rows; `#` begins a comment.

use std::path::Path;

use super::bytes::{Bytes, shown};
use super::number::whole_of;
use crate::error::Result;

/// Lines of numbers without comments.
pub(super) struct Rows<'a> {
    pub(super) bytes: Bytes<'a>,
    words: Vec<&'a str>,
    at: usize,
}

impl<'a> Rows<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let mut bytes = Bytes::new(path, bytes, 0);
        bytes.lines = true;
        Self { bytes, words: Vec::new(), at: 0 }
    }

    /// Goes to the next line that is not blank.
    pub(super) fn next(&mut self, what: &str) -> Result<()> {
        loop {
            let Some(line) = self.bytes.text_line("#")? else {
                return Err(self.bytes.truncated(what));
            };
            let numbers = line.split('#').next().unwrap_or_default();
            (self.words, self.at) = (numbers.split_ascii_whitespace().collect(), 0);
            if !self.words.is_empty() {
                return Ok(());
            }
        }
    }

    pub(super) fn word(&mut self, what: &str) -> Result<&'a str> {
        let word = self.words.get(self.at).copied();
        self.at += 1;
        word.ok_or_else(|| {
            self.bytes.error(format!(
                "the line ends before {what}; it is cut off or a number in the first line is wrong: \
                 save or copy the mesh again"
            ))
        })
    }

    pub(super) fn whole(&mut self, what: &str) -> Result<u64> {
        let word = self.word(what)?;
        self.bytes.whole_of(word, what)
    }

    /// Reads a position in the file's unit, returned in metres.
    pub(super) fn position_m(&mut self, unit_m: f64) -> Result<[f64; 3]> {
        let mut position = [0.0; 3];
        for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
            let word = self.word(name)?;
            *value = self.bytes.metres_of(word, unit_m, name)?;
        }
        Ok(position)
    }

    /// Reads a whole number that may be missing in the first line; 0 then.
    pub(super) fn optional(&mut self, what: &str) -> Result<u64> {
        if self.at < self.words.len() { self.whole(what) } else { Ok(0) }
    }

    /// Refuses a line with further numbers.
    pub(super) fn end(&self) -> Result<()> {
        match self.words.get(self.at) {
            None => Ok(()),
            Some(word) => Err(self.bytes.error(format!(
                "the line goes on with '{}' after its last number; a number in the first line is \
                 wrong: save the mesh again",
                shown(word)
            ))),
        }
    }

    /// Refuses lines after the number that the first line gives.
    pub(super) fn end_of_file(mut self, what: &str) -> Result<()> {
        match self.bytes.text_line("#")? {
            None => Ok(()),
            Some(_) => Err(self.bytes.error(format!(
                "a line more than the number of {what} in the first line; save or copy the mesh again"
            ))),
        }
    }

    /// Skips `count` numbers.
    pub(super) fn skip(&mut self, count: u64, what: &str) -> Result<()> {
        for _ in 0..count {
            self.word(what)?;
        }
        Ok(())
    }

    /// Reads an attribute or a marker as a reference number; 0 if it is no whole number.
    pub(super) fn reference(&mut self, what: &str) -> Result<i64> {
        let word = self.word(what)?;
        let value = self.bytes.real_of(word, what)?;
        Ok(whole_of(value).unwrap_or(0))
    }
}
