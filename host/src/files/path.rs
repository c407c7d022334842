//! Path files: each row is a tool pose, `tick,x_m,y_m,z_m,engaged`, with the sweeps of its tick if they were
//! counted.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::engine::motion::Pose;
use crate::engine::order::follows;
use crate::error::{Error, Result};
use crate::input;
use crate::text::{BYTE_ORDER_MARK, gzip};

/// First line of every path file.
pub const HEADER: &str = "tick,x_m,y_m,z_m,engaged";
/// First line if the sweeps of each tick were counted.
pub const HEADER_WITH_SWEEPS: &str = "tick,x_m,y_m,z_m,engaged,sweeps";
/// Largest number of rows that is read: more than a day at 1 kHz.
const ROWS_MAX: u64 = 100_000_000;
/// Longest line that is read, with its end: a row of five numbers is much shorter.
const LINE_BYTES_MAX: usize = 4096;

/// Rules for the content of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rules {
    /// Ticks are consecutive, numbers are finite, `engaged` is 0 or 1.
    Strict,
    /// A recorded session may have any number, any `engaged` and any order of ticks.
    Recorded,
}

/// Reads a path file. Returns its sequences of poses: a recorded session has a new one after each repeated
/// header, where another controller took over and numbered anew; other paths have one.
///
/// # Errors
/// File, line and field of the first violation of the rules, and the remedy.
pub fn read(path: &Path, rules: Rules) -> Result<Vec<Vec<Pose>>> {
    let file = input::open(path).map_err(|why| Error::file("open path", path, why))?;
    parse(BufReader::new(file), &path.display().to_string(), rules)
}

/// Like [`read`], from any text; `name` replaces the file's name.
///
/// # Errors
/// As [`read`].
pub fn parse(text: impl BufRead, name: &str, rules: Rules) -> Result<Vec<Vec<Pose>>> {
    let mut sequences = Vec::new();
    let mut poses: Vec<Pose> = Vec::new();
    let mut header = String::new();
    each_line(text, name, |line, row| {
        if line == 1 {
            // The first line is the header.
            header = row.strip_prefix(BYTE_ORDER_MARK).unwrap_or(row).to_owned();
            if header != HEADER && header != HEADER_WITH_SWEEPS {
                return Err(Error::input(format!(
                    "{name}:1: the header is `{}`; it must be `{HEADER}`, with `,sweeps` behind it \
                     where the sweeps are given",
                    row.escape_debug().take(60).collect::<String>()
                )));
            }
        } else if row.starts_with(HEADER) && row != header {
            return Err(Error::input(format!(
                "{name}:{line}: the header stands again as `{row}`; the first one is `{header}`"
            )));
        } else if row == header && rules == Rules::Recorded {
            // A repeated header starts the sequence of another controller.
            sequences.push(std::mem::take(&mut poses));
        } else {
            // A row has to continue the sequence.
            let pose = pose(row, &header, rules)
                .map_err(|why| Error::input(format!("{name}:{line}: {why}")))?;
            in_order(poses.last(), &pose, rules)
                .map_err(|why| Error::input(format!("{name}:{line}: {why}")))?;
            poses.push(pose);
        }
        Ok(())
    })?;
    sequences.push(poses);
    if sequences.iter().all(Vec::is_empty) {
        return Err(Error::input(format!("{name}: no rows: a path has a header and a row a tick")));
    }
    Ok(sequences)
}

/// Reads a text line by line. Calls `each` with the number of a line, from 1 on, and its text without the
/// line's end.
///
/// # Errors
/// A line that is too long, not text or compressed; too many lines; an error of `each`.
pub(super) fn each_line(
    mut text: impl BufRead,
    name: &str,
    mut each: impl FnMut(u64, &str) -> Result<()>,
) -> Result<()> {
    let mut bytes = Vec::new();
    for line in 1_u64.. {
        // Read the next line.
        bytes.clear();
        read_line(&mut text, &mut bytes)
            .map_err(|why| Error::input(format!("{name}:{line}: cannot read: {why}")))?;
        if bytes.is_empty() {
            break;
        }
        // Refuse a compressed file, a line that is too long, too many lines.
        if let (1, Some(why)) = (line, gzip(&bytes)) {
            return Err(Error::input(format!("{name}: {why}")));
        }
        if bytes.len() > LINE_BYTES_MAX {
            return Err(Error::input(format!(
                "{name}:{line}: the line has more than {LINE_BYTES_MAX} bytes: save it as CSV, one \
                 row a line"
            )));
        }
        if line > ROWS_MAX {
            return Err(Error::input(format!(
                "{name}:{line}: more than {ROWS_MAX} rows: split it"
            )));
        }
        // Pass the text on.
        let row = std::str::from_utf8(&bytes)
            .map_err(|_| Error::input(format!("{name}:{line}: not text: save it as CSV")))?;
        each(line, row.trim_end_matches(['\n', '\r']))?;
    }
    Ok(())
}

