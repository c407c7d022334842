//! Shell blocks: those of a page run one after the other in an empty folder; a block that cannot
//! run in a test says so behind its fence, `sh,no-run: REASON`.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use chaincell_tests::files::{Table, names, scratch};
use chaincell_tests::{Ended, Running, chaincell, scene, turn};

use super::page::{Block, Page, pages, top};

/// Longest time for the blocks of a page.
const AT_MOST: Duration = Duration::from_secs(600);
/// The page that a user begins with.
const FIRST: &str = "host/STL.md";
/// The scene that the pages name.
const SCENE: &str = "--scene left";

/// What a block is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Shell lines that run.
    Run,
    /// Shell lines that do not run here.
    NoRun,
    /// Neither: text; Rust, which the documentation tests compile; Python, which the tests of the
    /// package run.
    Other,
}

/// What the fence of a block says; `None` where it says nothing that is known.
pub fn purpose(block: &Block) -> Option<Purpose> {
    match block.info.as_str() {
        "sh" => Some(Purpose::Run),
        "text" | "rust" | "python" => Some(Purpose::Other),
        info => {
            let reason = info.strip_prefix("sh,no-run: ")?;
            (!reason.trim().is_empty()).then_some(Purpose::NoRun)
        }
    }
}

/// The blocks of a page that run, as one script.
fn script(page: &Page) -> String {
    let blocks = page.blocks.iter().filter(|block| purpose(block) == Some(Purpose::Run));
    blocks.map(|block| block.text.as_str()).collect()
}

#[test]
fn every_fence_is_known() {
    for page in pages() {
        for block in &page.blocks {
            assert!(purpose(block).is_some(), "{}: a block of `{}`", page.path, block.info);
        }
    }
    let unknown =
        ["bash", "console", "", "sh,no-run:", "sh,no-run: ", "rust,ignore", "toml,file: x"];
    for info in unknown {
        let block = Block { info: info.into(), text: String::new() };
        assert_eq!(purpose(&block), None, "{info}");
    }
}

/// How late answers are is the machine's matter: only a verdict may end with exit code 1.
const LATE_IS_FINE: &str = r#"chaincell() {
    local said code=0
    said=$(mktemp)
    command chaincell "$@" > "$said" 2>&1 || code=$?
    cat "$said"
    [ "$code" != 1 ] || ! grep -q '1 kHz NOT held' "$said" || code=0
    return "$code"
}
"#;

#[test]
fn every_shell_block_runs() {
    let mut lines = 0;
    for page in pages() {
        let script = script(&page);
        if script.is_empty() || page.path == FIRST {
            continue;
        }
        lines += script.lines().count();
        ran(&page.path, &script, scratch().path());
    }
    assert!(lines > 10, "only {lines} lines of shell were found");
}

/// Runs lines of a page in one shell, in this folder; how late answers are does not matter.
#[track_caller]
fn ran(page: &str, script: &str, folder: &Path) -> Ended {
    let program = chaincell();
    let programs = Path::new(program.get_program()).parent().unwrap();
    let others = std::env::var_os("PATH").unwrap();
    let path = std::iter::once(programs.to_owned()).chain(std::env::split_paths(&others));
    let path = std::env::join_paths(path).unwrap();
    let own = format!("--scene {}", scene("docs"));
    let script = script.replace(SCENE, &own);
    let _turn = turn();
    let running = Running::start(
        Command::new("bash")
            .args(["-euo", "pipefail", "-c", &(LATE_IS_FINE.to_owned() + &script)])
            .current_dir(folder)
            .env("PATH", &path)
            .env_remove("CHAINCELL_LOG"),
    );
    let ended = running.end(AT_MOST);
    assert_eq!(ended.code, Some(0), "{page}:\n{script}\n{ended:#?}");
    ended
}

/// Whoever has a closed STL in millimetres gets a body, a curve, a picture and how far to trust them, in at most
/// four commands.
#[test]
fn the_first_page_leads_from_an_stl_to_a_force_curve() {
    let page = pages().into_iter().find(|page| page.path == FIRST).unwrap();
    let script = script(&page);
    let (stl, commands) = script.split_once("liver.stl\n").unwrap();
    assert!(commands.lines().count() <= 4 && commands.contains("--units mm"), "{commands}");
    let folder = scratch();
    let said = ran(&page.path, &format!("{stl}liver.stl\n{commands}"), folder.path()).out;
    // In millimetres, as a scan is.
    let surface = std::fs::read_to_string(folder.path().join("liver.stl")).unwrap();
    let largest = surface.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
    assert!(largest.fold(0.0, f64::max) > 50.0);
    for press in ["press", "fine"].map(|name| folder.path().join(name)) {
        let names = names(&press);
        for wanted in ["force.csv", "force.svg", "force_depth.svg", "picture.png"] {
            assert!(names.iter().any(|name| name == wanted), "{wanted}: {names:?}");
        }
        let forces_n = Table::read(&press.join("force.csv")).vectors("fx_n");
        assert!(forces_n.iter().flatten().any(|force_n| force_n.abs() > 0.1));
    }
    for wanted in [
        "volume ",
        "distance ",
        "tissue        5000 Pa",
        "graded ",
        "radius of 12.0 mm, 9.12 mm deep: the force is up to 32 % off",
        "radius of 12.0 mm, 10.0 mm deep: the force is within 14 %",
    ] {
        assert!(said.contains(wanted), "{wanted}: {said}");
    }
}

/// The pages for a first hour are short, and each runs as it stands.
#[test]
fn the_pages_for_a_first_hour_are_short() {
    for name in [FIRST, "host/SIMULATOR.md", "host/BOARD.md"] {
        let page = pages().into_iter().find(|page| page.path == name).unwrap();
        assert!(page.text.len() <= 3000, "{name} has {} bytes", page.text.len());
        let is_run = |block: &Block| {
            let script = block
                .info
                .strip_prefix("sh,no-run: ")
                .and_then(|info| info.strip_suffix(" runs these lines"));
            block.info == "sh" || script.is_some_and(|script| top().join(script).is_file())
        };
        let blocks = page.blocks.iter().filter(|block| block.info.starts_with("sh"));
        let wrong: Vec<_> = blocks.filter(|block| !is_run(block)).collect();
        assert!(wrong.is_empty(), "{name}: {wrong:?}");
    }
}
