//! The list of a batch: a file with one JSON object a line, each a job.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Component, Path, PathBuf};

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::Value;

use crate::error::{Error, Result};
use crate::text;

/// Largest list that is read, in bytes: a million jobs.
const BYTES_MAX: u64 = 256 << 20;
/// Keys whose files or folders a job writes; no two jobs share one.
const WRITTEN: [&str; 3] = ["out", "trace", "picture"];

/// The options of a job, in the order and as often as they were given.
pub type Options = Vec<(String, Value)>;

/// A job of the list.
#[derive(Debug)]
pub struct Listed {
    /// Number of its line, from 1.
    pub line: u64,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Its options, or why it is no job, with the remedy.
    pub options: std::result::Result<Options, String>,
}

/// All jobs.
#[derive(Debug)]
pub struct List {
    /// The file, for messages.
    pub name: String,
    /// The folder from which paths in it count.
    pub base: PathBuf,
    pub jobs: Vec<Listed>,
}

impl List {
    /// Reads a list, `-` for standard input; empty lines are passed over.
    ///
    /// # Errors
    /// A file that cannot be read, or is no list of lines. A line that is no job stands in the list with the reason.
    pub fn read(path: &Path) -> Result<Self> {
        let (name, text) = if path == Path::new("-") {
            ("standard input".to_owned(), text::of(std::io::stdin().lock(), BYTES_MAX))
        } else {
            (path.display().to_string(), text::read(path, BYTES_MAX))
        };
        let text = text.map_err(|why| {
            let remedy = "give a file with one JSON object a line, or - for standard input";
            Error::input(format!("--batch {name}: {why}; {remedy}"))
        })?;
        if text.trim_start().starts_with('[') {
            return Err(Error::input(format!(
                "{name}: it is a JSON array: give one JSON object a line, as `jq -c '.[]'` writes them"
            )));
        }
        // A pipe has no folder.
        let folder = path.parent().filter(|_| !path.starts_with("/dev"));
        let base = folder.unwrap_or(Path::new("")).to_owned();
        let mut taken = Taken { base: &base, names: BTreeMap::new(), places: BTreeMap::new() };
        let lines = (1..).zip(text.lines()).filter(|(_, text)| !text.trim().is_empty());
        let jobs = lines.map(|(line, text)| taken.job(line, text)).collect();
        Ok(Self { name, base, jobs })
    }
}

/// Names and places that earlier lines have taken, each with the line.
struct Taken<'a> {
    base: &'a Path,
    names: BTreeMap<String, u64>,
    places: BTreeMap<PathBuf, u64>,
}

impl Taken<'_> {
    fn job(&mut self, line: u64, text: &str) -> Listed {
        let mut listed = Listed { line, name: None, options: Ok(Vec::new()) };
        listed.options = self.options(text, &mut listed);
        listed
    }

    /// The options of a line, whose name goes into `job`.
    fn options(&mut self, text: &str, job: &mut Listed) -> std::result::Result<Options, String> {
        // Read the line.
        let Pairs(mut options) = serde_json::from_str(text).map_err(|why| {
            // It counts the lines of this text, which is one.
            let why = why.to_string().replace(" at line 1 column", " at column");
            format!(
                "no JSON object: {why}: give each job a line of its own, such as \
                 {{\"model\":\"liver.chaincell\",\"path\":\"press.csv\"}}"
            )
        })?;
        // Take out the name.
        for (_, name) in options.extract_if(.., |(key, _)| key == "name") {
            match name {
                Value::String(name) if job.name.is_none() && !name.is_empty() => {
                    job.name = Some(name);
                }
                _ => return Err("`name`: give one text".into()),
            }
        }
        if let Some(name) = &job.name
            && let Some(earlier) = self.names.get(name)
        {
            return Err(format!("`name` {name}: line {earlier} has it: give each job its own"));
        }
        self.names.extend(job.name.iter().map(|name| (name.clone(), job.line)));
        // Refuse to write where an earlier job writes.
        for (key, value) in &options {
            let place = text_of(value).filter(|_| WRITTEN.contains(&key.as_str()));
            let Some(place) = place else { continue };
            let path = plain(&std::path::absolute(self.base.join(&place)).unwrap_or_default());
            match self.places.get(&path) {
                _ if key == "picture" && place == "off" => {}
                Some(earlier) if *earlier != job.line => {
                    return Err(format!(
                        "`{key}` {place}: line {earlier} writes there: name another place"
                    ));
                }
                _ => _ = self.places.insert(path, job.line),
            }
        }
        Ok(options)
    }
}

/// The text of a value that stands for one word.
pub fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// A path without its steps up, which are taken by name.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => _ = plain.pop(),
            part => plain.push(part),
        }
    }
    plain
}

/// An object with its keys as they stand: [`Value`] would pass over the first of two equal ones.
struct Pairs(Options);

impl<'de> Deserialize<'de> for Pairs {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        struct Keys;
        impl<'de> Visitor<'de> for Keys {
            type Value = Pairs;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(
                self,
                mut map: A,
            ) -> std::result::Result<Pairs, A::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = map.next_entry()? {
                    pairs.push(pair);
                }
                Ok(Pairs(pairs))
            }
        }
        from.deserialize_map(Keys)
    }
}
