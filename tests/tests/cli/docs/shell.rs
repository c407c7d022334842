//! Shell blocks: those of a page run one after the other in an empty folder; a block that cannot
//! run in a test says so behind its fence, `sh,no-run: REASON`.

use std::process::Command;
use std::time::Duration;

use chaincell_tests::files::scratch;
use chaincell_tests::{Running, chaincell, scene, turn};

use super::page::{Block, Page, pages};

/// Longest time for the blocks of a page.
const AT_MOST: Duration = Duration::from_secs(120);
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
    let program = chaincell();
    let folder = std::path::Path::new(program.get_program()).parent().unwrap();
    let others = std::env::var_os("PATH").unwrap();
    let path = std::iter::once(folder.to_owned()).chain(std::env::split_paths(&others));
    let path = std::env::join_paths(path).unwrap();
    let mut lines = 0;
    for page in pages() {
        let script = script(&page);
        if script.is_empty() {
            continue;
        }
        lines += script.lines().count();
        let _turn = turn();
        let scratch = scratch();
        let own = format!("--scene {}", scene("docs"));
        let script = script.replace(SCENE, &own);
        let running = Running::start(
            Command::new("bash")
                .args(["-euo", "pipefail", "-c", &(LATE_IS_FINE.to_owned() + &script)])
                .current_dir(scratch.path())
                .env("PATH", &path)
                .env_remove("CHAINCELL_LOG"),
        );
        let ended = running.end(AT_MOST);
        assert_eq!(ended.code, Some(0), "{}:\n{script}\n{ended:#?}", page.path);
    }
    assert!(lines > 10, "only {lines} lines of shell were found");
}
