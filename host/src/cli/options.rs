//! The library's errors name fields, in backticks; the command line names its options.

use clap::Command;

/// A message with every field that an option of these commands sets named as that option.
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
