//! Path files: one tool pose a row, `tick,x_m,y_m,z_m,engaged`, and where they were counted the
//! sweeps of its tick.

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
/// The same where the sweeps of each tick were counted.
pub const HEADER_WITH_SWEEPS: &str = "tick,x_m,y_m,z_m,engaged,sweeps";
/// Largest number of rows that is read: a day and a quarter at 1 kHz.
const ROWS_MAX: u64 = 100_000_000;
/// Longest line that is read, its end included: a row of five numbers is far shorter.
const LINE_BYTES_MAX: usize = 4096;

/// What a path may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rules {
    /// Ticks strictly consecutive, numbers finite, `engaged` 0 or 1.
    Strict,
    /// A recorded session: any number, any `engaged`, any order of ticks.
    Recorded,
}

/// Reads a path file: its sequences of poses, one unless the header stands again before a row of
/// a recorded session, where another controller took over and numbered anew.
///
/// # Errors
/// File, line and field of the first thing that breaks the rules, and the remedy.
pub fn read(path: &Path, rules: Rules) -> Result<Vec<Vec<Pose>>> {
    let file = input::open(path).map_err(|why| Error::file("open path", path, why))?;
    parse(BufReader::new(file), &path.display().to_string(), rules)
}

/// The same from any text; `name` stands for the file.
///
/// # Errors
/// As [`read`].
pub fn parse(text: impl BufRead, name: &str, rules: Rules) -> Result<Vec<Vec<Pose>>> {
    let mut sequences = Vec::new();
    let mut poses: Vec<Pose> = Vec::new();
    let mut header = String::new();
    each_line(text, name, |line, row| {
        if line == 1 {
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
            sequences.push(std::mem::take(&mut poses));
        } else {
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

/// Reads a text line by line, each told with its number from 1 on and without its end.
///
/// # Errors
/// A line that is too long, no text, one too many or compressed; that of `each`.
pub(super) fn each_line(
    mut text: impl BufRead,
    name: &str,
    mut each: impl FnMut(u64, &str) -> Result<()>,
) -> Result<()> {
    let mut bytes = Vec::new();
    for line in 1_u64.. {
        bytes.clear();
        read_line(&mut text, &mut bytes)
            .map_err(|why| Error::input(format!("{name}:{line}: cannot read: {why}")))?;
        if bytes.is_empty() {
            break;
        }
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
        let row = std::str::from_utf8(&bytes)
            .map_err(|_| Error::input(format!("{name}:{line}: not text: save it as CSV")))?;
        each(line, row.trim_end_matches(['\n', '\r']))?;
    }
    Ok(())
}

/// Reads a line with its end, a line feed, a carriage return or both in a row; of one that is too long no
/// more than a byte too many.
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

/// One row.
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

/// A field that is a whole number.
pub(super) fn whole(name: &str, text: &str) -> std::result::Result<u64, String> {
    text.parse().map_err(|_| format!("field {name} `{text}`: must be a whole number from 0"))
}

/// A field that is a number, by its name, text and unit.
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

/// The field `engaged`.
pub(super) fn engaged_of(text: &str, rules: Rules) -> std::result::Result<u32, String> {
    let told = || format!("field engaged `{text}`: must be 0 or 1");
    let engaged: u32 = text.parse().map_err(|_| told())?;
    if rules == Rules::Strict && engaged > 1 { Err(told()) } else { Ok(engaged) }
}

/// The field `sweeps`, where there is one.
pub(super) fn sweeps_of(fields: &[&str]) -> std::result::Result<Option<u16>, String> {
    match fields {
        [] | [""] => Ok(None),
        [text, ..] => text.parse().map(Some).map_err(|_| {
            format!("field sweeps `{text}`: must be from 0 to 65535, or empty for `--sweeps`")
        }),
    }
}

/// Whether a row may stand behind the last.
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

/// The text of a path file; decimals that read back as the same single-precision numbers. Where a
/// tick does not continue the count, a new one begins: the header stands once more. The column
/// `sweeps` is there where they were counted in a tick.
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

/// The end of a row: the sweeps of its tick where they were counted.
pub(super) fn end_row(text: &mut String, counted: bool, sweeps: Option<u16>) {
    let _ = match sweeps {
        _ if !counted => writeln!(text),
        None => writeln!(text, ","),
        Some(sweeps) => writeln!(text, ",{sweeps}"),
    };
}
