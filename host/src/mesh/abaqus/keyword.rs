//! Keyword lines: `*NAME, PARAMETER=VALUE, PARAMETER`, in letters of either case.

use super::COMMENT;
use crate::error::Result;
use crate::mesh::bytes::{Bytes, name_line, shown};

/// A keyword with its parameters.
pub(super) struct Keyword {
    /// In upper case, without the star.
    pub(super) name: String,
    /// Names in upper case; values as they are, without quotes.
    parameters: Vec<(String, String)>,
}

impl Keyword {
    /// Reads the keyword of a line; a line that ends in a comma continues in the next.
    pub(super) fn read(line: &str, bytes: &mut Bytes) -> Result<Self> {
        let item = bytes.item();
        let mut text = line.to_string();
        while text.ends_with(',') {
            match bytes.raw_line(COMMENT).map(name_line) {
                Some(next) if !next.starts_with('*') => text.push_str(&next),
                _ => return Err(bytes.truncated("the rest of a keyword line that ends in a comma")),
            }
        }
        bytes.return_to(item);
        let mut quoted = false;
        let mut parts = text.trim_start_matches('*').split(|letter| {
            quoted ^= letter == '"';
            letter == ',' && !quoted
        });
        let upper = |text: &str| {
            text.split_ascii_whitespace().collect::<Vec<_>>().join(" ").to_ascii_uppercase()
        };
        let name = upper(parts.next().unwrap_or_default());
        let parameters = parts.map(|part| {
            let (name, value) = part.split_once('=').unwrap_or((part, ""));
            (upper(name), value.trim().trim_matches('"').to_string())
        });
        Ok(Self { name, parameters: parameters.collect() })
    }

    /// Returns true if there is a parameter of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.parameters.iter().any(|(own, _)| own == name)
    }

    /// Returns the value of a parameter, if it has one.
    pub(super) fn value(&self, name: &str) -> Option<String> {
        let found = self.parameters.iter().find(|(own, value)| own == name && !value.is_empty());
        found.map(|(_, value)| value.clone())
    }

    /// Returns the value of a required parameter.
    pub(super) fn needed(&self, name: &str, bytes: &Bytes) -> Result<String> {
        self.value(name).ok_or_else(|| {
            bytes.error(format!(
                "*{} without {name}=; the line is damaged: save the mesh again",
                shown(&self.name)
            ))
        })
    }
}

/// Returns the fields of a data line, trimmed.
pub(super) fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(str::trim)
}
