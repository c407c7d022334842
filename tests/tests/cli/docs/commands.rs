//! Command lines in pages, in blocks and within lines: commands, options, packages, targets and
//! scripts that they name exist.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use chaincell_tests::run;
use serde_json::Value;

use super::super::handout::commands;
use super::page::{Page, pages, top};
use super::shell::{Purpose, purpose};

/// What may be named.
struct Known {
    /// Options of each command of `chaincell`.
    commands: BTreeMap<String, BTreeSet<String>>,
    /// Packages with `TARGET-KIND NAME` and `feature NAME`.
    packages: BTreeMap<String, BTreeSet<String>>,
}

/// The options named in a text.
fn options(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| c.is_whitespace() || "[](),;:|=`".contains(c));
    words.filter(|word| word.len() > 2 && word.starts_with("--"))
}

impl Known {
    fn read() -> Self {
        let of = |name: String| {
            let help = run([&name, "--help"]).with(0).out;
            let words = options(&help).map(|word| word.trim_end_matches('.').to_owned());
            (name, words.collect())
        };
        let commands: BTreeMap<String, BTreeSet<String>> =
            commands().into_iter().map(of).chain([("help".to_owned(), BTreeSet::new())]).collect();
        assert!(commands.len() > 10 && commands["run"].contains("--path"), "{commands:?}");
        Self { commands, packages: packages() }
    }

    /// What is wrong with a command line; nothing where it is none that can be judged.
    fn fault(&self, line: &str) -> Option<String> {
        let line = line.split(" #").next().unwrap_or_default().trim_end_matches(['&', ' ']);
        let words: Vec<&str> = line.split_whitespace().collect();
        let from = words.iter().position(|word| !is_assignment(word))?;
        let words = &words[from..];
        match words {
            ["chaincell", command, ..] => self.chaincell(command, &words[2..]),
            ["cargo", "install" | "run" | "test" | "bench" | "build", ..]
                if !words.contains(&"--locked") =>
            {
                Some("takes versions that nobody tested: --locked is missing".into())
            }
            ["cargo", "run", ..] => {
                let at = words.iter().position(|word| *word == "--")?;
                self.chaincell(words.get(at + 1)?, &words[at + 2..])
            }
            ["cargo", "test" | "bench" | "build", ..] => self.cargo(&words[2..]),
            ["bash", script, ..] => is_missing(script),
            [script, ..] if is_script(script) => is_missing(script),
            [command, rest @ ..] if self.commands.contains_key(*command) => {
                let has_options = rest.iter().any(|word| word.contains("--"));
                if has_options { self.chaincell(command, rest) } else { None }
            }
            _ => None,
        }
    }

    fn chaincell(&self, command: &str, rest: &[&str]) -> Option<String> {
        let command = command.trim_matches(|c| "[]".contains(c));
        let Some(known) = self.commands.get(command) else {
            return (command.bytes().all(|b| b.is_ascii_lowercase()))
                .then(|| format!("chaincell has no command {command}"));
        };
        // Behind `--` is another program.
        let own = rest.iter().position(|word| *word == "--").unwrap_or(rest.len());
        let rest = rest[..own].join(" ");
        let mut named = options(&rest);
        named
            .find(|option| !known.contains(*option))
            .map(|option| format!("chaincell {command} has no option {option}"))
    }

    fn cargo(&self, rest: &[&str]) -> Option<String> {
        let end = rest.iter().position(|word| *word == "--").unwrap_or(rest.len());
        let mut package = None;
        for pair in rest[..end].windows(2) {
            let kind = match pair[0] {
                "-p" | "--package" => {
                    package = Some(pair[1]);
                    if !self.packages.contains_key(pair[1]) {
                        return Some(format!("there is no package {}", pair[1]));
                    }
                    continue;
                }
                "--test" => "test",
                "--bench" => "bench",
                "--features" => "feature",
                _ => continue,
            };
            let name = format!("{kind} {}", pair[1]);
            let of = self.packages.get(package.unwrap_or_default());
            if !of.is_some_and(|of| of.contains(&name)) {
                return Some(format!("{package:?} has no {name}"));
            }
        }
        None
    }
}

