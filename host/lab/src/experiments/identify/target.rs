//! What was measured: curves and displacement fields, read from CSV files.

use std::path::Path;

use chaincell_host::error::{Error, Result};

/// Header of a force-displacement curve.
pub const PRESS_HEADER: &str = "displacement_m,force_n";
/// Header of such a curve with the quartiles of every force.
pub const QUARTILES_HEADER: &str = "displacement_m,force_n,q25_n,q75_n";
/// Header of a force along a path of the tool in time.
pub const PATH_HEADER: &str = "time_s,displacement_m,force_n";
/// Quartiles of a normal distribution from its middle [standard deviations].
const QUARTILE: f64 = 0.6745;
/// Header of a relaxation curve.
pub const RELAXATION_HEADER: &str = "time_s,force_n";
/// Header of a displacement field.
pub const FIELD_HEADER: &str = "node,ux_m,uy_m,uz_m";
/// Fewest rows of a target.
pub const ROWS_MIN: usize = 5;
/// Largest file that is read \[bytes\].
const BYTES_MAX: u64 = 64 << 20;

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Force of the tool in equilibrium as the displacement grows.
    Press,
    /// Force of the tool after a displacement in one step at t = 0.
    Relaxation,
    /// Force of the tool along a path in time, from rest at t = 0.
    Path,
    /// Displacements of nodes in equilibrium.
    Field,
}

/// Measured data with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Name for messages, charts and tables: the file's.
    pub name: String,
    /// What was measured.
    pub kind: Kind,
    /// Displacement of the tool along its direction: of each row of a press, ascending, and of a path,
    /// straight in between; the only one of a relaxation or a field \[m\].
    pub displacement_m: Vec<f64>,
    /// Time of each row of a relaxation or a path, ascending \[s\].
    pub time_s: Vec<f64>,
    /// Input ids of a field, each once.
    pub nodes: Vec<u32>,
    /// The measured numbers, row by row: force along the direction that the tool exerts \[N\], three
    /// displacements a node of a field \[m\].
    pub observed: Vec<f64>,
    /// Standard deviation of each number, where the data says so.
    pub deviation: Option<Vec<f64>>,
    /// Direction of the push, a unit vector, where it is not that of the bench.
    pub direction: Option<[f64; 3]>,
}

impl Target {
    fn new(
        name: impl Into<String>,
        kind: Kind,
        displacement_m: Vec<f64>,
        observed: Vec<f64>,
    ) -> Self {
        let (name, time_s, nodes) = (name.into(), Vec::new(), Vec::new());
        let (deviation, direction) = (None, None);
        Self { name, kind, displacement_m, time_s, nodes, observed, deviation, direction }
    }

    /// Forces of a growing press.
    #[must_use]
    pub fn press(name: impl Into<String>, displacement_m: Vec<f64>, force_n: Vec<f64>) -> Self {
        Self::new(name, Kind::Press, displacement_m, force_n)
    }

    /// Forces after a step.
    #[must_use]
    pub fn relaxation(
        name: impl Into<String>,
        displacement_m: f64,
        time_s: Vec<f64>,
        force_n: Vec<f64>,
    ) -> Self {
        Self { time_s, ..Self::new(name, Kind::Relaxation, vec![displacement_m], force_n) }
    }

    /// Displacements of nodes.
    #[must_use]
    pub fn field(
        name: impl Into<String>,
        displacement_m: f64,
        nodes: Vec<u32>,
        observed_m: Vec<f64>,
    ) -> Self {
        Self { nodes, ..Self::new(name, Kind::Field, vec![displacement_m], observed_m) }
    }

    /// The same with the quartiles of each number as its error.
    #[must_use]
    pub fn with_quartiles(self, quartiles: impl Iterator<Item = [f64; 2]>) -> Self {
        let deviation = quartiles.map(|[low, high]| 0.5 * (high - low) / QUARTILE);
        Self { deviation: Some(deviation.collect()), ..self }
    }

    /// Whether it shows what happens in time.
    #[must_use]
    pub fn is_in_time(&self) -> bool {
        matches!(self.kind, Kind::Relaxation | Kind::Path)
    }

    /// Largest displacement of the tool \[m\].
    #[must_use]
    pub fn depth_m(&self) -> f64 {
        self.displacement_m.iter().fold(0.0, |most, d| most.max(d.abs()))
    }

