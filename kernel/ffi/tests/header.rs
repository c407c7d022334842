//! The committed header is what the sources say.
//!
//! `CHAINCELL_HEADER=renew cargo test -p chaincell-ffi --test header` writes it anew.
#![allow(clippy::unwrap_used)]

#[path = "header/written.rs"]
mod written;

use chaincell_ffi::Code;
use chaincell_kernel::Flags;
use written::{Header, codes, defines};

fn header() -> Header {
    let flags = Flags::ALL.iter().map(|&(flag, name, meaning)| (flag.0, name, meaning));
    let all = Code::ALL.iter().map(|&(code, name, meaning)| (code as i32, name, meaning));
    Header {
        package: env!("CARGO_MANIFEST_DIR"),
        name: "chaincell-ffi",
        path: "include/chaincell.h",
        tables: defines("CHAINCELL_FLAG_", flags) + &codes("chaincell_code", Code::MEANING, all),
    }
}

// REQ-CIF-06
#[test]
fn the_header_is_what_the_sources_say() {
    header().check();
}

#[test]
fn every_name_is_the_librarys_own() {
    header().check_names(30);
}
