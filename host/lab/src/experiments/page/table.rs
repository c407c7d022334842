//! Tables of a page, and rows as CSV.

/// A table of texts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// A table under way: what its rows are of, and the columns so far.
#[derive(Debug)]
pub struct Columns<T> {
    things: Vec<T>,
    table: Table,
}

impl<T: Copy> Columns<T> {
    /// Adds a column with its head; `cell` is what stands in the row of a thing.
    pub fn column<C: std::fmt::Display>(mut self, head: &str, cell: impl Fn(T) -> C) -> Self {
        self.table.head.push(head.to_owned());
        for (row, &thing) in self.table.rows.iter_mut().zip(&self.things) {
            row.push(cell(thing).to_string());
        }
        self
    }

    /// The table.
    pub fn table(self) -> Table {
        self.table
    }
}

impl Table {
    /// A table with a row for each thing, columns still to be added.
    pub fn of<T>(things: impl IntoIterator<Item = T>) -> Columns<T> {
        let things: Vec<T> = things.into_iter().collect();
        let rows = vec![Vec::new(); things.len()];
        Columns { things, table: Self { head: Vec::new(), rows } }
    }

    /// The head.
    pub fn head(&self) -> &[String] {
        &self.head
    }

    /// The rows in order.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }
}

/// CSV of rows, their fields in alphabetical order; nested ones are named `outer_inner`, commas
/// become semicolons.
pub fn csv(rows: &[impl serde::Serialize]) -> String {
    let mut text = String::new();
    for (at, row) in rows.iter().enumerate() {
        let mut fields = Vec::new();
        flatten("", &serde_json::to_value(row).unwrap_or_default(), &mut fields);
        if at == 0 {
            let names: Vec<&str> = fields.iter().map(|(name, _)| name.as_str()).collect();
            text += &format!("{}\n", names.join(","));
        }
        let values: Vec<&str> = fields.iter().map(|(_, value)| value.as_str()).collect();
        text += &format!("{}\n", values.join(","));
    }
    text
}

fn flatten(name: &str, value: &serde_json::Value, fields: &mut Vec<(String, String)>) {
    match value {
        serde_json::Value::Object(inner) => {
            for (key, value) in inner {
                let joined = if name.is_empty() { key.clone() } else { format!("{name}_{key}") };
                flatten(&joined, value, fields);
            }
        }
        serde_json::Value::String(text) => fields.push((name.to_owned(), text.replace(',', ";"))),
        serde_json::Value::Null => fields.push((name.to_owned(), String::new())),
        other => fields.push((name.to_owned(), other.to_string().replace(',', ";"))),
    }
}

/// A fraction in percent, to two significant digits; `-` for none and for what is no finite number.
pub fn percent(fraction: impl Into<Option<f64>>) -> String {
    let Some(fraction) = fraction.into().filter(|fraction: &f64| fraction.is_finite()) else {
        return "-".to_owned();
    };
    let percent = 100.0 * fraction;
    match percent.abs() {
        size if size >= 10.0 => format!("{percent:.0}"),
        size if size >= 1.0 => format!("{percent:.1}"),
        size if size >= 0.1 => format!("{percent:.2}"),
        0.0 => "0".to_owned(),
        _ => format!("{percent:.1e}"),
    }
}

/// Nanoseconds in microseconds.
pub fn us(ns: u64) -> String {
    let us = ns as f64 * 1e-3;
    if us < 10.0 { format!("{us:.2}") } else { format!("{us:.0}") }
}

/// A time for people: seconds below a minute, then minutes.
pub fn duration(seconds: f64) -> String {
    if seconds < 59.5 { format!("{seconds:.0} s") } else { format!("{:.1} min", seconds / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_and_numbers() {
        let table = Table::of([(1, "x")]).column("a", |row| row.0).column("b", |row| row.1).table();
        assert_eq!(
            (table.head(), table.rows()),
            (&["a", "b"].map(String::from)[..], &[vec!["1".to_owned(), "x".to_owned()]][..])
        );
        assert_eq!([0.123, 0.0123, 0.00123, 0.0].map(percent), ["12", "1.2", "0.12", "0"]);
        assert_eq!(percent(1e-7), "1.0e-5");
        assert_eq!([None, Some(f64::NAN), Some(f64::INFINITY)].map(percent), ["-", "-", "-"]);
        assert_eq!((us(1234), us(123_456)), ("1.23".into(), "123".into()));
    }

    #[test]
    fn csv_names_nested_fields() {
        #[derive(serde::Serialize)]
        struct Row {
            name: &'static str,
            at: (u8, u8),
            inner: Inner,
        }
        #[derive(serde::Serialize)]
        struct Inner {
            p50: f64,
        }
        let row = Row { name: "a,b", at: (1, 2), inner: Inner { p50: 0.5 } };
        assert_eq!(csv(&[row]), "at,inner_p50,name\n[1;2],0.5,a;b\n");
        assert_eq!(csv(&[] as &[Row]), "");
    }
}
