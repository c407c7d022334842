//! A measured curve: strain or displacement, and stress or force, in time.

use std::path::Path;

use chaincell_host::error::{Error, Result};
use chaincell_host::text;

/// Largest file that is read \[B\].
const BYTES_MAX: u64 = 16 << 20;
/// Columns of the strain with what is taken off them.
const STRAINS: [(&str, f64); 3] = [("strain", 0.0), ("stretch", 1.0), ("displacement_m", 0.0)];
/// Ends of the names of columns of the response, their factor to the unit, and the unit of the modulus.
const RESPONSES: [(&str, f64, &str); 3] =
    [("stress_pa", 1.0, "Pa"), ("stress_kpa", 1e3, "Pa"), ("force_n", 1.0, "N")];
/// Share of the last strain by which the strain of a hold may vary.
const HOLD: f64 = 1e-3;

/// A curve from rest, strains and responses as a press counts: both above 0 at the largest strain.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Times \[s\] and strains; the first point is rest.
    pub points: Vec<[f64; 2]>,
    /// The stress \[Pa\] or force \[N\] at each point.
    pub response: Vec<f64>,
    /// Unit of the modulus: Pa, N for a force over a strain, N/m for one over a displacement.
    pub unit: &'static str,
    /// Number of points at the end in which the strain is held.
    pub held: usize,
}

/// Places of the columns in a row, and what they mean.
struct Columns {
    time: usize,
    strain: (usize, f64),
    response: (usize, f64),
    unit: &'static str,
}

impl Columns {
    fn of(header: &str, name: &str) -> Result<Self> {
        let names: Vec<&str> = header.split(',').map(str::trim).collect();
        let place = |wanted: &dyn Fn(&str) -> bool| names.iter().position(|of| wanted(of));
        let time = place(&|of| of == "time_s");
        let strain = STRAINS.iter().find_map(|&(column, off)| {
            Some((place(&|of| of == column)?, off, column == "displacement_m"))
        });
        let response = RESPONSES
            .iter()
            .find_map(|&(end, factor, unit)| Some((place(&|of| of.ends_with(end))?, factor, unit)));
        let (Some(time), Some((strain, off, is_length)), Some((response, factor, unit))) =
            (time, strain, response)
        else {
            return Err(Error::input(format!(
                "{name}:1: the header is `{}`; a curve has the columns time_s, one of strain, stretch or \
                 displacement_m, and one of force_n, stress_pa or stress_kpa",
                header.escape_debug().take(60).collect::<String>()
            )));
        };
        let unit = if is_length && unit == "N" { "N/m" } else { unit };
        if is_length && unit == "Pa" {
            return Err(Error::input(format!(
                "{name}:1: a stress over a displacement has no modulus; give strain or stretch, or force_n"
            )));
        }
        Ok(Self { time, strain: (strain, off), response: (response, factor), unit })
    }
}

/// Reads a curve.
///
/// # Errors
/// File and line of the first thing that cannot be used, and the remedy.
pub fn read(path: &Path) -> Result<Curve> {
    let text = text::read(path, BYTES_MAX).map_err(|why| Error::file("read curve", path, why))?;
    parse(&text, &path.display().to_string())
}

