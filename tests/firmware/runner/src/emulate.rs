//! Running an image in QEMU.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};

use crate::image::Image;
use crate::target::Target;

/// What an image said: values by name, those of a name said more than once one after the other.
#[derive(Debug, Default)]
pub struct Said(BTreeMap<String, String>);

impl Said {
    pub fn add(&mut self, name: &str, value: &str) {
        self.0.entry(name.to_owned()).or_default().push_str(value);
    }

    pub fn number(&self, name: &str) -> Result<u64> {
        Ok(self.text(name)?.parse()?)
    }

    pub fn bits(&self, name: &str) -> Result<u64> {
        Ok(u64::from_str_radix(self.text(name)?, 16)?)
    }

    pub fn bytes(&self, name: &str) -> Result<Vec<u8>> {
        let digits = self.text(name)?.as_bytes().chunks(2);
        let byte = |pair| Ok(u8::from_str_radix(std::str::from_utf8(pair)?, 16)?);
        digits.map(byte).collect()
    }

    /// All of it, a value a line.
    pub fn all(&self) -> String {
        self.0.iter().map(|(name, value)| format!("{name} {value}\n")).collect()
    }

    pub fn text(&self, name: &str) -> Result<&str> {
        self.0.get(name).map(String::as_str).with_context(|| format!("the image says no {name}"))
    }
}

/// Runs the image, one instruction a nanosecond, for at most `seconds` of this machine's time.
pub fn run(target: &Target, image: &Image, seconds: u32) -> Result<Said> {
    let (said, is_well) = emulate(target, &image.path, "none", Stdio::null(), seconds)?;
    ensure!(is_well, "{}: it fails, and said:\n{}", image.path.display(), said.all());
    Ok(said)
}

/// Runs an image with the bytes of a file on its serial line. Returns what it said, and true if it ended well.
pub fn run_on_line(
    target: &Target,
    path: &Path,
    stream: &Path,
    seconds: u32,
) -> Result<(Said, bool)> {
    let stream = File::open(stream).with_context(|| format!("{}", stream.display()))?;
    emulate(target, path, "stdio", stream.into(), seconds)
}

fn emulate(
    target: &Target,
    path: &Path,
    serial: &str,
    stdin: Stdio,
    seconds: u32,
) -> Result<(Said, bool)> {
    let [program, machine] = target.emulator;
    let mut command = Command::new("timeout");
    command.args(["--kill-after=5", &seconds.to_string(), program, "-machine", machine]);
    command.args(["-bios", "none"].iter().take(if machine == "virt" { 2 } else { 0 }));
    command.args(["-icount", "shift=0,sleep=off", "-display", "none", "-monitor", "none"]);
    command.args(["-serial", serial, "-semihosting-config", "enable=on,target=native"]);
    command.arg("-kernel").arg(path).stdin(stdin);
    let run = command.output().context("timeout, from coreutils")?;
    let stdout = String::from_utf8_lossy(&run.stdout);
    let stderr = String::from_utf8_lossy(&run.stderr);
    let path = path.display();
    if run.status.code() == Some(124) {
        bail!("{path}: not done after {seconds} s; it said:\n{stdout}");
    }
    // 1 is the image's own word.
    let is_ended = matches!(run.status.code(), Some(0 | 1));
    ensure!(is_ended, "{path}: {}; it said:\n{stdout}{stderr}", run.status);
    let mut said = Said::default();
    for (name, value) in stdout.lines().filter_map(|line| line.split_once(' ')) {
        said.add(name, value);
    }
    Ok((said, run.status.success()))
}
