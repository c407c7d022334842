//! A job of a batch as the command line of `run` that it stands for.

use std::any::TypeId;
use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction, Args as _, Command, FromArgMatches};
use serde_json::Value;
use sha1_smol::Sha1;

use super::super::options;
use super::super::run;
use super::list::{Options, text_of};
use crate::error::{Error, Result};
use crate::input;

/// Keys that say where results go: the results do not depend on them.
const NO_INPUTS: [&str; 3] = ["out", "force", "json"];

/// Reads jobs by the definition of the command line.
pub struct Reader<'a> {
    command: Command,
    base: &'a Path,
}

impl<'a> Reader<'a> {
    /// For jobs whose paths count from a folder.
    pub fn new(base: &'a Path) -> Self {
        let command = run::Args::augment_args(Command::new("run"));
        let command = command.no_binary_name(true).disable_help_flag(true);
        Self { command: command.mut_arg("out", |out| out.required(false)), base }
    }

    /// The arguments of a job.
    ///
    /// # Errors
    /// A key that is no option, a value that the option does not take, options that exclude each other.
    pub fn read(&mut self, options: &Options) -> Result<run::Args> {
        let (mut words, mut model) = (Vec::new(), Vec::new());
        for (key, value) in options {
            let option = self.option(key)?;
            let to = if option.is_positional() { &mut model } else { &mut words };
            to.extend(self.words(option, key, value)?);
        }
        if model.is_empty() {
            return Err(Error::input("`model` is missing: name a file of chaincell bake"));
        }
        words.push("--".into());
        words.extend(model);
        let matches = self.command.try_get_matches_from_mut(words);
        let read = matches.and_then(|found| run::Args::from_arg_matches(&found));
        read.map_err(|why| Error::input(options::in_a_line(&why)))
    }

    /// An error of a run, whose fields are named as its options.
    pub fn named(&self, why: Error) -> Error {
        let commands = [Command::new("chaincell").subcommand(self.command.clone())];
        match why {
            Error::Interrupted => why,
            why => Error::input(options::named(&why.to_string(), &commands)),
        }
    }

    /// The option that a key names.
    fn option(&self, key: &str) -> Result<&Arg> {
        let mut all = self.command.get_arguments();
        all.find(|option| name(option) == key).ok_or_else(|| {
            let dashed = key.trim_start_matches('-').replace('_', "-");
            let is_near = self.command.get_arguments().any(|option| name(option) == dashed);
            let remedy = if is_near {
                format!("write `{dashed}`")
            } else {
                "a job has `name`, `model` and the options of `chaincell run --help` without the dashes".into()
            };
            Error::input(format!("unknown key `{key}`: {remedy}"))
        })
    }

    /// The words of the command line for a key and its value.
    fn words(&self, option: &Arg, key: &str, value: &Value) -> Result<Vec<OsString>> {
        let refused = |remedy: &str| Err(Error::input(format!("`{key}` {value}: {remedy}")));
        if matches!(option.get_action(), ArgAction::SetTrue) {
            return match value {
                Value::Bool(true) => Ok(vec![format!("--{key}").into()]),
                Value::Bool(false) => Ok(Vec::new()),
                _ => refused("give true or false"),
            };
        }
        if let Value::Array(each) = value {
            if !matches!(option.get_action(), ArgAction::Append) {
                return refused("it stands once: give a text or a number");
            }
            let words = each.iter().map(|one| match one {
                Value::Array(_) => refused("give texts or numbers in it"),
                one => self.words(option, key, one),
            });
            return Ok(words.collect::<Result<Vec<_>>>()?.concat());
        }
        let Some(text) = text_of(value) else {
            return refused("give a text, a number or an array of them");
        };
        let value = self.value(option, key, &text);
        if option.is_positional() {
            return Ok(vec![value]);
        }
        let mut word = OsString::from(format!("--{key}="));
        word.push(value);
        Ok(vec![word])
    }

    /// A value with its path, if it is one, from the folder of the list.
    fn value(&self, option: &Arg, key: &str, text: &str) -> OsString {
        if key == "contact"
            && let Some((before, file, after)) = self.contact_file(text)
        {
            let mut value = OsString::from(before);
            value.push(self.base.join(file));
            value.push(after);
            return value;
        }
        let is_path = option.get_value_parser().type_id() == TypeId::of::<PathBuf>();
        let is_word = text.is_empty() || (key == "picture" && text == "off");
        if is_path && !is_word { self.base.join(text).into() } else { text.into() }
    }

    /// The file of a contact that names one, with what stands before and after it.
    fn contact_file<'t>(&self, text: &'t str) -> Option<(&'t str, &'t str, &'t str)> {
        let selector = text.strip_prefix("cells:").unwrap_or(text);
        let file = selector.strip_prefix("file:")?;
        let before = &text[..text.len() - file.len()];
        // A path may contain a #.
        let is_whole = self.base.join(file).exists();
        let end = file.rfind('#').filter(|_| !is_whole).unwrap_or(file.len());
        Some((before, &file[..end], &file[end..]))
    }

    /// Hash of all that the results of a job depend on: this release, the options, and the content of the files that
    /// they name, with that of the model given.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn inputs_hash(&self, options: &Options, model_sha1: &str) -> Result<String> {
        let mut inputs: Vec<String> = vec![format!("release {}", env!("CARGO_PKG_VERSION"))];
        for (key, value) in options {
            let text = &text_of(value).unwrap_or_default();
            inputs.push(match key.as_str() {
                _ if NO_INPUTS.contains(&key.as_str()) => continue,
                "model" => format!("model {model_sha1}"),
                "path" => format!("path {}", sha1_of(&self.base.join(text))?),
                "contact" if let Some((_, file, after)) = self.contact_file(text) => {
                    format!("contact {} {after}", sha1_of(&self.base.join(file))?)
                }
                _ => format!("{key} {value}"),
            });
        }
        inputs.sort();
        Ok(Sha1::from(inputs.join("\n")).digest().to_string())
    }
}

/// The key of an option.
fn name(option: &Arg) -> &str {
    option.get_long().unwrap_or(option.get_id().as_str())
}

/// SHA-1 of a file.
fn sha1_of(path: &Path) -> Result<String> {
    let failed = |why: std::io::Error| Error::file("read", path, why);
    let mut file = input::open(path).map_err(failed)?;
    let (mut sum, mut bytes) = (Sha1::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut bytes).map_err(failed)? {
            0 => return Ok(sum.digest().to_string()),
            count => sum.update(&bytes[..count]),
        }
    }
}
