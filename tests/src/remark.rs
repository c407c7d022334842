//! Rows that commands print for people: a name, and words.

/// The row of a remark, or nothing.
#[must_use]
pub fn row(out: &str, name: &str) -> Option<String> {
    let rest =
        |line: &str| line.trim_start().strip_prefix(name)?.strip_prefix(' ').map(str::to_owned);
    out.lines().find_map(rest).map(|row| row.trim_start().to_owned())
}

/// A remark with all of these words.
#[track_caller]
pub fn says(out: &str, name: &str, words: &[&str]) {
    let found = row(out, name).unwrap_or_default();
    for word in words {
        assert!(found.contains(word), "{name}: `{word}` is missing in `{found}` of {out}");
    }
}
