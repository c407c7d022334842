//! The committed header is what the sources say.
//!
//! `CHAINCELL_HEADER=renew cargo test -p chaincell-client-ffi --test header` writes it anew.
#![allow(clippy::unwrap_used)]

#[path = "../../../../kernel/ffi/tests/header/written.rs"]
mod written;

use chaincell_client::Notes;
use chaincell_client_ffi::Code;
use written::{Header, codes, defines};

fn header() -> Header {
    let notes = Notes::ALL.iter().map(|&(note, name, meaning)| (note.0, name, meaning));
    let all = Code::ALL.iter().map(|&(code, name, meaning)| (code as i32, name, meaning));
    Header {
        package: env!("CARGO_MANIFEST_DIR"),
        name: "chaincell-client-ffi",
        path: "include/chaincell_client.h",
        tables: defines("CHAINCELL_CLIENT_NOTE_", notes)
            + &codes("chaincell_client_code", Code::MEANING, all),
    }
}

#[test]
fn the_header_is_what_the_sources_say() {
    header().check();
}

#[test]
fn every_name_is_the_librarys_own() {
    header().check_names(20);
}
