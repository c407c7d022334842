//! The tables of the reference folder.

use std::path::Path;

use chaincell_host::error::{Error, Result};

/// Largest file that is read \[bytes\].
const BYTES_MAX: u64 = 16 << 20;

/// A row: its words, and how errors name it.
pub struct Row {
    place: String,
    words: Vec<String>,
}

impl Row {
    /// A word.
    pub fn word(&self, at: usize) -> &str {
        self.words.get(at).map_or("", String::as_str)
    }

    /// A number.
    pub fn number(&self, at: usize) -> Result<f64> {
        let number = self.word(at).parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| {
            Error::input(format!(
                "{}: `{}` is no number; restore the file",
                self.place,
                self.word(at)
            ))
        })
    }
}

/// The rows below a header; none where there is no such file.
///
/// # Errors
/// A file that cannot be read, another header, a row of another length.
pub fn table(reference: &Path, file: &str, header: &str) -> Result<Option<Vec<Row>>> {
    let path = reference.join(file);
    if !path.exists() {
        return Ok(None);
    }
    let text = chaincell_host::text::read(&path, BYTES_MAX)
        .map_err(|why| Error::file("read", &path, why))?;
    let place = |line: usize| format!("{}:{line}", path.display());
    let first = text.lines().next().unwrap_or_default().trim();
    if first != header {
        return Err(Error::input(format!("{}: the header must be `{header}`", place(1))));
    }
    let width = header.split(',').count();
    let lines = (1..).zip(text.lines()).skip(1).filter(|(_, line)| !line.trim().is_empty());
    let rows = lines.map(|(line, text)| {
        let words: Vec<String> = text.split(',').map(|word| word.trim().to_owned()).collect();
        if words.len() == width {
            return Ok(Row { place: place(line), words });
        }
        Err(Error::input(format!("{}: {} fields, not {width}", place(line), words.len())))
    });
    rows.collect::<Result<Vec<Row>>>().map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_and_bad_ones_named() {
        let folder = tempfile::tempdir().unwrap();
        let found = |text: &str| {
            std::fs::write(folder.path().join("a.csv"), text).unwrap();
            table(folder.path(), "a.csv", "x,y")
        };
        let rows = found("x,y\nT,2.5\n\nS,x\n").unwrap().unwrap();
        assert_eq!((rows.len(), rows[0].word(0), rows[0].number(1).unwrap()), (2, "T", 2.5));
        let named = |why: Error, part: &str| assert!(why.to_string().contains(part), "{why}");
        named(rows[1].number(1).unwrap_err(), "a.csv:4: `x` is no number");
        named(found("x,z\n1,2\n").err().unwrap(), "a.csv:1: the header must be `x,y`");
        named(found("x,y\n1\n").err().unwrap(), "a.csv:2: 1 fields, not 2");
        assert!(table(folder.path(), "b.csv", "x,y").unwrap().is_none());
    }
}