    /// Rows: points of a curve, nodes of a field.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.observed.len() / self.width()
    }

    /// Numbers a row.
    #[must_use]
    pub fn width(&self) -> usize {
        if self.kind == Kind::Field { 3 } else { 1 }
    }

    /// Root mean square of the measured numbers.
    #[must_use]
    pub fn scale(&self) -> f64 {
        rms(&self.observed)
    }

    /// Kind in words, its unit.
    #[must_use]
    pub fn words(&self) -> (&'static str, &'static str) {
        match self.kind {
            Kind::Press => ("force-displacement", "N"),
            Kind::Relaxation => ("relaxation", "N"),
            Kind::Path => ("path in time", "N"),
            Kind::Field => ("field", "m"),
        }
    }
}

/// Root mean square, 0 of nothing.
#[must_use]
pub fn rms(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|x| x * x).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

/// What a file leaves open.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Holding {
    /// `--displacement-m`, of relaxation curves and fields.
    pub displacement_m: Option<f64>,
    /// `--force-n`, the tool's force with a field.
    pub force_n: Option<f64>,
}

/// Reads a target; its header says what it is. A field with `--force-n` gives two.
///
/// # Errors
/// File and line of the first thing that cannot be used, and the remedy.
pub fn read(path: &Path, holding: &Holding) -> Result<Vec<Target>> {
    let text = chaincell_host::text::read(path, BYTES_MAX)
        .map_err(|why| Error::file("read --target", path, why))?;
    parse(&text, &path.display().to_string(), holding)
}

/// The same from text; `name` stands for the file.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, name: &str, holding: &Holding) -> Result<Vec<Target>> {
    let text = text.trim_start_matches('\u{feff}');
    let header = text.lines().next().unwrap_or_default().trim();
    // The header says what the columns are.
    let rows = |width| Rows { name, header }.read(text, width);
    let by_time = "sort the rows by time";
    let target = match header {
        PRESS_HEADER | QUARTILES_HEADER => {
            let rows = rows(if header == PRESS_HEADER { 2 } else { 4 })?;
            let hint = "keep the loading branch alone";
            let displacement_m = ascending(name, "displacement_m", &rows, hint)?;
            let press = Target::press(name, displacement_m, column_of(&rows, 1));
            match header {
                PRESS_HEADER => press,
                _ => press.with_quartiles(quartiles(name, &rows)?.into_iter()),
            }
        }
        PATH_HEADER => {
            let rows = rows(3)?;
            let time_s = ascending(name, "time_s", &rows, by_time)?;
            let path = Target::new(name, Kind::Path, column_of(&rows, 1), column_of(&rows, 2));
            Target { time_s, ..path }
        }
        RELAXATION_HEADER => {
            let (rows, displacement_m) = (rows(2)?, held(name, holding)?);
            let time_s = ascending(name, "time_s", &rows, by_time)?;
            Target::relaxation(name, displacement_m, time_s, column_of(&rows, 1))
        }
        FIELD_HEADER => field(name, &rows(4)?, held(name, holding)?)?,
        other => {
            return Err(Error::input(format!(
                "{name}:1: the header is `{}`; a target begins with `{PRESS_HEADER}`, \
                 `{QUARTILES_HEADER}`, `{RELAXATION_HEADER}`, `{PATH_HEADER}` or `{FIELD_HEADER}`",
                other.escape_debug().take(60).collect::<String>()
            )));
        }
    };
    // A target that no parameter changes fits nothing.
    if target.scale() == 0.0 {
        return Err(Error::input(format!(
            "{name}: every value is 0, which no parameter changes; give a target that moves"
        )));
    }
    // The force with a field is a press of one row.
    let mut targets = vec![target];
    if let (Kind::Field, Some(force_n)) = (targets[0].kind, holding.force_n) {
        if !(force_n.is_finite() && force_n > 0.0) {
            return Err(Error::input(format!("--force-n {force_n}: must be above 0 and finite")));
        }
        let name = format!("{name} --force-n");
        targets.push(Target::press(name, targets[0].displacement_m.clone(), vec![force_n]));
    }
    Ok(targets)
}

