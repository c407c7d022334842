//! Tables of `host/REFERENCE.md`: flags, settings, and layouts of messages; and the flags and settings of the Python
//! package.

use std::collections::BTreeMap;
use std::fmt::Debug;

use chaincell_client::Notes;
use chaincell_client::contacts::{Contact, ContactsHeader};
use chaincell_client::payload::{CommandMessage, NodePosition, ReplyMessage, StateHeader};
use chaincell_client::stress::{NodeStress, StressHeader};
use chaincell_client::surface::{SurfaceHeader, SurfaceRow};
use chaincell_client::tools::{OneToolForce, OneToolPose, ToolForces, ToolPoses};
use chaincell_kernel::{Flags, SettingField, SettingKind, Settings};

use super::page::{pages, top};

/// The source of the reference.
pub fn reference() -> String {
    pages().into_iter().find(|page| page.path == "host/REFERENCE.md").unwrap().text
}

/// The rows of the table whose first column has this header: the first cell without code marks, and the
/// others as one text.
pub fn rows(page: &str, header: &str) -> BTreeMap<String, String> {
    let mut lines = page.lines().skip_while(|line| !line.starts_with(&format!("| {header} |")));
    assert!(lines.next().is_some(), "no table of {header}");
    let rows = lines.skip(1).take_while(|line| line.starts_with('|'));
    let plain = |line: &str| line.trim_matches('|').replace('`', "");
    let row = |line: &str| {
        let line = plain(line);
        let (first, rest) = line.split_once('|').unwrap();
        (first.trim().to_owned(), rest.trim().to_owned())
    };
    rows.map(row).collect()
}

/// Fails if a file is not what the tables say; `CHAINCELL_PAGES=renew` writes it anew.
fn check(path: &str, wanted: impl Fn(&str) -> String) {
    let file = top().join(path);
    let text = std::fs::read_to_string(&file).unwrap();
    let wanted = wanted(&text);
    if std::env::var("CHAINCELL_PAGES").is_ok_and(|value| value == "renew") {
        std::fs::write(&file, &wanted).unwrap();
        return;
    }
    let other = wanted.lines().find(|line| !text.lines().any(|one| one == *line));
    assert!(
        text == wanted,
        "{path}: renew it with CHAINCELL_PAGES=renew, the table says {other:?}"
    );
}

/// A meaning in one line.
fn line(meaning: &str) -> String {
    meaning.split_whitespace().collect::<Vec<_>>().join(" ").replace('\\', "")
}

/// Puts a table in place of the one with this first column.
fn with_table(text: &str, header: &str, table: &str) -> String {
    let start = text.find(&format!("| {header} |")).unwrap();
    let end = start + text[start..].find("\n\n").unwrap() + 1;
    text[..start].to_owned() + table + &text[end..]
}

#[test]
fn the_reference_has_every_flag() {
    let rows = Flags::ALL.iter().map(|(flag, name, meaning)| {
        format!("| {} | `{}` | {} |\n", flag.0, name.to_lowercase(), line(meaning))
    });
    let table = "| flag | name | meaning |\n|---|---|---|\n".to_owned() + &rows.collect::<String>();
    check("host/REFERENCE.md", |text| with_table(text, "flag", &table));
}

#[test]
fn the_reference_has_every_setting() {
    let rows = Settings::FIELDS.iter().map(|field| {
        let SettingField { name, default, .. } = field;
        format!("| `{name}` | {default} | {} |\n", line(field.meaning))
    });
    let head = "| setting | default | meaning |\n|---|---|---|\n".to_owned();
    let table = head + &rows.collect::<String>();
    check("host/REFERENCE.md", |text| with_table(text, "setting", &table));
}

/// A text with lines of at most 96 bytes between quotes that open and close a documentation of Python.
fn python_doc(text: &str) -> String {
    let mut lines = vec![String::from("\"\"\"")];
    for word in text.split(' ') {
        let last = lines.last_mut().unwrap();
        if last.len() + word.len() > 92 {
            lines.push(word.to_owned());
        } else {
            let gap = if last.ends_with('"') { "" } else { " " };
            last.push_str(&format!("{gap}{word}"));
        }
    }
    lines.join("\n    ") + "\"\"\""
}

#[test]
fn python_has_every_setting() {
    let with_option = Settings::FIELDS.iter().filter(|field| !field.value.is_empty());
    let arguments = with_option.map(|field| {
        let kind = match field.kind {
            SettingKind::Whole => "int".to_owned(),
            SettingKind::Real => "float".to_owned(),
            SettingKind::Choice(table) => {
                let names: Vec<_> =
                    table.iter().map(|(_, name, _)| format!("\"{name}\"")).collect();
                format!("Literal[{}]", names.join(", "))
            }
        };
        let doc = python_doc(&format!("{} Default: {}.", line(field.meaning), field.default));
        format!("    {}: {kind} | None\n    {doc}\n", field.name)
    });
    let arguments: String = arguments.collect();
    check("host/python/python/chaincell/options.py", |text| {
        let start = text.find("    sweeps:").unwrap();
        let end = text.find("    time_constant_s:").unwrap();
        text[..start].to_owned() + &arguments + &text[end..]
    });
}

