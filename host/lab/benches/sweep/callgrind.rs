//! Instructions of a run of this program, by callgrind: they do not depend on the machine's load.

use std::io;
use std::process::Command;

use chaincell_host::error::{Error, Result};

/// Whether valgrind can be started.
pub fn is_there() -> io::Result<()> {
    Command::new("valgrind").arg("--version").output().map(drop)
}

/// Instructions of this program with the given arguments.
pub fn instructions(arguments: &[&str]) -> Result<f64> {
    let program = std::env::current_exe().map_err(Error::check)?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(arguments)
        .output()
        .map_err(|why| Error::input(format!("the count of instructions needs valgrind: {why}")))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().find_map(|line| line.split_once("Collected :")?.1.trim().parse().ok());
    let count = count.filter(|_| output.status.success());
    count.ok_or_else(|| Error::check(format!("valgrind gave no count:\n{text}")))
}
