//! Files that go in and come out: models, paths, tables.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::{Ended, run};

/// A folder that goes away with the test.
#[must_use]
pub fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// A path as an argument.
#[must_use]
pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Everything below a folder, with the files' contents: what must be the same when nothing may
/// change.
#[must_use]
pub fn content(folder: &Path) -> BTreeSet<(PathBuf, Vec<u8>)> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(content(&path));
            found.insert((path, Vec::new()));
        } else {
            let bytes = if path.is_file() { std::fs::read(&path).unwrap() } else { Vec::new() };
            found.insert((path, bytes));
        }
    }
    found
}

/// Names of what lies in a folder, sorted.
#[must_use]
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Bakes a model into `folder`.
#[track_caller]
pub fn bake(folder: &Path, spec: &str, options: &[&str]) -> PathBuf {
    let model = folder.join("model.chaincell");
    run([&["bake", spec, "-o", text(&model)], options].concat()).with(0);
    model
}

/// Plays a path with a model, results into `out`.
#[track_caller]
pub fn play(model: &Path, path: &Path, out: &Path, options: &[&str]) -> Ended {
    let args = ["run", text(model), "--path", text(path), "--out", text(out)];
    run([&args, options].concat())
}

/// Numbers of a named array of a VTU file.
pub fn array(vtu: &str, name: &str) -> Vec<f64> {
    let start = vtu.find(&format!("Name=\"{name}\"")).unwrap();
    let body = &vtu[start..];
    let body = &body[body.find('>').unwrap() + 1..body.find("</DataArray>").unwrap()];
    body.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

/// One row of a path: tick, position \[m\], engaged.
pub type Row = (u64, [f32; 3], u32);

/// Writes a path file.
pub fn write_path(file: &Path, rows: impl IntoIterator<Item = Row>) {
    let mut text = String::from("tick,x_m,y_m,z_m,engaged\n");
    for (tick, [x, y, z], engaged) in rows {
        let _ = writeln!(text, "{tick},{x:?},{y:?},{z:?},{engaged}");
    }
    std::fs::write(file, text).unwrap();
}

/// A comma-separated table of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// First line.
    pub header: String,
    /// The others.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Reads a table whose every line is whole.
    #[track_caller]
    #[must_use]
    pub fn read(file: &Path) -> Self {
        let text = std::fs::read_to_string(file).unwrap();
        assert!(text.ends_with('\n'), "{} breaks off", file.display());
        let mut lines = text.lines();
        let header = lines.next().unwrap().to_owned();
        let columns = header.split(',').count();
        let rows: Vec<Vec<f64>> =
            lines.map(|row| row.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        assert!(rows.iter().all(|row| row.len() == columns), "{}", file.display());
        Self { header, rows }
    }

    /// A column by name.
    #[track_caller]
    #[must_use]
    pub fn column(&self, name: &str) -> Vec<f64> {
        let at = self.header.split(',').position(|column| column == name).unwrap();
        self.rows.iter().map(|row| row[at]).collect()
    }

    /// A column of whole numbers.
    #[track_caller]
    #[must_use]
    pub fn whole(&self, name: &str) -> Vec<u64> {
        self.column(name).into_iter().map(|x| x as u64).collect()
    }

    /// Three columns from `first` on.
    #[track_caller]
    #[must_use]
    pub fn vectors(&self, first: &str) -> Vec<[f64; 3]> {
        let at = self.header.split(',').position(|column| column == first).unwrap();
        self.rows.iter().map(|row| [row[at], row[at + 1], row[at + 2]]).collect()
    }
}

/// summary.json of a folder.
#[track_caller]
#[must_use]
pub fn summary(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Whether a text is a state hash: 16 lower-case hexadecimal digits.
#[must_use]
pub fn is_hash(value: &serde_json::Value) -> bool {
    let digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
    value.as_str().is_some_and(|hash| hash.len() == 16 && hash.bytes().all(digit))
}
