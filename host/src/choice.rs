//! Values in JSON: choices by their names, others by their texts.

use chaincell_kernel::Choice;
use serde::{Deserialize, Deserializer, Serializer};

/// For `#[serde(with)]`: a choice by its name.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<T: Choice, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(value.name())
}

/// For `#[serde(with)]`: a choice by its name.
///
/// # Errors
/// A text that is no name.
pub fn deserialize<'de, T: Choice, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    named(&String::deserialize(from)?)
}

fn named<T: Choice, E: serde::de::Error>(name: &str) -> Result<T, E> {
    T::from_name(name).ok_or_else(|| E::custom(format!("\"{name}\" is not {}", names::<T>())))
}

/// For `#[serde(with)]`: a choice by its name, or null.
pub mod optional {
    use chaincell_kernel::Choice;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Writes the name, or null.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<T: Choice, S: Serializer>(
        value: &Option<T>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        value.map(Choice::name).serialize(to)
    }

    /// Reads a name, or null.
    ///
    /// # Errors
    /// A text that is no name.
    pub fn deserialize<'de, T: Choice, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<T>, D::Error> {
        Option::<String>::deserialize(from)?.map(|name| super::named(&name)).transpose()
    }
}

/// Makes types values of JSON by the text that [`std::fmt::Display`] writes and [`std::str::FromStr`] reads.
macro_rules! by_text {
    ($($type:ty),*) => {$(
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(
                &self,
                to: S,
            ) -> std::result::Result<S::Ok, S::Error> {
                to.collect_str(self)
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(
                from: D,
            ) -> std::result::Result<Self, D::Error> {
                let text = <String as serde::Deserialize>::deserialize(from)?;
                text.parse::<Self>().map_err(|why| serde::de::Error::custom(format!("\"{text}\": {why}")))
            }
        }
    )*};
}
pub(crate) use by_text;

/// Every name of a choice in a sentence: `a, b or c`.
#[must_use]
pub fn names<T: Choice>() -> String {
    let names: Vec<&str> = T::ALL.iter().map(|value| value.name()).collect();
    names.split_last().map_or(String::new(), |(last, others)| {
        if others.is_empty() {
            (*last).to_owned()
        } else {
            format!("{} or {last}", others.join(", "))
        }
    })
}
