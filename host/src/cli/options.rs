//! Refusals in the words of the command line.

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Args, Command, Id};

use super::inject::InjectArgs;
use super::settings::SettingArgs;
use super::shared::SilenceArgs;
use super::stage::StageArgs;
use crate::terminal;

/// Reads the arguments of this process; ends it where they ask for help or are refused.
pub fn read(command: Command) -> ArgMatches {
    in_short(command).try_get_matches().unwrap_or_else(|why| {
        if why.kind() != ErrorKind::ValueValidation {
            why.exit();
        }
        terminal::note(numbers_in_words(why.to_string().trim_end()));
        std::process::exit(why.exit_code())
    })
}

/// The command with a page for `-h`: of each option the first clause, and none of those that only a device, a
/// fault on purpose or a scheme needs. `--help` has all of it.
fn in_short(command: Command) -> Command {
    let rare: Vec<Id> = [
        StageArgs::augment_args(Command::new("stage")),
        InjectArgs::augment_args(Command::new("inject")),
        SettingArgs::augment_args(Command::new("settings")),
        SilenceArgs::augment_args(Command::new("silence")),
    ]
    .iter()
    .flat_map(Command::get_arguments)
    .map(|option| option.get_id().clone())
    .collect();
    let of_one = |option: Arg| {
        let help = option.get_help().map(ToString::to_string).unwrap_or_default();
        let is_hidden = rare.contains(option.get_id());
        let short = first_clause(&help).to_owned();
        option.long_help(help).help(short).hide_short_help(is_hidden)
    };
    let names: Vec<String> = command.get_subcommands().map(|of| of.get_name().to_owned()).collect();
    names.iter().fold(command, |command, name| {
        command.mut_subcommand(name, |of| {
            let examples = of.get_after_help().cloned().unwrap_or_default();
            of.mut_args(of_one).after_long_help(examples).after_help(MORE)
        })
    })
}

/// The last line of `-h`.
const MORE: &str = "--help says more of each option, has the rare ones, and examples";

/// A help text up to its first colon, semicolon, full stop, bracket or default, if that leaves a clause.
fn first_clause(help: &str) -> &str {
    let ends = [": ", "; ", ". ", " (", " [default"].iter().filter_map(|end| help.find(end));
    let end = ends.filter(|end| *end >= SHORTEST).min().unwrap_or(help.len());
    help.get(..end).unwrap_or(help)
}

/// Fewest bytes of a clause that says something.
const SHORTEST: usize = 12;

/// A refusal with a remedy in place of what Rust says of a bad number.
fn numbers_in_words(text: &str) -> String {
    if let Some(text) = range_in_words(text) {
        return text;
    }
    [
        ("invalid digit found in string", "give a whole number, as in 4"),
        ("cannot parse integer from empty string", "give a whole number, as in 4"),
        ("invalid float literal", "give a number, as in 0.01"),
        ("cannot parse float from empty string", "give a number, as in 0.01"),
        ("number too large to fit in target type", "the number is too large"),
        ("number too small to fit in target type", "the number is too small"),
    ]
    .into_iter()
    .fold(text.to_owned(), |text, (said, remedy)| text.replace(said, remedy))
}

/// The refusal of a number that `is not in` a range of Rust.
fn range_in_words(text: &str) -> Option<String> {
    let (before, after) = text.split_once(" is not in ")?;
    let (range, after) = after.split_once('\n').unwrap_or((after, ""));
    let (least, most) = range.split_once("..")?;
    let most = most.trim_start_matches('=');
    let (before, _) = before.rsplit_once(": ")?;
    let range = match most.parse::<u64>() {
        Ok(u64::MAX) => format!("at least {least}"),
        _ => format!("from {least} to {most}"),
    };
    Some(format!("{before}: must be {range}\n{after}"))
}

