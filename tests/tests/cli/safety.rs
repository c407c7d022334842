//! `kernel/SAFETY.md` says nothing that no test shows: every requirement names tests and checks
//! that exist, every hazard has its requirements, the list of foreign software is true.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Lines around the list of foreign software.
const BEGIN: &str = "<!-- soup: begin -->\n";
const END: &str = "<!-- soup: end -->";
/// Scripts that a change has to pass, or the slow suite runs.
const SUITES: [&str; 2] = [".ci/run", ".ci/slow"];

fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

fn page() -> PathBuf {
    top().join("kernel/SAFETY.md")
}

fn text() -> String {
    std::fs::read_to_string(page()).unwrap()
}

/// A requirement: its list item in the page.
struct Requirement {
    id: String,
    /// What it answers.
    hazards: Vec<String>,
    /// Names in backticks behind `Tests:`.
    tests: Vec<String>,
}

/// Words of a form such as `REQ-ENE-01` or `H12`, in order.
fn words(text: &str, is: impl Fn(&str) -> bool) -> Vec<String> {
    let apart = |c: char| !(c.is_ascii_alphanumeric() || c == '-');
    text.split(apart).filter(|word| is(word)).map(str::to_owned).collect()
}

fn is_requirement(word: &str) -> bool {
    let parts: Vec<&str> = word.split('-').collect();
    matches!(parts[..], ["REQ", group, number]
        if group.len() == 3 && number.len() == 2 && number.bytes().all(|b| b.is_ascii_digit()))
}

fn is_hazard(word: &str) -> bool {
    let number = word.strip_prefix('H');
    number.is_some_and(|number| {
        !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())
    })
}

/// The items `- **REQ-ENE-01** [H1, H2] What holds. Tests: `FILE::TEST`, `SCRIPT#WORD`.`
fn requirements(page: &str) -> Vec<Requirement> {
    let mut items: Vec<String> = Vec::new();
    let mut inside = false;
    for line in page.lines() {
        if line.starts_with("- **REQ-") {
            items.push(String::new());
            inside = true;
        } else if !line.starts_with("  ") {
            inside = false;
        }
        if inside {
            write!(items.last_mut().unwrap(), "{} ", line.trim()).unwrap();
        }
    }
    let parse = |item: &String| {
        let (front, rest) = item.split_once("** [").unwrap_or((item, ""));
        let (hazards, rest) = rest.split_once(']').unwrap_or(("", ""));
        let (_, tests) = rest.split_once("Tests:").unwrap_or(("", ""));
        Requirement {
            id: front.trim_start_matches("- **").to_owned(),
            hazards: words(hazards, is_hazard),
            tests: tests.split('`').skip(1).step_by(2).map(str::to_owned).collect(),
        }
    };
    items.iter().map(parse).collect()
}

/// Whether a source has a function of this name under `#[test]`, in `proptest!` or not.
fn has_test(source: &str, name: &str) -> bool {
    let lines: Vec<&str> = source.lines().map(str::trim).collect();
    let head = format!("fn {name}(");
    lines.iter().enumerate().filter(|(_, line)| line.starts_with(&head)).any(|(at, _)| {
        let above = lines[..at].iter().rev();
        above
            .take_while(|line| line.starts_with("#[") || line.starts_with("//"))
            .any(|line| *line == "#[test]")
    })
}

/// Whether a word stands in a script or in what it runs: the sources beside it.
fn has_word(script: &str, word: &str) -> bool {
    let mut places = vec![top().join(script)];
    if script == "tests/firmware/run" {
        let folder = top().join("tests/firmware");
        places.push(folder.join("budgets.toml"));
        for sources in ["runner/src", "image/src"] {
            let files = std::fs::read_dir(folder.join(sources)).unwrap();
            places.extend(files.map(|file| file.unwrap().path()));
        }
    }
    places.iter().any(|place| {
        let text = std::fs::read_to_string(place).unwrap();
        text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-'))
            .any(|found| found == word)
    })
}

/// What is wrong with the name of a test or a check.
fn fault(name: &str) -> Option<String> {
    if let Some((file, test)) = name.split_once("::") {
        let Ok(source) = std::fs::read_to_string(top().join(file)) else {
            return Some(format!("no file {file}"));
        };
        return (!has_test(&source, test)).then(|| format!("no test {test} in {file}"));
    }
    let (script, word) = name.split_once('#').unwrap_or((name, ""));
    if !top().join(script).is_file() {
        return Some(format!("no script {script}"));
    }
    let run = SUITES.iter().any(|suite| {
        std::fs::read_to_string(top().join(suite)).unwrap().contains(&format!("bash {script}"))
    });
    if !run {
        return Some(format!("{script} is called by none of {SUITES:?}"));
    }
    (!word.is_empty() && !has_word(script, word)).then(|| format!("no {word} in {script}"))
}

