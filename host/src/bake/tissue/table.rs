//! Tables of tissues as text: a line of names, then a tissue a line.

use std::path::Path;

use chaincell_kernel::image::BRANCHES_MAX;

use crate::error::{Error, Result};
use crate::text;

/// Largest file that is read \[B\].
const BYTES_MAX: u64 = 1 << 20;
/// Columns before those of the branches.
const FIRST: [&str; 5] = ["name", "tissue", "young_pa", "modulus", "poisson"];
/// Columns after those of the branches.
const LAST: [&str; 6] =
    ["stiffening_pa", "toughness_j_per_m2", "friction", "status", "source", "note"];
/// Number of branches for which a table has columns, unless a tissue has more.
pub(super) const BRANCHES: usize = 3;

/// Options whose values a row has, and their columns.
const COLUMNS: [(&str, &str); 5] = [
    ("young_pa", "young_pa"),
    ("poisson", "poisson"),
    ("branches", "g,tau_s"),
    ("stiffening", "stiffening_pa"),
    ("toughness_j_per_m2", "toughness_j_per_m2"),
];

/// A row of a file from which a tissue has values: a refusal of one of them names the file, the line and the column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableRow {
    /// File and line, as FILE:LINE.
    place: String,
    /// Options whose values are from elsewhere.
    given: Vec<&'static str>,
}

impl TableRow {
    /// A row of a line; `is_given` is true for an option whose value is from elsewhere.
    pub(super) fn new(place: &str, is_given: impl Fn(&str) -> bool) -> Self {
        let options = COLUMNS.iter().map(|&(option, _)| option);
        Self { place: place.to_owned(), given: options.filter(|option| is_given(option)).collect() }
    }

    /// Returns the place and the column of an option's value; `None` for one from elsewhere.
    pub(super) fn name(&self, option: &str) -> Option<String> {
        let column = COLUMNS.iter().find(|(known, _)| *known == option)?.1;
        (!self.given.contains(&option)).then(|| format!("{}: {column}", self.place))
    }
}

/// Returns the line of names of a table with columns for this number of branches.
pub(super) fn header(branches: usize) -> String {
    let [first, last] = [FIRST.join(","), LAST.join(",")];
    let pairs: String = (1..=branches).map(|at| format!(",g{at},tau{at}_s")).collect();
    format!("{first}{pairs},{last}")
}

/// Splits a line at its commas; a field in quotes may have some.
pub(super) fn fields(line: &str) -> Vec<&str> {
    let (mut fields, mut rest) = (Vec::new(), Some(line));
    while let Some(line) = rest {
        let quoted = line.strip_prefix('"').and_then(|line| line.split_once('"'));
        let (field, after) = match (quoted, line.split_once(',')) {
            (Some((field, after)), _) => (field, after.strip_prefix(',')),
            (None, Some((field, after))) => (field, Some(after)),
            (None, None) => (line, None),
        };
        fields.push(field.trim());
        rest = after;
    }
    fields
}

/// Returns a line of these fields, those with a comma in quotes; quotes and line ends of a field are replaced.
pub(super) fn line(fields: &[String]) -> String {
    let field = |field: &String| {
        let plain = field.replace('"', "'").replace(|c: char| c.is_control(), " ");
        if plain.contains(',') { format!("\"{plain}\"") } else { plain }
    };
    fields.iter().map(field).collect::<Vec<_>>().join(",")
}

/// Splits `FILE.csv` and `FILE.csv:NAME` into file and name; `None` for a text without a file.
pub(super) fn file_and_name(text: &str) -> Option<(&Path, Option<&str>)> {
    const END: &str = ".csv";
    if text.ends_with(END) {
        return Some((Path::new(text), None));
    }
    let (file, name) = text.rsplit_once(':')?;
    file.ends_with(END).then(|| (Path::new(file), Some(name)))
}

/// Reads the text of a table from a file, and checks its line of names.
///
/// # Errors
/// A file that cannot be read, a line of names that is none of a table, with the remedy.
pub(super) fn read(path: &Path) -> Result<String> {
    let text = text::read(path, BYTES_MAX).map_err(|why| Error::file("read tissues", path, why))?;
    let first = text.lines().next().unwrap_or_default().trim_end();
    if (0..=BRANCHES_MAX).any(|branches| header(branches) == first) {
        return Ok(text);
    }
    let begun: String = first.escape_debug().take(60).collect();
    Err(Error::input(format!(
        "{}:1: the header is \"{begun}\"; a table of tissues begins with {}, and may have columns for up to \
         {BRANCHES_MAX} branches",
        path.display(),
        header(BRANCHES)
    )))
}

/// Reads the number of a column, above 0.
pub(super) fn positive(column: &str, text: &str) -> std::result::Result<f64, String> {
    number(column, text, |number| number > 0.0, "a number above 0")
}

/// Reads the number of a column that fulfils `is_good`; `wanted` are the words for that.
pub(super) fn number(
    column: &str,
    text: &str,
    is_good: fn(f64) -> bool,
    wanted: &str,
) -> std::result::Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && is_good(*number));
    number.ok_or_else(|| format!("{column} is \"{}\"; give {wanted}", text.escape_debug()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_as_it_was_written() {
        let written = ["a", "b, c", "", "d"].map(str::to_owned);
        assert_eq!(line(&written), "a,\"b, c\",,d");
        assert_eq!(fields(&line(&written)), written);
        assert_eq!(line(&["5\" long,\nwide".to_owned()]), "\"5' long, wide\"");
    }

    #[test]
    fn a_file_is_known_by_its_end() {
        let file = |path: &'static str, name: Option<&'static str>| Some((Path::new(path), name));
        assert_eq!(file_and_name("a/b.csv"), file("a/b.csv", None));
        assert_eq!(file_and_name("b.csv:soft"), file("b.csv", Some("soft")));
        assert_eq!(file_and_name("muscle"), None);
        assert_eq!(file_and_name("b.txt:soft"), None);
    }
}