/// A refusal in one line, without the help behind it.
pub(super) fn in_a_line(why: &clap::Error) -> String {
    let text = numbers_in_words(&why.to_string());
    // After the first paragraph it says how to ask for help.
    let text = text.split("\n\n").next().unwrap_or_default();
    let text = text.strip_prefix("error: ").unwrap_or(text);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A message of the library, which names fields in backticks, with every field that an option of these
/// commands sets named as that option.
pub(super) fn named(message: &str, commands: &[Command]) -> String {
    let subcommands = commands.iter().flat_map(Command::get_subcommands);
    let options = subcommands.flat_map(Command::get_arguments);
    let fields = options.filter_map(|option| Some((option.get_id(), option.get_long()?)));
    fields.fold(message.to_owned(), |text, (field, option)| {
        text.replace(&format!("`{field}`"), &format!("--{option}"))
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use clap::CommandFactory;

    use super::*;
    use crate::cli::Cli;

    #[test]
    fn a_bad_number_has_a_remedy() {
        let refused = |args: &[&str]| {
            let why = Cli::command().try_get_matches_from(args).unwrap_err();
            numbers_in_words(&why.to_string())
        };
        let bake = ["chaincell", "bake", "organ", "-o", "x", "--cells"];
        let many = "99999999999999999999999";
        for (value, remedy) in [
            ("2/3", "give a whole number"),
            ("", "give a whole number"),
            (many, "the number is too large"),
        ] {
            let why = refused(&[&bake[..], &[value]].concat());
            assert!(
                why.contains(value) && why.contains("--cells") && why.contains(remedy),
                "{why}"
            );
        }
        for (option, value, range) in [
            ("--load", "-1", "must be from 0 to 65535"),
            ("--sweeps", "70000", "must be from 0 to 65535"),
        ] {
            let why = refused(&["chaincell", "cosim", option, value]);
            assert!(why.contains(range) && why.contains(value) && why.contains(option), "{why}");
        }
        let why = refused(&["chaincell", "serve", "m", "--ticks", "0"]);
        assert!(why.contains("'0' for '--ticks <N>': must be at least 1\n"), "{why}");
        for value in ["x", ""] {
            let why = refused(&["chaincell", "run", "m", "--out", "x", "--friction", value]);
            assert!(why.contains("--friction") && why.contains("give a number"), "{why}");
        }
    }

    #[test]
    fn the_short_help_is_a_page_and_the_long_one_a_book() {
        for name in ["run", "bake", "serve", "control", "cosim"] {
            let mut command = in_short(Cli::command());
            let of_one = command.find_subcommand_mut(name).unwrap();
            let short = of_one.render_help().to_string();
            assert!(short.lines().count() < 60, "{name}: {short}");
            assert!(!short.contains("Example") && short.contains("--help says more"), "{short}");
            let long = of_one.render_long_help().to_string();
            assert!(long.contains("Example") && long.lines().count() > 60, "{name}: {long}");
        }
        assert_eq!(first_clause("Coefficient of friction; 0 for none"), "Coefficient of friction");
        assert_eq!(first_clause("A [m]: b"), "A [m]: b");
        assert_eq!(first_clause("Depth of a press [default: 3]"), "Depth of a press");
    }

    #[test]
    fn fields_become_options_and_other_words_stay() {
        let named = |message| named(message, &[Cli::command()]);
        assert_eq!(named("`alpha` 2: must be in [0, 1)"), "--alpha 2: must be in [0, 1)");
        assert_eq!(named("`saturation_m` or `unit_m`"), "--k-m or --units");
        assert_eq!(named("field tick `7`: alpha, `alpha"), "field tick `7`: alpha, `alpha");
    }

    #[test]
    fn a_field_is_one_option_in_every_command() {
        let command = Cli::command();
        let mut names = BTreeMap::new();
        for option in command.get_subcommands().flat_map(Command::get_arguments) {
            if let Some(long) = option.get_long() {
                let known = names.entry(option.get_id().clone()).or_insert(long);
                assert_eq!(*known, long);
            }
        }
    }
}
