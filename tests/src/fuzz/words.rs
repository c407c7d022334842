//! Selectors, files of ids and measured targets.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

use chaincell_host::mesh::select;
use chaincell_lab::experiments::target::{Holding, parse};
use tempfile::NamedTempFile;

const NODES_M: [[f64; 3]; 4] =
    [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.2, 0.0], [-0.1, 0.2, 0.3]];

thread_local! {
    static FILE: RefCell<NamedTempFile> = RefCell::new(NamedTempFile::new().unwrap());
}

/// First letter `s`: a selector; `f`: a line with the key, then a file of ids; else a target.
pub fn words(data: &[u8]) {
    let Some((&first, rest)) = data.split_first() else { return };
    match (first, std::str::from_utf8(rest)) {
        // Files of the machine are no input of a fuzzer.
        (b's', Ok(text)) if !text.starts_with("file:") => choose(text),
        (b's', _) => {}
        (b'f', _) => file(rest),
        (_, Ok(text)) => target(text),
        (_, Err(_)) => {}
    }
}

fn choose(text: &str) {
    let groups = BTreeMap::from([("top".to_owned(), vec![2, 3]), ("7".to_owned(), vec![0])]);
    match select(text, &NODES_M, &groups, &[0, 1], "--fix") {
        Ok(ids) => {
            assert!(!ids.is_empty() && ids.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(ids.iter().all(|&id| (id as usize) < NODES_M.len()), "{ids:?}");
        }
        Err(why) => assert!(why.exit_code() == 2 && why.to_string().starts_with("--fix ")),
    }
}

/// The file stands under one name; the key comes from the bytes.
fn file(data: &[u8]) {
    let end = data.iter().position(|&byte| byte == b'\n').unwrap_or(data.len());
    let (key, content) = data.split_at(end);
    let Ok(key) = std::str::from_utf8(key) else { return };
    FILE.with_borrow_mut(|file| {
        file.as_file().set_len(0).unwrap();
        file.rewind().unwrap();
        file.write_all(content.get(1..).unwrap_or(&[])).unwrap();
        let mark = if key.is_empty() { "" } else { "#" };
        choose(&format!("file:{}{mark}{key}", file.path().display()));
    });
}

fn target(text: &str) {
    let full = Holding { displacement_m: Some(0.01), force_n: Some(1.0) };
    for holding in [Holding::default(), full] {
        match parse(text, "fuzz.csv", &holding) {
            Ok(targets) => {
                for target in targets {
                    assert!(target.observed.iter().all(|x| x.is_finite()));
                    assert!(target.observed.len() == target.rows() * target.width());
                    assert!(target.scale() > 0.0, "{target:?}");
                }
            }
            Err(why) => assert!(why.exit_code() == 2, "{why}"),
        }
    }
}
