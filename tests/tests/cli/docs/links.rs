//! Links: to files of the tree and to headings of pages; others are not followed.

use super::page::{Page, pages, top};

/// What is wrong with the links of one of the pages.
fn faults(page: &Page, all: &[Page]) -> Vec<String> {
    let check = |link: &String| {
        if link.starts_with("https://") {
            return None;
        }
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let wrong = |why: &str| Some(format!("{}: link {link}: {why}", page.path));
        let Some(path) = resolve(&page.path, file) else { return wrong("leaves the tree") };
        let found = all.iter().find(|other| other.path == path);
        if found.is_none() && !top().join(&path).exists() {
            return wrong("there is no such file");
        }
        match found {
            _ if anchor.is_empty() => None,
            None => wrong("an anchor in something that is no page"),
            Some(found) if !found.anchors.contains(anchor) => wrong("there is no such heading"),
            Some(_) => None,
        }
    };
    page.links.iter().filter_map(check).collect()
}

/// The path from the top folder of a link in a page; `None` where it leads out of it.
fn resolve(page: &str, link: &str) -> Option<String> {
    if link.is_empty() {
        return Some(page.into());
    }
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in link.split('/').filter(|part| !part.is_empty() && *part != ".") {
        if part == ".." {
            parts.pop()?;
        } else {
            parts.push(part);
        }
    }
    Some(parts.join("/"))
}

#[test]
fn every_link_leads_somewhere() {
    let pages = pages();
    let faults: Vec<String> = pages.iter().flat_map(|page| faults(page, &pages)).collect();
    assert!(faults.is_empty(), "\n  {}", faults.join("\n  "));
    assert!(pages.iter().map(|page| page.links.len()).sum::<usize>() > 10, "no links were read");
}

#[test]
fn a_broken_link_is_seen() {
    let other = Page::parse("kernel/README.md", "# Here\n");
    for (link, expected) in [
        ("README.md", None),
        ("README.md#here", None),
        ("#there", None),
        ("../host/src", None),
        ("https://example.org/x#y", None),
        ("README.md#gone", Some("no such heading")),
        ("#gone", Some("no such heading")),
        ("GONE.md", Some("no such file")),
        ("../../x", Some("leaves the tree")),
        ("Cargo.toml#x", Some("is no page")),
        ("http://example.org", Some("no such file")),
    ] {
        let page = Page::parse("kernel/PAGE.md", &format!("# There\n\n[text]({link})\n"));
        let all = [Page::parse(&page.path, &page.text), Page::parse(&other.path, &other.text)];
        let found = faults(&page, &all);
        match expected {
            None => assert!(found.is_empty(), "{link}: {found:?}"),
            Some(why) => assert!(found.len() == 1 && found[0].contains(why), "{link}: {found:?}"),
        }
    }
}
