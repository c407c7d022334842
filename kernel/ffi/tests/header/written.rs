//! A C header as its sources and the tables of flags and codes say, compared with the committed one.

use std::fmt::Write;
use std::path::Path;

use similar::TextDiff;

/// A header and where it is from.
pub struct Header {
    /// The folder of the package.
    pub package: &'static str,
    /// The package's name.
    pub name: &'static str,
    /// The header's path in it.
    pub path: &'static str,
    /// What is written from tables.
    pub tables: String,
}

/// The documentation of a line of a table.
pub fn comment(meaning: &str, indent: &str) -> String {
    let lines: String = meaning.lines().map(|line| format!("{indent} *{line}\n")).collect();
    format!("{indent}/**\n{lines}{indent} */\n")
}

/// A macro for each flag: bits, name and meaning.
pub fn defines<'a>(prefix: &str, flags: impl Iterator<Item = (u32, &'a str, &'a str)>) -> String {
    flags.fold(String::new(), |mut text, (bits, name, meaning)| {
        write!(text, "\n{}#define {prefix}{name} {bits}\n", comment(meaning, "")).unwrap();
        text
    })
}

/// An enum of codes: numbers, names and meanings.
pub fn codes<'a>(
    name: &str,
    meaning: &str,
    codes: impl Iterator<Item = (i32, &'a str, &'a str)>,
) -> String {
    let prefix = name.to_uppercase();
    let values: String = codes
        .map(|(code, name, meaning)| {
            let capital = |at: usize, letter: char| at > 0 && letter.is_uppercase();
            let words = name.char_indices().map(|(at, letter)| {
                format!("{}{letter}", if capital(at, letter) { "_" } else { "" }).to_uppercase()
            });
            let words: String = words.collect();
            format!("{}    {prefix}_{words} = {code},\n", comment(meaning, "    "))
        })
        .collect();
    let comment = comment(meaning, "");
    format!(
        "
{comment}enum {name}
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {{
{values}}};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum {name} {name};
#else
typedef int32_t {name};
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus
"
    )
}

impl Header {
    /// The text that the sources say.
    fn wanted(&self) -> String {
        let package = Path::new(self.package);
        let mut config = cbindgen::Config::from_file(package.join("cbindgen.toml")).unwrap();
        config.after_includes.get_or_insert_default().push_str(&self.tables);
        let source = package.join("src/lib.rs");
        let builder = cbindgen::Builder::new().with_config(config).with_src(source);
        let mut header = Vec::new();
        builder.generate().unwrap().write(&mut header);
        // Rustdoc wants units in escaped brackets, C readers do not.
        let header = String::from_utf8(header).unwrap().replace("\\[", "[").replace("\\]", "]");
        header.replace(" * # Safety", " * Safety")
    }

    /// Fails if the committed header differs, after it was renewed if that is asked for.
    pub fn check(&self) {
        let path = Path::new(self.package).join(self.path);
        let wanted = self.wanted();
        if std::env::var("CHAINCELL_HEADER").is_ok_and(|value| value == "renew") {
            std::fs::write(&path, &wanted).unwrap();
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        let diff = TextDiff::from_lines(&committed, &wanted);
        assert!(
            committed == wanted,
            "{} is not what the sources say:\n{}\nrenew it with\n  \
             CHAINCELL_HEADER=renew cargo test -p {} --test header",
            self.path,
            diff.unified_diff().header("committed", "sources"),
            self.name
        );
    }

    /// Fails if a name is not the library's own: a C program has one space of names for all it includes.
    pub fn check_names(&self, least: usize) {
        let header = self.wanted();
        let macros = header.lines().filter_map(|line| line.strip_prefix("#define "));
        let functions =
            header.lines().filter_map(|line| line.strip_prefix("typedef ")?.split("(*").nth(1));
        let types = header
            .lines()
            .filter_map(|line| line.strip_prefix("} ").filter(|line| line.ends_with(';')));
        let names: Vec<&str> = macros.chain(functions).chain(types).collect();
        let is_own = |name: &&&str| name.to_lowercase().starts_with("chaincell_");
        let foreign: Vec<&&str> = names.iter().filter(|name| !is_own(name)).collect();
        assert!(names.len() > least && foreign.is_empty(), "{foreign:?}");
    }
}
