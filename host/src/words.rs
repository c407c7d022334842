//! Words that depend on a number.

use std::fmt;

/// A count with its noun in the singular or the plural: `1 sweep`, `2 sweeps`.
#[must_use]
pub fn counted(count: impl fmt::Display, noun: &str) -> String {
    let count = count.to_string();
    let ending = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_the_only_singular() {
        assert_eq!(
            [0, 1, 2, 11].map(|n| counted(n, "sweep")),
            ["0 sweeps", "1 sweep", "2 sweeps", "11 sweeps"]
        );
    }
}
