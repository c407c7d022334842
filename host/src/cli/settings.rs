//! Options of the kernel's settings: one for each line of its table that has one.

use std::sync::LazyLock;

use chaincell_kernel::{SettingField, SettingKind, Settings};
use clap::builder::{TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Command, FromArgMatches};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

use super::choice::{names, prose};

/// Names of the options, without the dashes.
static OPTIONS: LazyLock<[String; Settings::COUNT]> =
    LazyLock::new(|| Settings::FIELDS.map(|field| field.name.replace('_', "-")));

/// The settings that were given, as words.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SettingArgs([Option<u32>; Settings::COUNT]);

impl SettingArgs {
    /// Returns these settings with what was given in place of the defaults.
    pub fn over(&self, defaults: Settings) -> Settings {
        let mut words = defaults.each();
        for (word, given) in words.iter_mut().zip(self.0) {
            *word = given.unwrap_or(*word);
        }
        Settings::from_each(words).unwrap_or(defaults)
    }

    fn given(&self, name: &str) -> Option<(SettingField, u32)> {
        let mut all = Settings::FIELDS.into_iter().zip(self.0);
        all.find(|(field, _)| field.name == name).and_then(|(field, word)| Some((field, word?)))
    }

    /// Returns a real number, if it was given.
    pub fn real(&self, name: &str) -> Option<f32> {
        self.given(name).map(|(_, word)| f32::from_bits(word))
    }

    /// Returns the option of a setting and its value, if it was given.
    pub fn shown(&self, name: &str) -> String {
        let value = self.given(name).map(|(field, word)| format!(" {}", text(&field, word)));
        format!("--{}{}", name.replace('_', "-"), value.unwrap_or_default())
    }
}

/// Returns a value as the command line has it.
fn text(field: &SettingField, word: u32) -> String {
    match field.kind {
        SettingKind::Whole => word.to_string(),
        SettingKind::Real => f32::from_bits(word).to_string(),
        SettingKind::Choice(table) => {
            let found = table.iter().find(|(code, ..)| u32::from(*code) == word);
            found.map_or(String::new(), |(_, name, _)| (*name).to_owned())
        }
    }
}

/// The option of a setting.
fn option((field, long): (&'static SettingField, &'static String)) -> Arg {
    let parser: ValueParser = match field.kind {
        SettingKind::Whole => clap::value_parser!(u16).map(u32::from).into(),
        SettingKind::Real => ValueParser::new(|text: &str| text.parse().map(f32::to_bits)),
        SettingKind::Choice(table) => {
            let word = move |name: String| {
                let found = table.iter().find(|(_, known, _)| *known == name);
                found.map(|(code, ..)| u32::from(*code)).ok_or("no such value")
            };
            names(table).try_map(word).into()
        }
    };
    Arg::new(field.name)
        .long(long.as_str())
        .value_name(field.value)
        .help(format!("{} [default: {}]", prose(field.meaning), field.default))
        .value_parser(parser)
        .allow_negative_numbers(true)
}

impl clap::Args for SettingArgs {
    fn augment_args(command: Command) -> Command {
        static FIELDS: [SettingField; Settings::COUNT] = Settings::FIELDS;
        let all = FIELDS.iter().zip(&*OPTIONS).filter(|(field, _)| !field.value.is_empty());
        command.args(all.map(option))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SettingArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        // A setting without an option is unknown to the matches.
        let given = |field: SettingField| matches.try_get_one(field.name).ok().flatten().copied();
        Ok(Self(Settings::FIELDS.map(given)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The settings in force, for summaries: no limit is null, and `step` is that of a scheme that goes by the tick.
#[derive(Debug, Clone, Copy)]
pub struct SettingReport(pub Settings);

impl Serialize for SettingReport {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        for (field, word) in Settings::FIELDS.iter().zip(self.0.each()) {
            // `sweeps` alone are those that were made.
            let name = if field.name == "sweeps" { "sweeps_per_tick" } else { field.name };
            match field.kind {
                _ if field.value.is_empty() => {}
                SettingKind::Whole => map.serialize_entry(name, &word)?,
                SettingKind::Real => {
                    let real = Some(f32::from_bits(word)).filter(|real| real.is_finite());
                    map.serialize_entry(name, &real)?;
                }
                SettingKind::Choice(_) => map.serialize_entry(name, &text(field, word))?,
            }
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use chaincell_kernel::{Drive, Model, Unloading};

    use super::*;

    const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/plane9.chaincell");

    fn read(words: &[&str]) -> Result<SettingArgs, clap::Error> {
        let command = <SettingArgs as clap::Args>::augment_args(Command::new("chaincell"));
        let matches = command.no_binary_name(true).try_get_matches_from(words)?;
        SettingArgs::from_arg_matches(&matches)
    }

    #[test]
    fn each_setting_is_an_option() {
        let image = std::fs::read(DATA).unwrap();
        let image = crate::bake::ImageBytes::copy(&image);
        let defaults = Settings::for_model(&Model::from_bytes(image.as_bytes()).unwrap());
        assert_eq!(read(&[]).unwrap().over(defaults), defaults);
        let words = ["--sweeps=9", "--max-force-n=0.1", "--unloading=off", "--drive=current"];
        let args = read(&words).unwrap();
        let wanted = Settings {
            sweeps: 9,
            max_force_n: 0.1,
            unloading: Unloading::Off,
            drive: Drive::Current,
            ..defaults
        };
        assert_eq!(args.over(defaults), wanted);
        assert_eq!(args.shown("max_force_n"), "--max-force-n 0.1");
        assert_eq!(args.shown("step"), "--step");
        for bad in ["--sweeps=x", "--drive=x", "--step=x", "--tick-time=1"] {
            assert!(read(&[bad]).is_err(), "{bad}");
        }
    }
}
