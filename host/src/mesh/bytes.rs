//! Reads a file byte by byte: lines and words of text, and binary numbers of either byte order;
//! every error names the file, the byte or line, and the part of the file.

use std::borrow::Cow;
use std::fmt::Display;
use std::path::Path;

use crate::error::{Error, Result};

/// Most bytes of a text that an error shows.
const SHOWN: usize = 40;

/// A position in a file that has been read into memory. Nothing is copied.
pub(super) struct Bytes<'a> {
    path: &'a Path,
    all: &'a [u8],
    at: usize,
    /// Begin of the item read last: the position that errors name.
    item: usize,
    part: &'a str,
    /// True if binary numbers have their lowest byte first.
    pub(super) little: bool,
    /// True if errors count lines instead of bytes.
    pub(super) lines: bool,
}

/// Text as an error shows it.
pub(super) fn shown(text: &str) -> String {
    text.chars().take(SHOWN).flat_map(char::escape_default).collect()
}

/// Returns the first line of a text without its end, and its length with it. A line ends with a line
/// feed, a carriage return, or both in a row.
pub(super) fn first_line(text: &[u8]) -> (&[u8], usize) {
    let end = text.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(text.len());
    let (line, rest) = text.split_at(end);
    let ends = match rest {
        [] => 0,
        [b'\r', b'\n', ..] => 2,
        _ => 1,
    };
    (line, end + ends)
}

/// Parses a word as a real number; the exponent may begin with Fortran's `D`.
pub(super) fn real_of(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| {
        let (front, exponent) = word.split_once(['d', 'D'])?;
        let is_number = front.ends_with(|last: char| last.is_ascii_digit() || last == '.');
        if is_number { format!("{front}e{exponent}").parse().ok() } else { None }
    })
}

/// Returns a line with names as text, trimmed: UTF-8, else Latin-1, which older programs write.
pub(super) fn name_line(line: &[u8]) -> Cow<'_, str> {
    let line = line.trim_ascii();
    match std::str::from_utf8(line) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => line.iter().map(|byte| char::from(*byte)).collect::<String>().into(),
    }
}

impl<'a> Bytes<'a> {
    pub(super) fn new(path: &'a Path, all: &'a [u8], at: usize) -> Self {
        let at = at.min(all.len());
        Self { path, all, at, item: at, part: "the file", little: true, lines: false }
    }

    /// Returns other bytes of the same file, as decoded from a part of it.
    pub(super) fn part<'b>(&'b self, all: &'b [u8], little: bool) -> Bytes<'b> {
        Bytes { little, ..Bytes::new(self.path, all, 0) }
    }

