//! Choices in JSON: by their names.

use chaincell_kernel::Choice;
use serde::Serializer;

/// For `#[serde(serialize_with)]`: a choice by its name.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<T: Choice, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(value.name())
}

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