/// The tool's displacement, for files that do not hold it.
fn held(name: &str, holding: &Holding) -> Result<f64> {
    match holding.displacement_m {
        Some(d) if d.is_finite() && d > 0.0 => Ok(d),
        Some(d) => Err(Error::input(format!("--displacement-m {d}: must be above 0 and finite"))),
        None => Err(Error::input(format!(
            "{name}: a relaxation curve or a field needs the tool's displacement: --displacement-m"
        ))),
    }
}

/// Rows of numbers below a header.
struct Rows<'a> {
    name: &'a str,
    header: &'a str,
}

impl Rows<'_> {
    /// Line number and fields of every row.
    fn read(&self, text: &str, width: usize) -> Result<Vec<(usize, Vec<f64>)>> {
        let mut rows = Vec::new();
        for (line, row) in (1..).zip(text.lines()).skip(1) {
            if !row.trim().is_empty() {
                rows.push((line, self.row(line, row, width)?));
            }
        }
        if rows.len() < ROWS_MIN {
            return Err(Error::input(format!(
                "{}: {} rows; a target needs at least {ROWS_MIN}",
                self.name,
                rows.len()
            )));
        }
        Ok(rows)
    }

    fn row(&self, line: usize, row: &str, width: usize) -> Result<Vec<f64>> {
        let refuse = |why: String| Error::input(format!("{}:{line}: {why}", self.name));
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        if fields.len() != width {
            return Err(refuse(format!(
                "{} fields; a row has {width}: {}",
                fields.len(),
                self.header
            )));
        }
        let names = self.header.split(',');
        let numbers = fields.iter().zip(names).map(|(text, name)| {
            text.parse()
                .ok()
                .filter(|x: &f64| x.is_finite())
                .ok_or_else(|| refuse(format!("field {name} `{text}`: must be a finite number")))
        });
        numbers.collect()
    }
}

/// The first column of a curve, checked to be 0 or more and to ascend.
fn ascending(name: &str, column: &str, rows: &[(usize, Vec<f64>)], hint: &str) -> Result<Vec<f64>> {
    let mut last = None;
    for (line, row) in rows {
        let refuse = |why: &str| {
            Err(Error::input(format!("{name}:{line}: field {column} {}: {why}", row[0])))
        };
        if row[0] < 0.0 {
            return refuse("must be 0 or more; --direction says which way is forward");
        }
        if last.is_some_and(|last| row[0] <= last) {
            return refuse(&format!("must be above that of the row before; {hint}"));
        }
        last = Some(row[0]);
    }
    Ok(column_of(rows, 0))
}

/// A column of the rows.
fn column_of(rows: &[(usize, Vec<f64>)], at: usize) -> Vec<f64> {
    rows.iter().map(|(_, row)| row[at]).collect()
}

/// The quartiles of each row, which are on either side of the force.
fn quartiles(name: &str, rows: &[(usize, Vec<f64>)]) -> Result<Vec<[f64; 2]>> {
    let each = rows.iter().map(|(line, row)| {
        let (force, low, high) = (row[1], row[2], row[3]);
        if low <= force && force <= high && low < high {
            return Ok([low, high]);
        }
        Err(Error::input(format!(
            "{name}:{line}: fields q25_n {low}, q75_n {high}: must be on either side of force_n \
             {force}, and differ"
        )))
    });
    each.collect()
}