/// Reads a line with its end: a line feed, a carriage return, or both in a row. Stops one byte after the
/// longest line.
fn read_line(text: &mut impl BufRead, bytes: &mut Vec<u8>) -> std::io::Result<()> {
    while bytes.len() <= LINE_BYTES_MAX {
        let front = match text.fill_buf() {
            Err(why) if why.kind() == std::io::ErrorKind::Interrupted => continue,
            front => front?,
        };
        let is_split = bytes.last() == Some(&b'\r');
        if front.is_empty() || is_split && front[0] != b'\n' {
            break;
        }
        let end = if is_split {
            Some(0)
        } else {
            front.iter().position(|of| matches!(of, b'\n' | b'\r'))
        };
        let room = LINE_BYTES_MAX + 1 - bytes.len();
        let count = end.map_or(front.len(), |end| end + 1).min(room);
        bytes.extend_from_slice(&front[..count]);
        text.consume(count);
        if bytes.last() == Some(&b'\n') {
            break;
        }
    }
    Ok(())
}

/// Parses a row.
fn pose(row: &str, header: &str, rules: Rules) -> std::result::Result<Pose, String> {
    let fields: Vec<&str> = row.split(',').map(str::trim).collect();
    let wanted = header.split(',').count();
    let (&[tick, x, y, z, engaged, ref sweeps @ ..], true) =
        (fields.as_slice(), fields.len() == wanted)
    else {
        return Err(format!("{} fields; a row has {wanted}: {header}", fields.len()));
    };
    let tick = whole("tick", tick)?;
    let coordinate = |name: &str, text: &str| number((name, text, " [m]"), rules);
    let position_m = [coordinate("x_m", x)?, coordinate("y_m", y)?, coordinate("z_m", z)?];
    let engaged = engaged_of(engaged, rules)?;
    Ok(Pose { tick, position_m, engaged, sweeps: sweeps_of(sweeps)? })
}

/// Parses a field that is a whole number.
pub(super) fn whole(name: &str, text: &str) -> std::result::Result<u64, String> {
    text.parse().map_err(|_| format!("field {name} `{text}`: must be a whole number from 0"))
}

/// Parses a field that is a number, given by its name, text and unit.
pub(super) fn number(
    (name, text, unit): (&str, &str, &str),
    rules: Rules,
) -> std::result::Result<f32, String> {
    let value: f32 =
        text.parse().map_err(|_| format!("field {name} `{text}`: must be a number{unit}"))?;
    if rules == Rules::Strict && !value.is_finite() {
        return Err(format!(
            "field {name} `{text}`: must be finite in single precision; to replay a recorded \
             session with bad poses use run with `recorded`"
        ));
    }
    Ok(value)
}

/// Parses the field `engaged`.
pub(super) fn engaged_of(text: &str, rules: Rules) -> std::result::Result<u32, String> {
    let told = || format!("field engaged `{text}`: must be 0 or 1");
    let engaged: u32 = text.parse().map_err(|_| told())?;
    if rules == Rules::Strict && engaged > 1 { Err(told()) } else { Ok(engaged) }
}

/// Parses the field `sweeps`, if there is one.
pub(super) fn sweeps_of(fields: &[&str]) -> std::result::Result<Option<u16>, String> {
    match fields {
        [] | [""] => Ok(None),
        [text, ..] => text.parse().map(Some).map_err(|_| {
            format!("field sweeps `{text}`: must be from 0 to 65535, or empty for `--sweeps`")
        }),
    }
}

/// Checks that a row may follow the last one.
fn in_order(last: Option<&Pose>, pose: &Pose, rules: Rules) -> std::result::Result<(), String> {
    match last {
        Some(last) if rules == Rules::Strict && Some(pose.tick) != last.tick.checked_add(1) => {
            Err(format!(
                "field tick {}: must be {}, one above the row before; to replay a recorded session \
                 with lost poses use run with `recorded`",
                pose.tick,
                last.tick.saturating_add(1)
            ))
        }
        _ => Ok(()),
    }
}

/// Returns the text of a path file; its decimals read back as the same single-precision numbers. Before a
/// tick that does not continue the count, the header is repeated. There is a column `sweeps` if they were
/// counted in any tick.
#[must_use]
pub fn to_text(poses: impl IntoIterator<Item = Pose, IntoIter: Clone>) -> String {
    let poses = poses.into_iter();
    let counted = poses.clone().any(|pose| pose.sweeps.is_some());
    let header = if counted { HEADER_WITH_SWEEPS } else { HEADER };
    let mut text = format!("{header}\n");
    let mut last = None;
    for pose in poses {
        if last.is_some_and(|last| !follows(last, pose.tick)) {
            let _ = writeln!(text, "{header}");
        }
        last = Some(pose.tick);
        let [x, y, z] = pose.position_m;
        let _ = write!(text, "{},{x:?},{y:?},{z:?},{}", pose.tick, pose.engaged);
        end_row(&mut text, counted, pose.sweeps);
    }
    text
}

/// Ends a row, with the sweeps of its tick if the path has a column for them.
pub(super) fn end_row(text: &mut String, counted: bool, sweeps: Option<u16>) {
    let _ = match sweeps {
        _ if !counted => writeln!(text),
        None => writeln!(text, ","),
        Some(sweeps) => writeln!(text, ",{sweeps}"),
    };
}
