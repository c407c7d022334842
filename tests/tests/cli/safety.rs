//! `kernel/SAFETY.md` states nothing that no test shows: every requirement has tests and checks that
//! carry its mark, every hazard has requirements, the list of foreign software is true.
//!
//! A mark is the line directly above a test, `// REQ-ENE-01, REQ-ENE-02`, or above a check of a
//! script that `.ci/run` or `.ci/slow` runs, `# REQ-TCK-01`.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Lines around the list of foreign software.
const BEGIN: &str = "<!-- soup: begin -->\n";
const END: &str = "<!-- soup: end -->";
/// Scripts that a change has to pass, or the slow suite runs.
const SUITES: [&str; 2] = [".ci/run", ".ci/slow"];
/// The sources of a check that the script beside them runs.
const RUNNER: &str = "tests/firmware/runner/src/";

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
    /// The hazards that it answers.
    hazards: Vec<String>,
}

/// A mark in a source: requirements, and the test or check that they stand above.
struct Mark {
    ids: Vec<String>,
    /// `FILE::TEST` or `FILE:LINE`, or why it is neither.
    place: Result<String, String>,
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

/// The items `- REQ-ENE-01 [H1, H2] The requirement.`
fn requirements(page: &str) -> Vec<Requirement> {
    let items = page.lines().filter(|line| line.starts_with("- REQ-"));
    let parse = |item: &str| {
        let (front, rest) = item.split_once(" [").unwrap_or((item, ""));
        let (hazards, _) = rest.split_once(']').unwrap_or(("", ""));
        Requirement {
            id: front.trim_start_matches("- ").to_owned(),
            hazards: words(hazards, is_hazard),
        }
    };
    items.map(parse).collect()
}

/// The name of the test that these lines begin with, its attributes and comments first.
fn test_below(lines: &[&str]) -> Option<String> {
    let is_above = |line: &&&str| line.starts_with("#[") || line.starts_with("//");
    let above = lines.iter().take_while(is_above).count();
    let (name, _) = lines.get(above)?.strip_prefix("fn ")?.split_once('(')?;
    lines[..above].contains(&"#[test]").then(|| name.to_owned())
}

/// Whether a suite runs this script, or the script whose sources hold this file.
fn is_run(file: &str) -> bool {
    let script = if file.starts_with(RUNNER) { "tests/firmware/run" } else { file };
    let line = format!("bash {script}");
    SUITES.iter().any(|suite| std::fs::read_to_string(top().join(suite)).unwrap().contains(&line))
}

/// The marks of a source.
fn marks(file: &str, source: &str) -> Vec<Mark> {
    let lines: Vec<&str> = source.lines().map(str::trim).collect();
    let is_test = file.ends_with(".rs") && !file.starts_with(RUNNER);
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let comment = line.strip_prefix("// ").or_else(|| line.strip_prefix("# "));
        let Some(comment) = comment.filter(|comment| comment.starts_with("REQ-")) else {
            continue;
        };
        let number = at + 1;
        let place = if is_test {
            test_below(&lines[number..])
                .map(|test| format!("{file}::{test}"))
                .ok_or_else(|| format!("{file}:{number}: a mark above no test"))
        } else if is_run(file) {
            Ok(format!("{file}:{number}"))
        } else {
            Err(format!("{file}:{number}: a mark in a file that none of {SUITES:?} runs"))
        };
        let ids = comment.split(", ").map(str::to_owned).collect();
        found.push(Mark { ids, place });
    }
    found
}

/// The marks of all sources of the tree.
fn marks_of_tree() -> Vec<Mark> {
    let listed = Command::new("git")
        .current_dir(top())
        .args(["grep", "--untracked", "-lIE", "^[[:space:]]*(//|#) REQ-", "--"])
        .args(["*.rs", ".ci", "tests/firmware"])
        .output()
        .unwrap();
    assert!(listed.status.success(), "{}", String::from_utf8_lossy(&listed.stderr));
    let files = String::from_utf8(listed.stdout).unwrap();
    files
        .lines()
        .flat_map(|file| marks(file, &std::fs::read_to_string(top().join(file)).unwrap()))
        .collect()
}