    /// Returns the bytes that have not been read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.all.get(self.at..).unwrap_or_default()
    }

    /// Skips bytes, at most to the file's end.
    pub(super) fn skip(&mut self, count: usize) {
        self.at = self.at.saturating_add(count).min(self.all.len());
    }

    /// Notes the part of the file that begins here, for errors.
    pub(super) fn enter(&mut self, part: &'a str) {
        self.part = part;
    }

    /// Makes an error at the item read last.
    pub(super) fn error(&self, why: impl Display) -> Error {
        let path = self.path.display();
        if self.lines {
            Error::input(format!("{path}:{}: {why}", line_number(self.all, self.item)))
        } else {
            Error::input(format!("{path}: byte {}: {why}", self.item))
        }
    }

    /// Makes an error of the file as a whole.
    pub(super) fn error_of_file(&self, why: impl Display) -> Error {
        Error::input(format!("{}: {why}", self.path.display()))
    }

    /// Makes the error that the file ends before `what`.
    pub(super) fn truncated(&mut self, what: impl Display) -> Error {
        self.item = self.all.len();
        self.error(format!(
            "the file ends in {} before {what}; it is cut off: save or copy it again",
            shown(self.part)
        ))
    }

    /// Refuses a count whose items the rest of the file cannot hold, before any is read.
    pub(super) fn fits(&self, count: u64, bytes_each: u64, what: &str) -> Result<()> {
        let left = self.rest().len() as u64;
        if count.checked_mul(bytes_each).is_some_and(|bytes| bytes <= left) {
            return Ok(());
        }
        Err(self.error(format!(
            "{count} {what} of at least {bytes_each} bytes each where {left} bytes are left; the \
             file is cut off or the count is wrong: save or copy it again"
        )))
    }

    /// Reads the next bytes of a binary item.
    pub(super) fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        let Some(bytes) = self.rest().first_chunk::<N>() else {
            return Err(self.truncated(what));
        };
        self.item = self.at;
        self.at += N;
        let mut bytes = *bytes;
        if !self.little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    pub(super) fn i32(&mut self, what: &str) -> Result<i32> {
        self.take(what).map(i32::from_le_bytes)
    }

    pub(super) fn i64(&mut self, what: &str) -> Result<i64> {
        self.take(what).map(i64::from_le_bytes)
    }

    pub(super) fn u64(&mut self, what: &str) -> Result<u64> {
        self.take(what).map(u64::from_le_bytes)
    }

    pub(super) fn f32(&mut self, what: &str) -> Result<f32> {
        self.take(what).map(f32::from_le_bytes)
    }

    pub(super) fn f64(&mut self, what: &str) -> Result<f64> {
        self.take(what).map(f64::from_le_bytes)
    }

    /// Reads the next line without its end; none at the end of the file.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        self.item = self.at;
        let (line, length) = first_line(rest);
        self.skip(length);
        Some(line)
    }

    /// Reads the next line that is neither blank nor begins with `comment`; none at the end of the file.
    pub(super) fn raw_line(&mut self, comment: &str) -> Option<&'a [u8]> {
        loop {
            let line = self.line()?;
            let text = line.trim_ascii_start();
            // Comments may be in any encoding.
            if !(text.is_empty() || text.starts_with(comment.as_bytes())) {
                return Some(line);
            }
        }
    }

    /// Returns the line read last as text, trimmed.
    pub(super) fn text_of(&self, line: &'a [u8]) -> Result<&'a str> {
        let text = std::str::from_utf8(line).map_err(|why| {
            self.error(format!(
                "byte {} of the line is no UTF-8 text; the file is binary or damaged: save the mesh \
                 again as text",
                why.valid_up_to() + 1
            ))
        })?;
        Ok(text.trim())
    }

    /// Reads the next line of text that is neither blank nor begins with `comment`, trimmed; none at the end
    /// of the file.
    pub(super) fn text_line(&mut self, comment: &str) -> Result<Option<&'a str>> {
        while let Some(line) = self.raw_line(comment) {
            let text = self.text_of(line)?;
            if !text.is_empty() {
                return Ok(Some(text));
            }
        }
        Ok(None)
    }

    /// Returns the begin of the item read last, for [`Bytes::return_to`].
    pub(super) fn item(&self) -> usize {
        self.item
    }

    /// Errors name this item from now on.
    pub(super) fn return_to(&mut self, item: usize) {
        self.item = item;
    }

    /// Parses a word as a whole number from 0; `what` describes it in errors.
    pub(super) fn whole_of(&self, word: &str, what: &str) -> Result<u64> {
        word.parse().map_err(|_| self.no_number(what, word, "a whole number from 0"))
    }

    /// Parses a word as a whole number of either sign.
    pub(super) fn signed_of(&self, word: &str, what: &str) -> Result<i64> {
        word.parse().map_err(|_| self.no_number(what, word, "a whole number"))
    }

    /// Parses a word as a coordinate in the file's unit, returned in metres; `name` is its axis.
    pub(super) fn metres_of(&self, word: &str, unit_m: f64, name: &str) -> Result<f64> {
        self.metres(self.real_of(word, name)?, unit_m, name)
    }

    /// Parses a word as a real number; `what` describes it in errors.
    pub(super) fn real_of(&self, word: &str, what: &str) -> Result<f64> {
        real_of(word).ok_or_else(|| self.no_number(what, word, "a number"))
    }

    /// Makes the error that a word is not the number wanted.
    pub(super) fn no_number(&self, what: &str, word: &str, wanted: &str) -> Error {
        let is_comma = |(front, back): (&str, &str)| real_of(&format!("{front}.{back}")).is_some();
        let remedy = if word.split_once(',').is_some_and(is_comma) {
            "save the mesh with a point in front of decimals, not a comma"
        } else {
            "save or copy the mesh again"
        };
        self.error(format!("{what} is '{}'; it must be {wanted}: {remedy}", shown(word)))
    }

    /// Reads the next word of text; none at the end of the file.
    pub(super) fn word(&mut self) -> Option<&'a str> {
        self.skip_blank();
        let rest = self.rest();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.item = self.at;
        self.skip(end);
        // A word that is no text becomes "?", which matches no keyword.
        (end > 0).then(|| std::str::from_utf8(&rest[..end]).unwrap_or("?"))
    }

    /// Returns the next word without reading it.
    pub(super) fn peek(&self) -> Option<&'a str> {
        let rest = self.rest().trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        std::str::from_utf8(&rest[..end]).ok()
    }

    /// Skips the rest of the line, which may be empty.
    pub(super) fn rest_of_line(&mut self) {
        self.skip(first_line(self.rest()).0.len());
    }

    /// Skips blanks and ends of lines.
    pub(super) fn skip_blank(&mut self) {
        let rest = self.rest();
        self.skip(rest.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(rest.len()));
    }

    /// Converts a coordinate from the file's unit to metres; `name` is its axis.
    pub(super) fn metres(&self, value: f64, unit_m: f64, name: &str) -> Result<f64> {
        let metres = value * unit_m;
        if metres.abs() <= f64::from(f32::MAX) {
            return Ok(metres);
        }
        Err(self.error(format!(
            "the {name} is {value:?}; it must be a finite number of at most {:e} m: mend the node or \
             check `unit_m`",
            f32::MAX
        )))
    }
}

fn line_number(all: &[u8], at: usize) -> usize {
    let front = all.get(..at).unwrap_or(all);
    let is_end = |at: usize| match front[at] {
        b'\n' => true,
        b'\r' => all.get(at + 1) != Some(&b'\n'),
        _ => false,
    };
    1 + (0..front.len()).filter(|&at| is_end(at)).count()
}
