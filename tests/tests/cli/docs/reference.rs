//! Tables of `host/REFERENCE.md`: flags, and layouts of messages.

use std::collections::BTreeMap;
use std::fmt::Debug;

use chaincell_client::contacts::{Contact, ContactsHeader};
use chaincell_client::payload::{CommandMessage, NodePosition, ReplyMessage, StateHeader};
use chaincell_client::tools::{OneToolForce, OneToolPose, ToolForces, ToolPoses};
use chaincell_host::engine::flag_ticks::FlagTicks;
use chaincell_kernel::Flags;

use super::page::pages;

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

#[test]
fn the_reference_has_every_flag() {
    let rows = rows(&reference(), "flag");
    for (bit, rest) in &rows {
        let mut ticks = FlagTicks::default();
        ticks.add(Flags(bit.parse().unwrap()));
        let name = rest.split(" |").next().unwrap();
        assert_eq!(serde_json::to_string(&ticks).unwrap(), format!(r#"{{"{name}":1}}"#), "{bit}");
    }
    let named: u32 = rows.keys().map(|bit| bit.parse::<u32>().unwrap()).sum();
    assert_eq!(named, 0xfff, "not every flag is named");
}

/// Bytes of a field's type, such as `f32 x 3`.
fn bytes(kind: &str) -> usize {
    let (each, count) = kind.split_once(" x ").unwrap_or((kind, "1"));
    let each = match each {
        "u64" => 8,
        "u32" | "f32" => 4,
        other => other.parse().unwrap(),
    };
    each * count.parse::<usize>().unwrap()
}

/// What is wrong with a row: its offsets follow from its types, and its fields are those of the struct.
fn fault<Message: Default + Debug>(row: &str) -> Option<String> {
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
    (own != names).then(|| format!("the fields are {own:?}"))
}

#[test]
fn the_reference_has_every_layout() {
    let rows = rows(&reference(), "message");
    let faults = [
        ("chaincell.ToolPoses.v2", fault::<ToolPoses> as fn(&str) -> _),
        ("one of its tools", fault::<OneToolPose>),
        ("chaincell.ToolForces.v2", fault::<ToolForces>),
        ("one of these tools", fault::<OneToolForce>),
        ("chaincell.State.v2", fault::<StateHeader>),
        ("chaincell.NodePosition.v1", fault::<NodePosition>),
        ("chaincell.Contacts.v1", fault::<ContactsHeader>),
        ("chaincell.Contact.v1", fault::<Contact>),
        ("chaincell.Command.v1", fault::<CommandMessage>),
        ("chaincell.Reply.v1", fault::<ReplyMessage>),
    ];
    assert_eq!(rows.len(), faults.len());
    for (message, fault) in faults {
        assert_eq!(fault(&rows[message]), None, "{message}");
    }
    let state = &rows["chaincell.State.v2"];
    assert!(fault::<StateHeader>(&state.replace("24 nodes", "24 cells")).is_some());
    assert!(fault::<StateHeader>(&state.replace("28 flags u32", "28 flags u64")).is_some());
}
