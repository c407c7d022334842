//! Words that depend on a number, and numbers in words.

use std::fmt;

/// A count with its noun in the singular or the plural: `1 sweep`, `2 sweeps`.
#[must_use]
pub fn counted(count: impl fmt::Display, noun: &str) -> String {
    let count = count.to_string();
    let ending = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// The share, 0 to 1, that a text like `1%` names.
#[must_use]
pub fn percent(text: &str) -> Option<f64> {
    let percent: f64 = text.strip_suffix('%')?.parse().ok()?;
    (0.0..=100.0).contains(&percent).then_some(percent / 100.0)
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
