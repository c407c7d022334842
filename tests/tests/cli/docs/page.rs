//! A Markdown page: its anchors, links, fenced blocks and code spans.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

/// The top folder of the tree.
pub fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// A fenced block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// The text behind the fence.
    pub info: String,
    /// The lines of the block.
    pub text: String,
}

/// A page, read once.
#[derive(Debug, Default)]
pub struct Page {
    /// Path from the top folder, with slashes.
    pub path: String,
    /// The source.
    pub text: String,
    /// Names that `#NAME` links to.
    pub anchors: BTreeSet<String>,
    /// Targets of links and pictures.
    pub links: Vec<String>,
    /// Fenced blocks.
    pub blocks: Vec<Block>,
    /// Code within a line.
    pub spans: Vec<String>,
}

/// The anchor that GitHub gives a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase()
}

impl Page {
    /// Reads the source of a page.
    pub fn parse(path: &str, text: &str) -> Self {
        let mut page = Self { path: path.into(), text: text.into(), ..Self::default() };
        let (mut heading, mut block) = (None, None);
        for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => page.add_anchor(&heading.take().unwrap()),
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) => {
                    block = Some(Block { info: info.into_string(), text: String::new() });
                }
                Event::End(TagEnd::CodeBlock) => page.blocks.extend(block.take()),
                Event::Text(text) => {
                    if let Some(block) = &mut block {
                        block.text += &text;
                    } else if let Some(heading) = &mut heading {
                        *heading += &text;
                    }
                }
                Event::Code(code) => {
                    if let Some(heading) = &mut heading {
                        *heading += &code;
                    }
                    page.spans.push(code.into_string());
                }
                _ => {}
            }
        }
        page
    }

    fn add_anchor(&mut self, heading: &str) {
        let first = anchor(heading);
        let mut name = first.clone();
        for number in 1.. {
            if self.anchors.insert(name) {
                return;
            }
            name = format!("{first}-{number}");
        }
    }
}

/// Every Markdown page of the tree.
pub fn pages() -> Vec<Page> {
    let listed = Command::new("git")
        .current_dir(top())
        .args(["ls-files", "--cached", "--others", "--exclude-standard", "*.md"])
        .output()
        .unwrap();
    assert!(listed.status.success(), "{}", String::from_utf8_lossy(&listed.stderr));
    let read = |path: &str| {
        let text = std::fs::read_to_string(top().join(path)).unwrap();
        Page::parse(path, &text)
    };
    let pages: Vec<Page> = String::from_utf8(listed.stdout).unwrap().lines().map(read).collect();
    assert!(pages.len() >= 4, "only {} pages", pages.len());
    pages
}

#[test]
fn a_page_is_read() {
    let text = "# Two words, `code`\n\n# Two words, code\n\n[a](b.md#c) ![d](e.png)\n\n\
                ```sh,no-run: why\nls | wc\n```\n\n| `x \\| y` |\n|---|\n";
    let page = Page::parse("p.md", text);
    assert_eq!(page.anchors, ["two-words-code", "two-words-code-1"].map(String::from).into());
    assert_eq!(page.links, ["b.md#c", "e.png"]);
    assert_eq!(page.blocks, [Block { info: "sh,no-run: why".into(), text: "ls | wc\n".into() }]);
    assert_eq!(page.spans, ["code", "x | y"]);
}