/// `NAME=VALUE` before a command.
fn is_assignment(word: &str) -> bool {
    word.split_once('=').is_some_and(|(name, _)| {
        !name.is_empty() && name.bytes().all(|b| b.is_ascii_uppercase() || b == b'_')
    })
}

fn is_script(word: &str) -> bool {
    word.starts_with(".ci/") || (word.starts_with("tests/") && word.ends_with("/run"))
}

/// A `#WORD` behind a script names a part of it, which another test looks for.
fn is_missing(script: &str) -> Option<String> {
    let script = script.split('#').next().unwrap_or_default();
    (!top().join(script).is_file()).then(|| format!("there is no script {script}"))
}

/// Packages of the workspace with their targets and features.
fn packages() -> BTreeMap<String, BTreeSet<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let said = Command::new(cargo)
        .current_dir(top())
        .args(["metadata", "--no-deps", "--format-version", "1", "--offline"])
        .output()
        .unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let said: Value = serde_json::from_slice(&said.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let of = |package: &Value| {
        let targets = package["targets"].as_array().unwrap();
        let targets = targets.iter().map(|target| {
            format!("{} {}", target["kind"][0].as_str().unwrap(), text(&target["name"]))
        });
        let features = package["features"].as_object().unwrap().keys();
        let features = features.map(|name| format!("feature {name}"));
        (text(&package["name"]), targets.chain(features).collect())
    };
    said["packages"].as_array().unwrap().iter().map(of).collect()
}

/// The command lines of a page: shell lines and code spans.
fn lines(page: &Page) -> impl Iterator<Item = &str> {
    let is_shell = |kind| matches!(kind, Some(Purpose::Run | Purpose::NoRun));
    let blocks = page.blocks.iter().filter(move |block| is_shell(purpose(block)));
    let spans = page.spans.iter().map(String::as_str);
    blocks.flat_map(|block| block.text.lines()).chain(spans)
}

#[test]
fn every_command_that_a_page_names_exists() {
    let known = Known::read();
    let mut faults = Vec::new();
    for page in pages() {
        let wrong = lines(&page).filter_map(|line| {
            known.fault(line).map(|why| format!("{}: `{line}`: {why}", page.path))
        });
        faults.extend(wrong);
    }
    assert!(faults.is_empty(), "\n  {}", faults.join("\n  "));
}

#[test]
fn a_command_that_is_not_there_is_seen() {
    let known = Known::read();
    for good in [
        "chaincell bake organ:500 -o organ.chaincell --lean --coarse none",
        "cosim [MODEL] [--seconds 10]",
        "CHAINCELL_SLOW=1 cargo test --locked --release -p chaincell-tests --test cli -- --nocapture",
        "bash .ci/run",
        "tests/fuzz/run --seconds 60",
        "cargo run --locked --release -- cosim     # with a comment",
        "state",
        "set",
    ] {
        assert_eq!(known.fault(good), None, "{good}");
    }
    for (bad, why) in [
        ("chaincell boil organ:500", "no command boil"),
        ("chaincell bake organ:500 --well-done", "no option --well-done"),
        ("serve --watchdog-s 1", "no option --watchdog-s"),
        ("cargo run --locked --release -- cosym", "no command cosym"),
        ("cargo test --locked -p chaincell-test", "no package chaincell-test"),
        ("cargo test --locked -p chaincell-tests --test dogs", "no test dogs"),
        ("cargo bench --locked -p chaincell-host --features beers", "no feature beers"),
        ("cargo install --path host", "--locked is missing"),
        ("cargo run --release -- cosim", "--locked is missing"),
        ("cargo build --release", "--locked is missing"),
        ("bash .ci/walk", "no script .ci/walk"),
        ("tests/fuzzy/run", "no script tests/fuzzy/run"),
    ] {
        let found = known.fault(bad).unwrap_or_default();
        assert!(found.contains(why), "{bad}: {found:?}");
    }
}