/// All that is wrong with the trace of a page.
fn faults(page: &str) -> Vec<String> {
    let requirements = requirements(page);
    let mut faults = Vec::new();
    let mut defined = BTreeSet::new();
    for Requirement { id, hazards, tests } in &requirements {
        if !is_requirement(id) {
            faults.push(format!("{id} is no identifier"));
        }
        if !defined.insert(id.as_str()) {
            faults.push(format!("{id} stands twice"));
        }
        if hazards.is_empty() {
            faults.push(format!("{id} answers no hazard"));
        }
        if tests.is_empty() {
            faults.push(format!("{id} names no test"));
        }
        let wrong = tests.iter().filter_map(|name| fault(name));
        faults.extend(wrong.map(|why| format!("{id}: {why}")));
    }
    for id in words(page, |word| word.starts_with("REQ-")) {
        if !defined.contains(id.as_str()) {
            faults.push(format!("{id} is named and not defined"));
        }
    }
    let rows = page.lines().filter_map(|line| line.strip_prefix("| H"));
    let listed: Vec<String> =
        rows.map(|row| format!("H{}", row.split(' ').next().unwrap())).collect();
    let answered: BTreeSet<&String> = requirements.iter().flat_map(|one| &one.hazards).collect();
    for hazard in &listed {
        if !answered.contains(hazard) {
            faults.push(format!("no requirement answers {hazard}"));
        }
    }
    let unknown = answered.into_iter().filter(|hazard| !listed.contains(hazard));
    faults.extend(unknown.map(|hazard| format!("{hazard} is answered and not listed")));
    faults
}

#[test]
fn every_requirement_is_traced_to_tests_that_exist() {
    let page = text();
    let faults = faults(&page);
    assert!(faults.is_empty(), "kernel/SAFETY.md:\n  {}", faults.join("\n  "));
    assert!(requirements(&page).len() > 40, "the list was not read");
}

/// The check itself, on pages with one fault each.
#[test]
fn a_broken_trace_is_seen() {
    let good = "| H1 | harm |\n\n- **REQ-ENE-01** [H1] It holds.\n  \
                Tests: `tests/tests/cli/safety.rs::a_broken_trace_is_seen`, `.ci/deny`,\n  \
                `tests/firmware/run#stack_bytes`.\n";
    assert_eq!(faults(good), Vec::<String>::new());
    for (from, to, expected) in [
        ("a_broken_trace_is_seen", "a_broken", "no test a_broken in"),
        ("a_broken_trace_is_seen", "faults", "no test faults in"),
        ("tests/tests/cli/safety.rs", "tests/tests/none.rs", "no file"),
        ("`.ci/deny`", "`.ci/denied`", "no script .ci/denied"),
        ("`.ci/deny`", "`.ci/bring`", ".ci/bring is called by none"),
        ("stack_bytes", "heap_bytes", "no heap_bytes in"),
        ("Tests:", "Shown by", "names no test"),
        ("[H1]", "[]", "answers no hazard"),
        ("[H1]", "[H1, H2]", "H2 is answered and not listed"),
        ("| H1 | harm |", "| H1 | harm |\n| H3 | more |", "no requirement answers H3"),
        ("It holds.", "It holds, as REQ-ENE-02.", "REQ-ENE-02 is named and not defined"),
        ("REQ-ENE-01", "REQ-ENERGY-1", "REQ-ENERGY-1 is no identifier"),
    ] {
        let found = faults(&good.replace(from, to));
        assert!(found.iter().any(|fault| fault.contains(expected)), "{expected}: {found:?}");
    }
    let twice = format!("{good}\n{good}");
    assert!(faults(&twice).iter().any(|fault| fault.contains("stands twice")));
}

/// Packages of the kernel and its C interface along these edges, without our own: licence and
/// features by name and version.
fn packages(edges: &str) -> BTreeMap<(String, String), [String; 2]> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let tree = Command::new(cargo)
        .current_dir(top())
        .args(["tree", "--locked", "--target", "all", "--prefix", "none", "--no-dedupe"])
        .args(["--package", "chaincell-kernel", "--package", "chaincell-ffi"])
        .args(["--edges", edges, "--format", "{p}|{l}|{f}"])
        .output()
        .unwrap();
    let said = String::from_utf8(tree.stdout).unwrap();
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let mut found = BTreeMap::new();
    for line in said.lines().filter(|line| !line.is_empty() && !line.starts_with("chaincell-")) {
        let [package, licence, features] = line.splitn(3, '|').collect::<Vec<_>>()[..] else {
            unreachable!("{line}")
        };
        let [name, version] = package.split(' ').take(2).collect::<Vec<_>>()[..] else {
            unreachable!("{line}")
        };
        let key = (name.to_owned(), version.trim_start_matches('v').to_owned());
        let features = features.replace(',', ", ");
        found.insert(key, [licence.replace('/', " OR "), features]);
    }
    found
}

/// The list of foreign software, from the lock file and the packages' own manifests.
fn list() -> String {
    let linked = packages("normal,no-proc-macro");
    let mut built = packages("normal,build");
    built.retain(|key, _| !linked.contains_key(key));
    let mut table = String::from("| crate | version | licence | features |\n|---|---|---|---|\n");
    for ((name, version), [licence, features]) in &linked {
        writeln!(table, "| {name} | {version} | {licence} | {features} |").unwrap();
    }
    table += "\nOnly at compile time, nothing of it in the library:\n\n";
    table += "| crate | version | licence |\n|---|---|---|\n";
    for ((name, version), [licence, _]) in &built {
        writeln!(table, "| {name} | {version} | {licence} |").unwrap();
    }
    table
}

#[test]
fn the_list_of_foreign_software_is_true() {
    let page = text();
    let (front, rest) = page.split_once(BEGIN).unwrap();
    let (stands, back) = rest.split_once(END).unwrap();
    let list = list();
    assert!(list.lines().count() > 20, "too few packages:\n{list}");
    if std::env::var_os("CHAINCELL_RENEW").is_some() {
        std::fs::write(self::page(), format!("{front}{BEGIN}{list}{END}{back}")).unwrap();
        return;
    }
    assert!(
        stands == list,
        "kernel/SAFETY.md lists other software than the kernel has: \
         CHAINCELL_RENEW=1 cargo test -p chaincell-tests --test cli safety writes it anew\n{list}"
    );
}
