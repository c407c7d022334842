//! The numbers of a file: fields of lines in text, or binary numbers. Every error names the file, the line or
//! byte, and the section.

use std::borrow::Cow;
use std::str::SplitAsciiWhitespace;

use crate::error::{Error, Result};
use crate::mesh::bytes::{Bytes, name_line, shown};

/// The words of an error for a count or an id.
const WHOLE: &str = "a whole number from 0";

/// A file and the section it is in.
pub(super) struct File<'a> {
    pub(super) bytes: Bytes<'a>,
    /// True if numbers are binary; names and the counts of format 2.2 are text in such files too.
    pub(super) is_binary: bool,
    section: &'a str,
    /// Fields of the current line that have not been read.
    words: SplitAsciiWhitespace<'a>,
}

impl<'a> File<'a> {
    pub(super) fn new(mut bytes: Bytes<'a>) -> Self {
        bytes.lines = true;
        Self { bytes, is_binary: false, section: "", words: "".split_ascii_whitespace() }
    }

    /// Goes to the next section and returns its name; none at the end of the file. Text between sections is
    /// skipped.
    pub(super) fn next_section(&mut self) -> Result<Option<&'a str>> {
        while let Some(line) = self.bytes.line() {
            let line = line.trim_ascii();
            if !line.starts_with(b"$") {
                continue;
            }
            let Ok(line) = std::str::from_utf8(line) else {
                return Err(self
                    .bytes
                    .error(format!("a section without a readable name; {}", super::SAVE)));
            };
            self.bytes.enter(line);
            self.section = line.trim_start_matches('$');
            return Ok(Some(self.section));
        }
        Ok(None)
    }

    /// Reads the number 1 that shows the byte order; all numbers from here on are binary.
    pub(super) fn begin_binary(&mut self) -> Result<()> {
        (self.is_binary, self.bytes.lines) = (true, false);
        match self.bytes.take("the number 1 that tells the byte order")? {
            [1, 0, 0, 0] => {}
            [0, 0, 0, 1] => self.bytes.little = false,
            other => {
                return Err(self.bytes.error(format!(
                    "the bytes {other:?} where the number 1 should tell the byte order; the file was changed \
                     on its way, as by a transfer in text mode: copy it again"
                )));
            }
        }
        Ok(())
    }

    /// Reads the line that ends the section.
    pub(super) fn end(&mut self) -> Result<()> {
        loop {
            let Some(line) = self.bytes.line() else { return Err(self.bytes.truncated("its end")) };
            let text = String::from_utf8_lossy(line.trim_ascii());
            if text.strip_prefix("$End") == Some(self.section) {
                return Ok(());
            }
            if !text.is_empty() {
                return Err(self.bytes.error(format!(
                    "'{}' where $End{} should be: the section has more than it says; save or copy the mesh \
                     again",
                    shown(&text),
                    shown(self.section)
                )));
            }
        }
    }

    /// Skips the section, which may be in any encoding and coding, and the line that ends it.
    pub(super) fn skip_section(&mut self) -> Result<()> {
        let end = ["$End", self.section].concat();
        loop {
            let mut places = self.bytes.rest().windows(end.len());
            let Some(at) = places.position(|bytes| bytes == end.as_bytes()) else {
                return Err(self.bytes.truncated("its end"));
            };
            self.bytes.skip(at);
            if self.bytes.line().is_some_and(|line| line.trim_ascii() == end.as_bytes()) {
                return Ok(());
            }
        }
    }

    /// Reads the next line of the section that is not blank; `what` describes it in errors.
    fn line(&mut self, what: &str) -> Result<&'a [u8]> {
        loop {
            let Some(line) = self.bytes.line() else { return Err(self.bytes.truncated(what)) };
            match line.trim_ascii() {
                [] => {}
                [b'$', ..] => {
                    return Err(self.bytes.error(format!(
                        "'{}' where {what} should be: section ${} has fewer lines than it says; save the mesh \
                         again",
                        shown(&name_line(line)),
                        shown(self.section)
                    )));
                }
                _ => return Ok(line),
            }
        }
    }

    /// Reads the next line with a name, in UTF-8 or Latin-1.
    pub(super) fn name_line(&mut self, what: &str) -> Result<Cow<'a, str>> {
        self.line(what).map(name_line)
    }

    /// Goes to the next line of text, whose fields follow.
    pub(super) fn text_record(&mut self, what: &str) -> Result<()> {
        let line = self.line(what)?;
        self.words = self.bytes.text_of(line)?.split_ascii_whitespace();
        Ok(())
    }

    /// As [`Self::text_record`]; binary records follow each other without lines.
    pub(super) fn record(&mut self, what: &str) -> Result<()> {
        if self.is_binary { Ok(()) } else { self.text_record(what) }
    }

    /// Refuses a line of text with further fields.
    pub(super) fn end_of_record(&mut self) -> Result<()> {
        match self.words.next().filter(|_| !self.is_binary) {
            None => Ok(()),
            Some(word) => Err(self.bytes.error(format!(
                "the line goes on with '{}' after its last field (section ${}); a count or a type is wrong: \
                 save the mesh again",
                shown(word),
                shown(self.section)
            ))),
        }
    }

    /// Reads the next field of a line of text.
    pub(super) fn word(&mut self, what: &str) -> Result<&'a str> {
        self.words.next().ok_or_else(|| {
            self.bytes.error(format!(
                "the line ends before {what} (section ${}); it is cut off or a count is wrong: save or copy \
                 the mesh again",
                shown(self.section)
            ))
        })
    }

    /// Reads a number from 0, of 32 bits in binary files: a type, a dimension or a tag.
    pub(super) fn whole(&mut self, what: &str) -> Result<u64> {
        if self.is_binary {
            let value = self.bytes.i32(what)?;
            return u64::try_from(value)
                .map_err(|_| self.bytes.no_number(what, &value.to_string(), WHOLE));
        }
        self.text_whole(what)
    }

    /// Reads a number from 0, of 64 bits in binary files.
    pub(super) fn long(&mut self, what: &str) -> Result<u64> {
        if self.is_binary { self.bytes.u64(what) } else { self.text_whole(what) }
    }

    /// Reads a number from 0 of a line of text.
    pub(super) fn text_whole(&mut self, what: &str) -> Result<u64> {
        let word = self.word(what)?;
        self.bytes.whole_of(word, what)
    }

    /// Reads a line of text with a count.
    pub(super) fn count(&mut self, what: &str) -> Result<u64> {
        self.text_record(what)?;
        self.text_whole(what)
    }

    /// Reads a number of either sign, of 32 bits in binary files.
    pub(super) fn signed(&mut self, what: &str) -> Result<i64> {
        if self.is_binary {
            return self.bytes.i32(what).map(i64::from);
        }
        let word = self.word(what)?;
        self.bytes.signed_of(word, what)
    }

    /// Skips real numbers.
    pub(super) fn skip_reals(&mut self, count: u64, what: &str) -> Result<()> {
        for _ in 0..count {
            if self.is_binary {
                self.bytes.f64(what)?;
            } else {
                self.word(what)?;
            }
        }
        Ok(())
    }

    /// Reads a position in the file's unit, returned in metres.
    pub(super) fn position_m(&mut self, unit_m: f64) -> Result<[f64; 3]> {
        let mut position = [0.0; 3];
        for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
            *value = if self.is_binary {
                let coordinate = self.bytes.f64(name)?;
                self.bytes.metres(coordinate, unit_m, name)?
            } else {
                let word = self.word(name)?;
                self.bytes.metres_of(word, unit_m, name)?
            };
        }
        Ok(position)
    }

    /// Refuses a count of binary items that the rest of the file cannot hold; text ends with its lines.
    pub(super) fn fits(&self, count: u64, bytes_each: u64, what: &str) -> Result<()> {
        if self.is_binary { self.bytes.fits(count, bytes_each, what) } else { Ok(()) }
    }

    /// Makes an error at the item read last.
    pub(super) fn refuse(&self, why: &str) -> Error {
        self.bytes.error(why)
    }
}
