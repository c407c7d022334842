//! The committed header is what the sources say.
//!
//! `CHAINCELL_HEADER=renew cargo test -p chaincell-ffi --test header` writes it anew.
#![allow(clippy::unwrap_used)]

#[path = "header/written.rs"]
mod written;

use chaincell_ffi::Code;
use chaincell_kernel::stage::{Device, StageSettings};
use chaincell_kernel::{
    Choice, Cutting, Drive, Flags, SettingField, SettingKind, Settings, Unloading,
};
use written::{Header, codes, comment, defines};

/// A struct of settings; choices stand in it with their codes.
fn settings(name: &str, meaning: &str, fields: &[SettingField]) -> String {
    let fields: String = fields
        .iter()
        .map(|field| {
            let (kind, more) = match field.kind {
                SettingKind::Whole => ("uint32_t", String::new()),
                SettingKind::Real => ("float", String::new()),
                SettingKind::Choice(_) => {
                    // `chaincell_cut` is a function.
                    let name = if field.name == "cut" { "cutting" } else { field.name };
                    ("int32_t", format!(" One of `chaincell_{name}`.\n"))
                }
            };
            let comment = comment(&format!("{}{more}", field.meaning), "    ");
            format!("{comment}    {kind} {};\n", field.name)
        })
        .collect();
    format!("\n{}typedef struct {name} {{\n{fields}}} {name};\n", comment(meaning, ""))
}

/// An enum of a kernel's choice.
fn choice<T: Choice>(name: &str, meaning: &str) -> String {
    let values = T::TABLE.iter().map(|&(code, name, meaning)| {
        // Examples follow the first paragraph.
        (code.into(), name, meaning.split("\n\n").next().unwrap())
    });
    codes(name, meaning, values)
}

fn header() -> Header {
    let flags = Flags::ALL.iter().map(|&(flag, name, meaning)| (flag.0, name, meaning));
    let all = Code::ALL.iter().map(|&(code, name, meaning)| (code as i32, name, meaning));
    Header {
        package: env!("CARGO_MANIFEST_DIR"),
        name: "chaincell-ffi",
        path: "include/chaincell.h",
        tables: [
            defines("CHAINCELL_FLAG_", flags),
            codes("chaincell_code", Code::MEANING, all),
            choice::<Device>("chaincell_device", " A haptic device by its published limits."),
            choice::<Unloading>("chaincell_unloading", " When the links' bands close."),
            choice::<Drive>("chaincell_drive", " Effect of the tool's displacement."),
            choice::<Cutting>("chaincell_cutting", " Cutting by blades and tearing."),
            settings("chaincell_settings", " Parameters of a run.", &Settings::FIELDS),
            settings(
                "chaincell_stage_settings",
                " Settings of the output stage; each part may be absent.",
                StageSettings::FIELDS,
            ),
        ]
        .concat(),
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