/// The same from text; `name` stands for the file.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, name: &str) -> Result<Curve> {
    let text = text.trim_start_matches('\u{feff}');
    let columns = Columns::of(text.lines().next().unwrap_or_default(), name)?;
    let (mut points, mut response) = (vec![[0.0; 2]], vec![0.0]);
    for (line, row) in (1..).zip(text.lines()).skip(1).filter(|(_, row)| !row.trim().is_empty()) {
        let refuse = |why: String| Error::input(format!("{name}:{line}: {why}"));
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        let number = |at: usize| {
            let text = fields.get(at).copied().unwrap_or_default();
            let value = text.parse().ok().filter(|x: &f64| x.is_finite());
            value.ok_or_else(|| refuse(format!("`{text}` in column {}: give a number", at + 1)))
        };
        let time_s = number(columns.time)?;
        let last_s = points.last().map_or(0.0, |point| point[0]);
        // The first row may stand at time 0, after a jump.
        if time_s < last_s || (time_s == last_s && points.len() > 1) {
            return Err(refuse(format!(
                "time_s {time_s}: must ascend from 0 on, where the tissue rests; sort the rows by time, and \
                 count from the start of the motion"
            )));
        }
        points.push([time_s, number(columns.strain.0)? - columns.strain.1]);
        response.push(number(columns.response.0)? * columns.response.1);
    }
    if response.len() == 1 {
        return Err(Error::input(format!(
            "{name}: no rows under the header; give one for each time, from the start of the press to the end of the \
             hold"
        )));
    }
    if points.iter().all(|point| point[1] == 0.0) {
        return Err(Error::input(format!(
            "{name}: the strain is 0 in all rows; give in each row how far the tissue is strained then, also while it \
             is held"
        )));
    }
    forward(&mut points, &mut response, name)?;
    let last = points.last().map_or(0.0, |point| point[1]);
    let is_held = |point: &&[f64; 2]| (point[1] - last).abs() <= HOLD * last.abs();
    let held = points.iter().rev().take_while(is_held).count();
    Ok(Curve { points, response, unit: columns.unit, held })
}

/// Turns strains and responses so that both are above 0 where the strain is largest.
fn forward(points: &mut [[f64; 2]], response: &mut [f64], name: &str) -> Result<()> {
    let size = |of: &([f64; 2], f64)| of.0[1].abs();
    let largest = points.iter().copied().zip(response.iter().copied());
    let largest = largest.max_by(|a, b| size(a).total_cmp(&size(b)));
    let (strain, felt) = largest.map_or((0.0, 0.0), |([_, strain], felt)| (strain, felt));
    if strain * felt <= 0.0 {
        return Err(Error::input(format!(
            "{name}: the response to the largest strain, {strain}, is {felt}: both must have one sign, and be not 0; \
             turn the sign of one column, or take a part of the curve that begins at rest"
        )));
    }
    if strain < 0.0 {
        points.iter_mut().for_each(|point| point[1] = -point[1]);
        response.iter_mut().for_each(|felt| *felt = -*felt);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_turned_forward() {
        let text = "curve,time_s,stretch,cauchy_stress_kpa\na,1,0.9,-2\na,2,0.8,-4\na,3,0.8,-3\n";
        let curve = parse(text, "x").unwrap();
        let strains = curve.points.iter().map(|point| (point[1] * 1e3).round() / 1e3);
        assert!(strains.eq([0.0, 0.1, 0.2, 0.2]));
        assert_eq!(curve.response, [0.0, 2e3, 4e3, 3e3]);
        assert_eq!((curve.unit, curve.held), ("Pa", 2));
        let push = parse("time_s,displacement_m,force_n\n0,0.001,1\n1,0.001,0.5\n", "x").unwrap();
        assert_eq!((push.unit, push.held), ("N/m", 2));
        assert_eq!(push.points[..2], [[0.0, 0.0], [0.0, 0.001]]);
    }

    #[test]
    fn what_is_no_curve_is_refused_by_line() {
        for (text, part) in [
            ("time_s,force_n\n", "x:1: the header is `time_s,force_n`"),
            ("time_s,displacement_m,stress_pa\n", "has no modulus"),
            ("time_s,strain,force_n\n1,0.1,y\n", "x:2: `y` in column 3"),
            ("time_s,strain,force_n\n1,0.1\n", "x:2: `` in column 3"),
            ("time_s,strain,force_n\n1,0.1,1\n1,0.2,1\n", "x:3: time_s 1: must ascend"),
            ("time_s,strain,force_n\n-1,0.1,1\n", "x:2: time_s -1"),
            ("time_s,strain,force_n\n1,0.1,-1\n", "both must have one sign"),
            ("time_s,strain,force_n\n", "x: no rows under the header; give one"),
            ("time_s,strain,force_n\n\n0,0,0\n1,0,2\n", "x: the strain is 0 in all rows; give"),
            ("time_s,stretch,force_n\n0,1,0\n1,1,2\n", "x: the strain is 0 in all rows; give"),
        ] {
            let why = parse(text, "x").unwrap_err().to_string();
            assert!(why.contains(part), "{why}");
        }
    }
}
