//! The results of a batch: one JSON object a line, appended whole, in a file that a later run goes on with.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::input;
use crate::terminal;

/// The first letters of every line.
const FRONT: &str = "{\"job\":";

/// The part of a line that names its job.
#[derive(Debug, Deserialize)]
struct Done {
    job: u64,
    name: Option<String>,
    inputs_hash: Option<String>,
    error: Option<String>,
}

/// Where the lines go.
#[derive(Debug)]
enum Sink {
    Terminal,
    File { file: File, path: PathBuf, length: u64 },
}

/// The results so far.
#[derive(Debug)]
pub struct Results {
    sink: Mutex<Sink>,
    /// The hashes of jobs that were done before, by their names, or by their lines where they have none.
    done: BTreeMap<String, String>,
}

impl Results {
    /// Opens the results in a file, or on standard output. A torn last line is cut off: a run was killed there.
    ///
    /// # Errors
    /// A file that cannot be written, to which another run writes, or that has other content.
    pub fn open(path: Option<&Path>) -> Result<Self> {
        let Some(path) = path else {
            return Ok(Self { sink: Mutex::new(Sink::Terminal), done: BTreeMap::new() });
        };
        // Open and lock the file.
        let failed = |why: std::io::Error| Error::file("write", path, why);
        input::keep(path)?;
        if path.exists() && !path.is_file() {
            return Err(Error::file("write", path, "it is there and no file; name another one"));
        }
        let mut options = OpenOptions::new();
        let mut file = options.read(true).append(true).create(true).open(path).map_err(failed)?;
        // Some file systems of clusters have no locks.
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(Error::input(format!(
                "--results {}: another run writes to it: give each run its own",
                path.display()
            )));
        }
        // Read what is there.
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        let (done, whole) = done(&bytes).map_err(|line| {
            Error::input(format!(
                "--results {}:{line}: no result of a batch: name another file",
                path.display()
            ))
        })?;
        // Cut off a line that is not whole.
        let length = whole as u64;
        if whole < bytes.len() {
            file.set_len(length).map_err(failed)?;
        }
        let sink = Mutex::new(Sink::File { file, path: path.to_owned(), length });
        Ok(Self { sink, done })
    }

    /// The hash of a job's inputs when it was done before.
    pub fn earlier(&self, line: u64, name: Option<&str>) -> Option<&str> {
        self.done.get(&id(line, name)).map(String::as_str)
    }

    /// Appends a line.
    ///
    /// # Errors
    /// A full disk: what was written of the line is cut off again.
    pub fn add(&self, line: &impl Serialize) -> Result<()> {
        let mut text = serde_json::to_string(line).map_err(Error::check)?;
        match &mut *self.sink.lock().unwrap_or_else(PoisonError::into_inner) {
            Sink::Terminal => terminal::say(text),
            Sink::File { file, path, length } => {
                text.push('\n');
                file.write_all(text.as_bytes()).map_err(|why| {
                    let _ = file.set_len(*length);
                    Error::file(
                        "write",
                        path,
                        format!("{why}; make room and run it again: it goes on there"),
                    )
                })?;
                *length += text.len() as u64;
                Ok(())
            }
        }
    }
}

/// A job's place among those that were done.
fn id(line: u64, name: Option<&str>) -> String {
    name.map_or_else(|| format!("line {line}"), |name| format!("name {name}"))
}

/// The jobs that were done, by the last line of each, and the bytes of all whole lines. Else the number of the first
/// line that is no result.
fn done(bytes: &[u8]) -> std::result::Result<(BTreeMap<String, String>, usize), usize> {
    let (mut all, mut whole) = (BTreeMap::new(), 0);
    for (line, text) in (1..).zip(bytes.split_inclusive(|byte| *byte == b'\n')) {
        if text.last() != Some(&b'\n') {
            return if is_torn(text) { Ok((all, whole)) } else { Err(line) };
        }
        whole += text.len();
        let done: Done = serde_json::from_slice(text).or(Err(line))?;
        let id = id(done.job, done.name.as_deref());
        match done.inputs_hash.filter(|_| done.error.is_none()) {
            Some(hash) => _ = all.insert(id, hash),
            None => _ = all.remove(&id),
        }
    }
    Ok((all, whole))
}

/// Returns true for the beginning of a line.
fn is_torn(text: &[u8]) -> bool {
    let count = text.len().min(FRONT.len());
    text[..count] == FRONT.as_bytes()[..count]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Line<'a> {
        job: u64,
        inputs_hash: &'a str,
    }

    fn open(path: &Path) -> Result<Results> {
        Results::open(Some(path))
    }

    #[test]
    fn a_line_cut_anywhere_is_cut_off_and_the_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results");
        {
            let results = open(&path).unwrap();
            results.add(&Line { job: 1, inputs_hash: "a" }).unwrap();
            results.add(&Line { job: 2, inputs_hash: "b" }).unwrap();
        }
        let whole = std::fs::read(&path).unwrap();
        let first = whole.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        for length in 0..=whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let results = open(&path).unwrap();
            assert_eq!(results.earlier(1, None), (length >= first).then_some("a"));
            assert_eq!(results.earlier(2, None), (length == whole.len()).then_some("b"));
            results.add(&Line { job: 3, inputs_hash: "c" }).unwrap();
            drop(results);
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.ends_with("{\"job\":3,\"inputs_hash\":\"c\"}\n"), "{text}");
            assert_eq!(open(&path).unwrap().earlier(3, None), Some("c"));
        }
    }

    #[test]
    fn a_file_of_other_content_stays_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results");
        for (content, line) in [
            ("tick,x_m\n", 1),
            ("{\"job\":1}\nnote", 2),
            ("{\"job\":1}\n{}\n", 2),
            ("\u{0}", 1),
            ("[1]", 1),
        ] {
            std::fs::write(&path, content).unwrap();
            let why = open(&path).unwrap_err().to_string();
            assert!(why.contains(&format!("results:{line}: ")) && why.contains("another file"));
            assert_eq!(std::fs::read_to_string(&path).unwrap(), content);
        }
    }

    #[test]
    fn the_last_line_of_a_job_counts_and_two_runs_do_not_share_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results");
        std::fs::write(
            &path,
            "{\"job\":1,\"error\":\"x\"}\n{\"job\":1,\"inputs_hash\":\"a\"}\n\
             {\"job\":2,\"inputs_hash\":\"b\"}\n{\"job\":2,\"inputs_hash\":\"b\",\"error\":\"x\"}\n\
             {\"job\":3,\"name\":\"line 4\",\"inputs_hash\":\"c\"}\n",
        )
        .unwrap();
        let results = open(&path).unwrap();
        let earlier = [(1, None), (2, None), (3, None), (4, None), (9, Some("line 4"))];
        let earlier = earlier.map(|(line, name)| results.earlier(line, name));
        assert_eq!(earlier, [Some("a"), None, None, None, Some("c")]);
        let why = open(&path).unwrap_err().to_string();
        assert!(why.contains("another run writes to it"), "{why}");
    }
}