#[test]
fn python_has_every_flag() {
    let member = |bit: u32, name: &str, meaning: &str| {
        let meaning: Vec<&str> = meaning.lines().map(str::trim).collect();
        format!("    {name} = {bit}\n    \"\"\"{}\"\"\"\n", meaning.join("\n    "))
    };
    let flags = Flags::ALL.iter().map(|(flag, name, meaning)| member(flag.0, name, meaning));
    let notes = Notes::ALL.iter().map(|(note, name, meaning)| member(note.0, name, meaning));
    let (flags, notes) = (flags.collect::<String>(), notes.collect::<String>());
    let wanted = format!(
        r#""""Flags and notes of a tick, sums of bits. Written from the tables of the kernel and the client: change them
there."""

from enum import IntFlag


class Flags(IntFlag):
    """Limits and faults that acted during a tick."""

{flags}

class Notes(IntFlag):
    """Notes of the client itself on an answer."""

{notes}"#
    );
    check("host/python/python/chaincell/flags.py", |_| wanted.clone());
}

/// Bytes of a field's type, such as `f32 x 3`.
fn bytes(kind: &str) -> usize {
    let (each, count) = kind.split_once(" x ").unwrap_or((kind, "1"));
    let each = match each {
        "u64" => 8,
        "u32" | "f32" => 4,
        "u16" => 2,
        other => other.parse().unwrap(),
    };
    each * count.parse::<usize>().unwrap()
}

/// What is wrong with a row: its offsets follow from its types, its fields are those of the struct, and the
/// struct is sent by the name of the row.
fn fault<Message: Default + Debug>(name: &str, row: &str) -> Option<String> {
    let (size, fields) = row.split_once(" | ").unwrap();
    let mut offset = 0;
    let mut names = Vec::new();
    for field in fields.split(", ") {
        let (at, rest) = field.split_once(' ').unwrap();
        let (name, kind) = rest.split_once(' ').unwrap();
        if at != offset.to_string() {
            return Some(format!("{name} stands at {offset}, not {at}"));
        }
        offset += bytes(kind);
        names.push(name);
    }
    let wanted = size_of::<Message>();
    if offset != wanted || size != wanted.to_string() {
        return Some(format!("{size} bytes, the fields have {offset}, the message {wanted}"));
    }
    let shown = format!("{:#?}", Message::default());
    let own = |line: &str| Some(line.strip_prefix("    ")?.split_once(':')?.0.to_owned());
    let own: Vec<_> = shown.lines().filter_map(own).filter(|name| !name.starts_with(' ')).collect();
    if own != names {
        return Some(format!("the fields are {own:?}"));
    }
    let own = std::any::type_name::<Message>().rsplit("::").next().unwrap();
    let sent = format!("#[type_name(\"{name}\")]\n#[repr(C)]\npub struct {own} {{");
    let sources = ["contacts", "payload", "stress", "surface", "tools"]
        .map(|name| format!("host/client/src/{name}.rs"));
    let mut texts = sources.iter().map(|path| std::fs::read_to_string(top().join(path)).unwrap());
    let is_sent = !name.starts_with("chaincell.") || texts.any(|text| text.contains(&sent));
    (!is_sent).then(|| format!("{own} is not sent by this name"))
}

#[test]
fn the_reference_has_every_layout() {
    let rows = rows(&reference(), "message");
    let faults = [
        ("chaincell.ToolPoses.v2", fault::<ToolPoses> as fn(&str, &str) -> _),
        ("one of its tools", fault::<OneToolPose>),
        ("chaincell.ToolForces.v2", fault::<ToolForces>),
        ("one of these tools", fault::<OneToolForce>),
        ("chaincell.State.v2", fault::<StateHeader>),
        ("chaincell.NodePosition.v1", fault::<NodePosition>),
        ("chaincell.Stress.v1", fault::<StressHeader>),
        ("chaincell.NodeStress.v1", fault::<NodeStress>),
        ("chaincell.Surface.v1", fault::<SurfaceHeader>),
        ("chaincell.SurfaceRow.v1", fault::<SurfaceRow>),
        ("chaincell.Contacts.v1", fault::<ContactsHeader>),
        ("chaincell.Contact.v1", fault::<Contact>),
        ("chaincell.Command.v2", fault::<CommandMessage>),
        ("chaincell.Reply.v1", fault::<ReplyMessage>),
    ];
    assert_eq!(rows.len(), faults.len());
    for (message, fault) in faults {
        assert_eq!(fault(message, &rows[message]), None, "{message}");
    }
    let state = "chaincell.State.v2";
    let row = &rows[state];
    assert!(fault::<StateHeader>(state, &row.replace("24 nodes", "24 cells")).is_some());
    assert!(fault::<StateHeader>(state, &row.replace("28 flags u32", "28 flags u64")).is_some());
    assert!(fault::<StateHeader>("chaincell.State.v1", row).is_some());
}
