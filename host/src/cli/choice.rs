//! Choices on the command line: one parser for all, and what help says of each value.

use chaincell_kernel::Choice;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Takes the names of a choice, and lists them with their meaning.
pub fn parser<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    names(T::TABLE).try_map(|name| T::from_name(&name).ok_or("no such value"))
}

/// Takes the names of a table of choices.
pub fn names(table: &[(u16, &'static str, &'static str)]) -> PossibleValuesParser {
    let value = |&(_, name, meaning): &(u16, &'static str, &'static str)| {
        PossibleValue::new(name).help(prose(meaning))
    };
    PossibleValuesParser::new(table.iter().map(value))
}

/// The first paragraph of a meaning in a line, as help has it: without a full stop and the marks of the
/// documentation.
pub fn prose(meaning: &str) -> String {
    let paragraph = meaning.split("\n\n").next().unwrap_or_default();
    let line = paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
    line.trim_end_matches('.').replace(['`', '\\'], "")
}

#[cfg(test)]
mod tests {
    use chaincell_kernel::stage::Device;
    use chaincell_kernel::{Arithmetic, Drive, Scheme, Unloading};

    use super::*;
    use crate::session::loops::wait::Wait;

    #[track_caller]
    fn is_complete<T: Choice + Send + Sync + std::fmt::Debug>() {
        let command = || {
            clap::Command::new("chaincell").arg(clap::Arg::new("of").value_parser(parser::<T>()))
        };
        for &value in T::ALL {
            let found = command().try_get_matches_from(["chaincell", value.name()]).unwrap();
            assert_eq!(found.get_one("of"), Some(&value));
            assert_eq!(T::from_code(value.code()), Some(value));
        }
        let refused = command().try_get_matches_from(["chaincell", "neither"]).unwrap_err();
        let help =
            command().render_long_help().to_string().replace(|c: char| c.is_whitespace(), "");
        for (_, name, meaning) in T::TABLE {
            assert!(refused.to_string().contains(name), "{refused}");
            let text = prose(meaning).replace(|c: char| c.is_whitespace(), "");
            assert!(help.contains(&format!("{name}:{text}")), "{help}");
        }
    }

    #[test]
    fn every_value_is_taken_named_where_another_is_given_and_explained_by_help() {
        is_complete::<Scheme>();
        is_complete::<Arithmetic>();
        is_complete::<Unloading>();
        is_complete::<Drive>();
        is_complete::<Device>();
        is_complete::<Wait>();
    }
}
