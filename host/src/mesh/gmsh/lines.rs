//! Lines and fields of a text file; every error names file, line and field.

use std::borrow::Cow;
use std::path::Path;
use std::str::SplitAsciiWhitespace;

use super::source::{Place, Source};
use crate::error::{Error, Result};
use crate::mesh::bytes::{first_line, name_line, real_of, shown};

/// The lines of a file, counted from 1, and the section they are in.
pub(super) struct Lines<'a> {
    path: &'a Path,
    rest: &'a [u8],
    number: usize,
    section: &'a str,
}

impl<'a> Lines<'a> {
    /// Starts at the front of `rest`; `before` is the number of the file's lines before it.
    pub(super) fn new(path: &'a Path, rest: &'a [u8], before: usize) -> Self {
        Self { path, rest, number: before, section: "" }
    }

    /// Returns the bytes after the line read last.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Reads the next line; none at the end of the file.
    fn next_bytes(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let (line, length) = first_line(self.rest);
        self.rest = &self.rest[length..];
        Some(line)
    }

    /// Returns the line read last as text, trimmed.
    fn text(&self, line: &'a [u8]) -> Result<&'a str> {
        match std::str::from_utf8(line) {
            Ok(text) => Ok(text.trim()),
            Err(why) => Err(self.error(format!(
                "byte {} of the line is no UTF-8 text; the file is damaged or no Gmsh mesh: save it again",
                why.valid_up_to() + 1
            ))),
        }
    }

    /// Reads the next line, trimmed; none at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<&'a str>> {
        self.next_bytes().map(|line| self.text(line)).transpose()
    }

    /// Notes the section that begins here.
    pub(super) fn enter(&mut self, section: &'a str) {
        self.section = section;
    }

    /// Reads the next line of the section that is not blank; `what` describes it in errors.
    pub(super) fn record(&mut self, what: &'static str) -> Result<Fields<'a>> {
        let line = self.section_line(what, Self::text)?;
        Ok(self.fields(line))
    }

    /// As [`Self::record`] for a line with a name, in UTF-8 or Latin-1.
    pub(super) fn record_of_name(&mut self, what: &'static str) -> Result<Cow<'a, str>> {
        self.section_line(what, |_, line| Ok(name_line(line)))
    }

    /// Returns the fields of the line read last.
    pub(super) fn fields<'b>(&self, line: &'b str) -> Fields<'b>
    where
        'a: 'b,
    {
        Fields {
            path: self.path,
            line: self.number,
            section: self.section,
            words: line.split_ascii_whitespace(),
        }
    }

    fn section_line<T: AsRef<str>>(
        &mut self,
        what: &'static str,
        text: impl Fn(&Self, &'a [u8]) -> Result<T>,
    ) -> Result<T> {
        loop {
            let Some(line) = self.next_bytes() else { return Err(self.truncated(what)) };
            let line = text(self, line)?;
            match line.as_ref() {
                "" => {}
                text if text.starts_with('$') => {
                    return Err(self.error(format!(
                        "'{}' where {what} should be: section ${} has fewer lines than it says; \
                         save the mesh again",
                        shown(text),
                        shown(self.section)
                    )));
                }
                _ => return Ok(line),
            }
        }
    }

    /// Consumes the line that ends the section.
    pub(super) fn end(&mut self) -> Result<()> {
        loop {
            match self.next()? {
                None => return Err(self.truncated("its end")),
                Some("") => {}
                Some(line) if line.strip_prefix("$End") == Some(self.section) => return Ok(()),
                Some(line) => {
                    return Err(self.error(format!(
                        "'{}' where $End{} should be: the section has more lines than it says; \
                         save the mesh again",
                        shown(line),
                        shown(self.section)
                    )));
                }
            }
        }
    }

    /// Skips the section and the line that ends it.
    pub(super) fn skip_section(&mut self) -> Result<()> {
        // The skipped lines may be in any encoding.
        while let Some(line) = self.next_bytes() {
            if line.trim_ascii().strip_prefix(b"$End") == Some(self.section.as_bytes()) {
                return Ok(());
            }
        }
        Err(self.truncated("its end"))
    }

    fn truncated(&self, what: &str) -> Error {
        self.error(format!(
            "the file ends in section ${} before {what}; it is cut off: save or copy it again",
            shown(self.section)
        ))
    }

    /// Makes an error at the line read last.
    pub(super) fn error(&self, why: impl std::fmt::Display) -> Error {
        at(self.path, self.number, why)
    }

    /// Makes an error of the file as a whole.
    pub(super) fn error_of_file(&self, why: impl std::fmt::Display) -> Error {
        Error::input(format!("{}: {why}", self.path.display()))
    }
}

fn at(path: &Path, line: usize, why: impl std::fmt::Display) -> Error {
    Error::input(format!("{}:{line}: {why}", path.display()))
}

impl Place for Lines<'_> {
    fn refuse(&self, why: &str) -> Error {
        self.error(why)
    }
}

impl Place for Fields<'_> {
    fn refuse(&self, why: &str) -> Error {
        self.error(why)
    }
}

