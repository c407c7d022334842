//! Completions and manual pages: for every shell and of every command.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use chaincell_tests::files::{scratch, text};
use chaincell_tests::process::{SHORT, copied};
use chaincell_tests::{Running, run};

/// The commands that the help lists.
pub(super) fn commands() -> BTreeSet<String> {
    let help = run(["help"]).with(0).out;
    let names = help.lines().filter_map(|line| {
        let name = line.strip_prefix("  ")?.split(' ').next()?;
        (!name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase())).then(|| name.to_owned())
    });
    let names: BTreeSet<String> = names.filter(|name| name != "help").collect();
    assert!(names.len() > 15 && names.contains("bake") && names.contains("paper"), "{names:?}");
    names
}

/// Whether a word stands in a text between others.
fn names(text: &str, word: &str) -> bool {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-' || c == '_')).any(|at| at == word)
}

#[test]
fn every_shell_completes_every_command() {
    let commands = commands();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let said = run(["completions", shell]).with(0).out;
        for command in &commands {
            assert!(names(&said, command), "{shell}: {command} is missing");
        }
        // Options of a command of the product and of one of the laboratory.
        for option in ["contact-surface", "young-pa", "hold-out"] {
            assert!(said.contains(option), "{shell}: {option} is missing");
        }
    }
    let refused = run(["completions", "cobol"]).with(2);
    assert!(refused.err.contains("bash"), "{}", refused.err);
}

#[test]
fn bash_takes_its_completions() {
    let said = run(["completions", "bash"]).with(0).out;
    let mut bash = Command::new("bash").arg("-n").stdin(Stdio::piped()).spawn().unwrap();
    bash.stdin.take().unwrap().write_all(said.as_bytes()).unwrap();
    assert!(bash.wait().unwrap().success());
    let folder = scratch();
    let file = folder.path().join("completions");
    fs::write(&file, said).unwrap();
    let ask = r#"source "$1"; COMP_WORDS=(chaincell ba); COMP_CWORD=1
        _chaincell chaincell ba chaincell; printf '%s\n' "${COMPREPLY[@]}""#;
    let asked = Command::new("bash").args(["-c", ask, "bash", text(&file)]).output().unwrap();
    assert_eq!(String::from_utf8(asked.stdout).unwrap(), "bake\n");
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = scratch();
    let pages = folder.path().join("new/man1");
    run(["man", text(&pages)]).with(0);
    let found: BTreeSet<String> = fs::read_dir(&pages)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let page = |name: &String| format!("chaincell-{name}.1");
    for name in commands().iter().map(page).chain(["chaincell.1".into()]) {
        assert!(found.contains(&name), "{name} is not among {found:?}");
        let page = fs::read_to_string(pages.join(&name)).unwrap();
        assert!(page.contains(".SH SYNOPSIS") && page.contains(".SH DESCRIPTION"), "{name}");
    }
    let bake = fs::read_to_string(pages.join("chaincell-bake.1")).unwrap();
    assert!(bake.contains("contact\\-surface"), "{bake}");
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let refused = run(["man", text(&file)]).with(2);
    assert!(refused.err.contains("cannot create folder"), "{}", refused.err);
}

#[test]
fn without_the_laboratory_its_commands_are_named_too() {
    let folder = scratch();
    let mut command = Command::new(copied(folder.path()));
    let said = Running::start(command.args(["completions", "bash"]).env("PATH", folder.path()));
    let said = said.end(SHORT).with(0).out;
    for name in commands() {
        assert!(names(&said, &name), "{name} is missing");
    }
    assert!(!said.contains("hold-out"));
}