fn field(name: &str, rows: &[(usize, Vec<f64>)], displacement_m: f64) -> Result<Target> {
    let mut nodes = Vec::with_capacity(rows.len());
    let mut seen = std::collections::BTreeSet::new();
    for (line, row) in rows {
        let node = row[0];
        if !(node.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&node)) {
            return Err(Error::input(format!(
                "{name}:{line}: field node {node}: must be a whole number from 0"
            )));
        }
        if !seen.insert(node as u32) {
            return Err(Error::input(format!(
                "{name}:{line}: node {node} is given twice; give it once"
            )));
        }
        nodes.push(node as u32);
    }
    let observed_m = rows.iter().flat_map(|(_, row)| row[1..].iter().copied()).collect();
    Ok(Target::field(name, displacement_m, nodes, observed_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str, holding: &Holding, part: &str) {
        let error = parse(text, "t.csv", holding).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        let error = error.to_string();
        assert!(error.contains(part), "{error}");
    }

    const AT: Holding = Holding { displacement_m: Some(0.01), force_n: None };

    #[test]
    fn the_header_says_what_a_target_is() {
        let rows = "0,0\n1,2\n2,3\n3,5\n4,6\n";
        let press = parse(&format!("{PRESS_HEADER}\n{rows}"), "a", &Holding::default()).unwrap();
        assert_eq!((press[0].words().0, press[0].rows()), ("force-displacement", 5));
        let time = parse(&format!("{RELAXATION_HEADER}\n{rows}"), "b", &AT).unwrap();
        assert_eq!(time[0].words().0, "relaxation");
        let rows = "0,0,0\n1,1,2\n2,1,3\n3,1,5\n4,1,6\n";
        let path = parse(&format!("{PATH_HEADER}\n{rows}"), "p", &Holding::default()).unwrap();
        assert!(path[0].is_in_time() && path[0].depth_m() == 1.0);
        let rows = "0,1,0,2\n1,2,1,3\n2,3,1,5\n3,5,4,6\n4,6,5,7\n";
        let spread = format!("{QUARTILES_HEADER}\n{rows}");
        let spread = parse(&spread, "q", &Holding::default()).unwrap();
        let deviation = spread[0].deviation.as_ref().unwrap();
        assert!((deviation[0] - 1.0 / 0.6745).abs() < 1e-12 && deviation[2] > deviation[0]);
        let rows = "5,0,0,1\n4,0,0,1\n3,0,1,0\n2,0,0,0\n1,2,0,0\n";
        let holding = Holding { force_n: Some(2.0), ..AT };
        let field = parse(&format!("{FIELD_HEADER}\r\n{rows}"), "c", &holding).unwrap();
        assert_eq!((field.len(), field[0].observed.len(), field[1].rows()), (2, 15, 1));
    }

    #[test]
    fn bad_targets_are_named_by_line() {
        let press = |rows: &str| format!("{PRESS_HEADER}\n{rows}");
        let good = "0,0\n1,2\n2,3\n3,5\n";
        refused("x,y\n1,2\n", &AT, "t.csv:1: the header is `x,y`");
        refused("", &AT, "t.csv:1");
        refused(&press("0,0\n1\n"), &AT, "t.csv:3: 1 fields");
        refused(&press("0,0\n1,abc\n"), &AT, "t.csv:3: field force_n `abc`");
        refused(&press("0,0\n1,inf\n"), &AT, "t.csv:3: field force_n `inf`");
        refused(&press("0,0\n1,2\n"), &AT, "2 rows; a target needs at least 5");
        refused(&press(&format!("{good}2.5,1\n")), &AT, "t.csv:6: field displacement_m 2.5");
        refused(&press(&format!("-1,0\n{good}")), &AT, "t.csv:2: field displacement_m -1");
        refused(&press("0,0\n1,0\n2,0\n3,0\n4,0\n"), &AT, "every value is 0");
        let spread =
            |row: &str| format!("{QUARTILES_HEADER}\n0,1,0,2\n1,2,1,3\n2,3,1,5\n3,5,4,6\n{row}\n");
        refused(&spread("4,6,7,8"), &AT, "t.csv:6: fields q25_n 7, q75_n 8");
        refused(&spread("4,6,6,6"), &AT, "t.csv:6: fields q25_n 6, q75_n 6");
        let path = format!("{PATH_HEADER}\n0,0,0\n1,1,2\n1,1,3\n3,1,5\n4,1,6\n");
        refused(&path, &AT, "t.csv:4: field time_s 1");
        let time = format!("{RELAXATION_HEADER}\n{good}4,6\n");
        refused(&time, &Holding::default(), "--displacement-m");
        let bad = Holding { displacement_m: Some(f64::NAN), ..AT };
        refused(&time, &bad, "--displacement-m NaN");
        let field = |rows: &str| format!("{FIELD_HEADER}\n0,0,0,1\n1,0,0,1\n2,0,0,1\n{rows}");
        refused(&field("1.5,0,0,1\n3,0,0,1\n"), &AT, "t.csv:5: field node 1.5");
        refused(&field("1,0,0,1\n3,0,0,1\n"), &AT, "t.csv:5: node 1 is given twice");
        let bad = Holding { force_n: Some(-1.0), ..AT };
        refused(&field("3,0,0,1\n4,0,0,1\n"), &bad, "--force-n -1");
    }
}