impl Source for Fields<'_> {
    fn node_tag(&mut self) -> Result<u64> {
        self.whole("node tag")
    }

    fn position_m(&mut self, unit_m: f64) -> Result<[f64; 3]> {
        let mut position = [0.0; 3];
        for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
            let word = self.word(name)?;
            *value = match real_of(word).map(|x| x * unit_m) {
                Some(x) if x.abs() <= f64::from(f32::MAX) => x,
                _ => {
                    return Err(self.error(format!(
                        "the {name} is '{}'; it must be a finite number of at most {:e} m: mend \
                         the node or check `unit_m`",
                        shown(word),
                        f32::MAX
                    )));
                }
            };
        }
        Ok(position)
    }
}

/// The fields of one line.
pub(super) struct Fields<'a> {
    path: &'a Path,
    line: usize,
    section: &'a str,
    words: SplitAsciiWhitespace<'a>,
}

impl<'a> Fields<'a> {
    /// Makes an error at this line.
    pub(super) fn error(&self, why: impl std::fmt::Display) -> Error {
        at(self.path, self.line, why)
    }

    /// Reads the next field, which `name` describes.
    pub(super) fn word(&mut self, name: &str) -> Result<&'a str> {
        self.words.next().ok_or_else(|| {
            self.error(format!(
                "the line ends before the {name} (section ${}); it is cut off or a count is wrong: \
                 save or copy the mesh again",
                shown(self.section)
            ))
        })
    }

    /// Refuses a line with further fields.
    pub(super) fn finish(mut self) -> Result<()> {
        match self.words.next() {
            None => Ok(()),
            Some(word) => Err(self.error(format!(
                "the line goes on with '{}' after its last field (section ${}); a count or a type \
                 is wrong: save the mesh again",
                shown(word),
                shown(self.section)
            ))),
        }
    }

    /// Reads a whole number that is not negative: a count, a type or a tag.
    pub(super) fn whole(&mut self, name: &str) -> Result<u64> {
        let word = self.word(name)?;
        word.parse().map_err(|_| {
            self.error(format!(
                "the {name} is '{}'; it must be a whole number from 0; save the mesh again",
                shown(word)
            ))
        })
    }

    /// Reads a whole number of either sign.
    pub(super) fn signed(&mut self, name: &str) -> Result<i64> {
        let word = self.word(name)?;
        word.parse().map_err(|_| {
            self.error(format!(
                "the {name} is '{}'; it must be a whole number; save the mesh again",
                shown(word)
            ))
        })
    }

    /// Reads the rest of the line between double quotes; the text after the second one is a remark.
    pub(super) fn quoted(self, name: &str) -> Result<String> {
        let rest: Vec<&str> = self.words.clone().collect();
        let text = rest.join(" ");
        let inner = text.strip_prefix('"').and_then(|text| text.split_once('"'));
        inner.map(|(inner, _)| inner.to_string()).ok_or_else(|| {
            self.error(format!("the {name} is '{}'; put it between double quotes", shown(&text)))
        })
    }
}