/// All that is wrong with the hazards and requirements of a page and the marks of its sources.
fn faults(page: &str, marks: &[Mark]) -> Vec<String> {
    let requirements = requirements(page);
    let mut faults: Vec<String> =
        marks.iter().filter_map(|mark| mark.place.as_ref().err().cloned()).collect();
    let marked: BTreeSet<&String> = marks.iter().flat_map(|mark| &mark.ids).collect();
    let mut defined = BTreeSet::new();
    for Requirement { id, hazards } in &requirements {
        if !is_requirement(id) {
            faults.push(format!("{id} is no identifier"));
        }
        if !defined.insert(id.as_str()) {
            faults.push(format!("{id} stands twice"));
        }
        if hazards.is_empty() {
            faults.push(format!("{id} answers no hazard"));
        }
        if !marked.contains(id) {
            faults.push(format!("{id} has no test"));
        }
    }
    let named = words(page, |word| word.starts_with("REQ-"));
    for id in named.iter().chain(marked) {
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

/// Prints the table of requirements and tests too: `-- --nocapture` shows it.
// REQ-SUP-03
#[test]
fn every_requirement_has_tests() {
    let (page, marks) = (text(), marks_of_tree());
    for Requirement { id, .. } in requirements(&page) {
        let of_it = marks.iter().filter(|mark| mark.ids.contains(&id));
        for place in of_it.filter_map(|mark| mark.place.as_ref().ok()) {
            println!("{id} {place}");
        }
    }
    let faults = faults(&page, &marks);
    assert!(faults.is_empty(), "kernel/SAFETY.md:\n  {}", faults.join("\n  "));
    assert!(requirements(&page).len() > 90, "the list was not read");
}

/// The check itself, on a page and sources with one fault each.
// REQ-SUP-03
#[test]
fn a_requirement_without_a_test_is_seen() {
    let page = "| H1 | harm |\n\n- REQ-ENE-01 [H1] It holds.\n- REQ-TCK-01 [H1] It ends.\n";
    let test = "    // REQ-ENE-01\n    #[test]\n    #[cfg(unix)]\n    fn it_holds() {\n    }\n";
    let script = "# REQ-TCK-01\ncheck\n";
    let all = |page: &str, test: &str, file: &str, script: &str| {
        let mut found = marks("kernel/src/lib.rs", test);
        found.extend(marks(file, script));
        faults(page, &found)
    };
    assert_eq!(all(page, test, ".ci/deny", script), Vec::<String>::new());
    let places: Vec<_> = marks("a.rs", test).into_iter().map(|mark| mark.place).collect();
    assert_eq!(places, [Ok("a.rs::it_holds".to_owned())]);
    let runner = marks(&format!("{RUNNER}main.rs"), &script.replace('#', "//"));
    assert!(runner.iter().all(|mark| mark.place.is_ok()) && runner.len() == 1);
    for (from, to, expected) in [
        ("[H1]", "[]", "answers no hazard"),
        ("[H1]", "[H1, H2]", "H2 is answered and not listed"),
        ("| H1 | harm |", "| H1 | harm |\n| H3 | more |", "no requirement answers H3"),
        ("It holds.", "It holds, as REQ-ENE-02.", "REQ-ENE-02 is named and not defined"),
        ("REQ-ENE-01", "REQ-ENERGY-1", "REQ-ENERGY-1 is no identifier"),
        ("REQ-ENE-01", "REQ-ENE-02", "REQ-ENE-02 has no test"),
        ("REQ-TCK-01", "REQ-ENE-01", "stands twice"),
    ] {
        let found = all(&page.replace(from, to), test, ".ci/deny", script);
        assert!(found.iter().any(|fault| fault.contains(expected)), "{expected}: {found:?}");
    }
    for (from, to, expected) in [
        ("REQ-ENE-01", "REQ-ENE-01, REQ-ENE-07", "REQ-ENE-07 is named and not defined"),
        ("REQ-ENE-01", "REQ-ENE-01 and more", "REQ-ENE-01 has no test"),
        ("// REQ-ENE-01", "// As REQ-ENE-01", "REQ-ENE-01 has no test"),
        ("#[test]", "#[inline]", "kernel/src/lib.rs:1: a mark above no test"),
        ("fn it_holds", "\n    fn it_holds", "kernel/src/lib.rs:1: a mark above no test"),
    ] {
        let found = all(page, &test.replace(from, to), ".ci/deny", script);
        assert!(found.iter().any(|fault| fault.contains(expected)), "{expected}: {found:?}");
    }
    let found = all(page, test, ".ci/bring", script);
    assert!(found[0].starts_with(".ci/bring:1: a mark in a file that none of"), "{found:?}");
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

/// Rows of packages by licence, features in brackets.
fn rows(packages: &BTreeMap<(String, String), [String; 2]>) -> String {
    let mut by_licence = BTreeMap::<&str, Vec<String>>::new();
    for ((name, version), [licence, features]) in packages {
        let with = if features.is_empty() { String::new() } else { format!(" ({features})") };
        by_licence.entry(licence).or_default().push(format!("{name} {version}{with}"));
    }
    let row =
        |(licence, names): (&str, Vec<String>)| format!("| {licence} | {} |\n", names.join(", "));
    by_licence.into_iter().map(row).collect()
}

/// The list of foreign software, from the lock file and the packages' own manifests.
fn list() -> String {
    let linked = packages("normal,no-proc-macro");
    let mut built = packages("normal,build");
    built.retain(|key, _| !linked.contains_key(key));
    built.values_mut().for_each(|[_, features]| features.clear());
    assert!(linked.len() > 10 && built.len() > 3, "too few packages: {linked:?}, {built:?}");
    let head = "| licence | crates |\n|---|---|\n";
    let (linked, built) = (rows(&linked), rows(&built));
    format!("{head}{linked}\nOnly at compile time, nothing of it in the library:\n\n{head}{built}")
}

// REQ-SUP-02
#[test]
fn the_list_of_foreign_software_is_true() {
    let page = text();
    let (front, rest) = page.split_once(BEGIN).unwrap();
    let (stands, back) = rest.split_once(END).unwrap();
    let list = list();
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
