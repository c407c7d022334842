//! Node selectors: what they pick and why they are refused.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeMap;

use chaincell_host::error::Result;
use chaincell_host::mesh::select;

const NODES: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.2, 0.0], [-0.1, 0.2, 0.3]];

fn pick(text: &str) -> Result<Vec<u32>> {
    let groups = [("top".to_string(), vec![2, 3]), ("7".to_string(), vec![0])].into();
    select(text, &NODES, &groups, &[0, 1], "`fix`")
}

#[track_caller]
fn refused(text: &str, part: &str) {
    let error = pick(text).unwrap_err().to_string();
    assert!(error.starts_with("`fix` ") && error.contains(part), "{text}: {error}");
}

#[test]
fn lists_boxes_groups_and_border() {
    assert_eq!(pick("nodes:3, 0").unwrap(), [0, 3]);
    assert_eq!(pick("2,1").unwrap(), [1, 2]);
    assert_eq!(pick("border").unwrap(), [0, 1]);
    assert_eq!(pick("group:top").unwrap(), [2, 3]);
    assert_eq!(pick("box:0,0.1,-1,0,0,0").unwrap(), [0, 1]);
}

#[test]
fn refusals() {
    refused("nodes:4", "'4' is no node; ids are whole numbers from 0 to 3");
    refused("-1", "'-1' is no node");
    refused("0,+1", "'+1' is no node");
    refused("99999999999999999999", "is no node");
    refused("nodes:", "'' is no node");
    refused("0,,1", "'' is no node");
    refused("1,2,1", "node 1 is given twice");
    refused("everything", "unknown selector");
    refused("", "unknown selector");
    refused("border:1", "unknown selector");
    refused("group:bottom", "its groups: 7, top");
    refused("box:0,1,0,1", "there are 4");
    refused("box:0,1,0,1,0,NaN", "z1 is 'NaN'");
    refused("box:0,1,2,1,0,1", "y0 is above y1");
    refused("box:5,6,0,1,0,1", "selects no node");
    let none = select("border", &NODES, &BTreeMap::new(), &[], "`fix`").unwrap_err();
    assert!(none.to_string().contains("only a plane has a border"));
}

#[test]
fn files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        format!("file:{}", path.display())
    };
    assert_eq!(pick(&write("a", b"3 1,\n0\n")).unwrap(), [0, 1, 3]);
    assert_eq!(pick(&write("b", b" [2, 0]")).unwrap(), [0, 2]);
    assert_eq!(pick(&write("has#mark", b"1")).unwrap(), [1]);
    let sets = write("sets.json", br#"{"fixed":[1,3],"node":2,"none":[],"bad":[0,1.5]}"#);
    assert_eq!(pick(&format!("{sets}#fixed")).unwrap(), [1, 3]);
    refused(&format!("{sets}#other"), "its keys: bad, fixed, node, none");
    refused(&sets, "add #KEY, one of: bad, fixed");
    refused(&format!("{sets}#node"), "sets.json#node is no array");
    refused(&format!("{sets}#none"), "selects no node");
    refused(&format!("{sets}#bad"), "item 1: '1.5' is no node");
    refused(&write("c", b"0\n\n1 x"), "c:3: 'x' is no node");
    refused(&write("d", b"0 1 0"), "node 0 is given twice");
    refused(&write("e", b""), "selects no node");
    refused(&write("f", b"[0, "), "no valid JSON");
    refused(&write("g", b"\xff"), "cannot read");
    refused(&format!("{}#k", write("h", b"[0]")), "leave #KEY out");
    refused(&format!("{}#k", write("i", b"0 1")), "i: ");
    refused("file:no-such", "cannot read no-such");
}
